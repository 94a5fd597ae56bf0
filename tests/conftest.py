"""Robots, oracles and named tolerances that several tests share."""

from __future__ import annotations

import copy
import functools
import gc
import math
import os
import pickle
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik.robot import JointType, Mass

from .thinning import deselected, mostly_slow

EXACT = 1e-12
"""Rounding of some dozens of operations on numbers of order one."""

DIFFERENCES = 1e-6
"""Central differences with step 1e-5: truncation 1e-10 and rounding 2e-11, times third derivatives up to 1e4."""

ACCEPTED_RISE = 1e-13
"""Relative rise of V that is a rounding error of its evaluation."""

# the libraries that the package ziglang builds for itself at its first call, once for all tests
os.environ.setdefault("ZIG_GLOBAL_CACHE_DIR", str(Path.home() / ".cache" / "zig"))

# no compiler of one test runs beside the next
os.environ.setdefault("JTIK_COMPILED", "off")

LARGE = ("jparse", "lexicographic_qp", "mink", "selectively_damped", "sns", "sns_qp", "weighted_qp")
"""Strategies with a large compiled step: a solver with one of them takes several times as long to build."""


FAMILIES = ("damped", "hybrid", "newton", "task_priority", "transpose", "weighted_qp")
"""Strategies of different families: adaptive damping, a dogleg, the pseudoinverse, levels, the gradient, one QP. A
quick test of what every strategy does alike runs with these."""


def pytest_addoption(parser):
    parser.addoption("--full", action="store_true", help="run all tests that are marked thinned")


@pytest.hookimpl(tryfirst=True)  # before -m selects
def pytest_collection_modifyitems(config, items):
    for item in mostly_slow(items):
        item.add_marker(pytest.mark.slow)
    dropped = set() if config.getoption("--full") else deselected(items)
    if dropped:
        config.hook.pytest_deselected(items=[item for item in items if item in dropped])
        items[:] = [item for item in items if item not in dropped]


def slow(*values):
    """Values of a parameter whose tests are marked slow."""
    return [pytest.param(value, marks=pytest.mark.slow) for value in values]


def large_ones_slow(strategies):
    """The strategies as values of a parameter; the tests of those with a large compiled step are marked slow."""
    return [pytest.param(name, marks=pytest.mark.slow) if name in LARGE else name for name in strategies]


def families_first(strategies, *, large=True):
    """The strategies as values of a parameter; the tests of those that are not in `FAMILIES` are marked slow.

    Without ``large`` those with a large compiled step are marked slow as well.
    """
    quick = set(FAMILIES) if large else set(FAMILIES) - set(LARGE)
    return [
        pytest.param(name, marks=pytest.mark.slow) if name in jtik.strategies and name not in quick else name
        for name in strategies
    ]


@functools.cache
def planar(n, **options):
    """A planar arm, cached by its arguments: a robot compiles its kinematics once."""
    return jtik.Robot.planar(n, **options)


BUILT = {}
"""Solvers by their pickled arguments, the last ones."""


def shared_solver(robot, task, **options):
    """A copy of a solver that is built once for equal arguments: state and parameters are its own.

    Arguments that cannot be pickled, as a criterion of a test's own, make a solver that is not shared. Building one
    takes 50 to 500 ms, and a copy 2 to 10 ms. A test of what building does builds its own, and so does one that changes
    what building uses.
    """
    try:
        arguments = pickle.dumps((robot, task, options))
    except (pickle.PicklingError, AttributeError, TypeError):
        return jtik.InverseKinematics(robot, task, **options)
    if arguments not in BUILT:
        BUILT[arguments] = jtik.InverseKinematics(robot, task, **options)
        if len(BUILT) > 100:
            del BUILT[next(iter(BUILT))]
    return copy.copy(BUILT[arguments])


@functools.cache
def dh_arm(n=7, seed=0, limit=math.inf):
    """A random spatial arm whose neighbouring axes are never parallel, with links of 0.1 to 0.5 m."""
    rng = np.random.default_rng(seed)
    rows = [
        {
            "a": rng.uniform(0.1, 0.4),
            "alpha": rng.choice([-1, 1]) * rng.uniform(0.7, 1.6),
            "d": rng.uniform(0.0, 0.3),
            "theta": rng.uniform(-1, 1),
            "lower": -limit,
            "upper": limit,
        }
        for _ in range(n)
    ]
    return jtik.Robot.from_dh(rows, name=f"dh{n}-{seed}")


def _pose(translation, rotvec=(0.0, 0.0, 0.0)):
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_rotvec(rotvec).as_matrix()
    pose[:3, 3] = translation
    return pose


@functools.cache
def ball_arm():
    """Shoulder and wrist are ball joints, between them an elbow and a limited prismatic joint: nq = 10, n = 8."""
    y = np.array([0.0, 1.0, 0.0])
    return jtik.Robot(
        [
            jtik.Joint("shoulder", JointType.BALL, "base", "upper", origin=_pose((0, 0, 0.3), (0.2, 0.1, 0))),
            jtik.Joint("elbow", JointType.REVOLUTE, "upper", "fore", origin=_pose((0.5, 0, 0)), axis=y),
            jtik.Joint("lift", JointType.PRISMATIC, "fore", "rod", origin=_pose((0.3, 0, 0)), lower=-0.1, upper=0.2),
            jtik.Joint("wrist", JointType.BALL, "rod", "hand", origin=_pose((0.2, 0.1, 0))),
            jtik.Joint("tip", JointType.FIXED, "hand", "tip", origin=_pose((0.15, 0, 0.05), (0, 0.4, 0))),
        ],
        name="ball_arm",
    )


@functools.cache
def floating_arm():
    """A free base with a three-joint arm: nq = 10, n = 9."""
    z, y = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])
    return jtik.Robot(
        [
            jtik.Joint("float", JointType.FREE, "base", "hull"),
            jtik.Joint("one", JointType.REVOLUTE, "hull", "l1", origin=_pose((0.2, 0, 0.1)), axis=z),
            jtik.Joint("two", JointType.REVOLUTE, "l1", "l2", origin=_pose((0.4, 0, 0)), axis=y, lower=-2.0, upper=2.0),
            jtik.Joint("three", JointType.REVOLUTE, "l2", "l3", origin=_pose((0.4, 0, 0)), axis=y),
            jtik.Joint("tip", JointType.FIXED, "l3", "tip", origin=_pose((0.2, 0, 0))),
        ],
        name="floating_arm",
    )


def random_mass(rng):
    """A mass with a centre and the inertia of a body, off the axes of its frame."""
    points = rng.normal(scale=0.1, size=(6, 3))
    offsets = points - points.mean(axis=0)
    inertia = sum(p @ p * np.eye(3) - np.outer(p, p) for p in offsets)
    return Mass(rng.uniform(0.5, 3.0), points.mean(axis=0), inertia)


@functools.cache
def weighted(robot, seed=0):
    """The robot with a random mass on every frame but the base, in the plane of a planar robot."""
    rng = np.random.default_rng(seed)
    masses = {frame: random_mass(rng) for frame in robot.frame_names[1:]}
    if robot.dimension == 2:
        masses = {frame: Mass(m.mass, m.center * [1, 1, 0], m.inertia) for frame, m in masses.items()}
    return robot.with_masses(masses)


def report_at(ik, q, target):
    """The solver's report on the configuration ``q``: a Solution of no iterations."""
    return ik.solve(target, q0=q, max_iterations=0)


def differences(function, robot, q, step=1e-5):
    """Central differences of a vector-valued function along each velocity, shape (m, n)."""
    columns = []
    for unit in np.eye(robot.n):
        ahead = np.atleast_1d(function(robot.integrate(q, step * unit)))
        behind = np.atleast_1d(function(robot.integrate(q, -step * unit)))
        columns.append((ahead - behind) / (2 * step))
    return np.array(columns).T


def planar_points(q, lengths=None):
    """Ends of the links of a planar arm, (n, 2), in closed form; of several configurations (N, n), (N, n, 2)."""
    angle = np.cumsum(q, axis=-1)
    lengths = np.ones(angle.shape[-1]) if lengths is None else np.asarray(lengths)
    return np.cumsum(np.stack([lengths * np.cos(angle), lengths * np.sin(angle)], axis=-1), axis=-2)


def planar_jacobian(q, lengths=None):
    """Jacobian (2, n) of the tip of a planar arm, in closed form."""
    points = planar_points(q, lengths)
    arms = points[-1] - np.vstack([np.zeros(2), points[:-1]])
    return np.stack([-arms[:, 1], arms[:, 0]])


def rises(trace):
    """Relative change of V at every accepted step."""
    V = np.append(trace.V, trace.error[-1] ** 2 / 2)
    return ((V[1:] - V[:-1]) / np.maximum(V[:-1], np.finfo(float).tiny))[trace.accepted == 1]


def turning(robot, limits=True):
    """The entries of q that a solve moves without limits, (nq,): those of joints whose limits leave a full turn.

    Without ``limits`` those of all revolute joints.
    """
    mask = np.zeros(robot.nq, dtype=bool)
    for joint in robot.independent_joints:
        if joint.type is JointType.REVOLUTE:
            where = robot.q_slice(joint.name)
            mask[where] = not limits or robot.upper[where] - robot.lower[where] > 2 * np.pi - 0.1
    return mask


def under_limits(robot, rows):
    """The rows of a trace for a look at limits: joints that can turn all the way round obey them at the end only."""
    rows, free = rows.copy(), turning(robot)
    rows[:-1, free] = rows[-1, free]
    return rows


def as_moved(robot, rows, limits=True):
    """The rows of a trace as a path: without the whole turns by which joints are brought back within their limits."""
    rows, free = rows.copy(), turning(robot, limits)
    rows[:, free] = np.unwrap(rows[:, free], axis=0)
    return rows


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What is collected stays until the end: no search for cycles goes through it, a quarter of the time it takes."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.fixture
def rng():
    return np.random.default_rng(20240607)
