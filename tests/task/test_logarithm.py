"""error="logarithm" of frame tasks: against the matrix logarithm, mink's tasks, differences, and what is refused."""

from __future__ import annotations

import functools

import mink
import mujoco
import numpy as np
import pytest
from scipy.linalg import logm
from scipy.spatial.transform import Rotation

import jtik
from jtik.problems.near_singular import _along
from jtik.problems.target_of import target_of
from jtik.symbolic import function, jacobian, rigid_motion, rotation, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik_formulations import Newton

from ..conftest import DIFFERENCES, differences, report_at, shared_solver
from .conftest import ROBOTS, built, dh_arm, planar, two_arms, two_arms_model

KINDS = ("position", "orientation", "pose")
MINK = 1e-12
"""Rounding of both, relative to numbers of order 1, away from pi."""
LOGM = 1e-8
"""Accuracy of SciPy's logarithm of a matrix."""


@functools.cache
def translation():
    """(phi, p) -> the translation of the logarithm, its closed derivative, and CasADi's."""
    phi, p = symbol("phi", 3), symbol("p", 3)
    v = rigid_motion.log_translation(phi, p)
    closed = rigid_motion.log_translation_rate(phi, p)
    return CompiledFunction(function("translation", [phi, p], [v, closed, jacobian(v, phi)]))


def exact(phi, p):
    """The inverse of the left Jacobian of SO(3), which is the mean of exp(t [phi]) over t in [0, 1], applied to p."""
    nodes, weights = np.polynomial.legendre.leggauss(40)
    J = sum(w / 2 * Rotation.from_rotvec((x + 1) / 2 * phi).as_matrix() for x, w in zip(nodes, weights, strict=True))
    return np.linalg.solve(J, p)


@pytest.mark.quick(4)
@pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-6, 1e-3, 0.0999, 0.1001, 1.0, 3.0, np.pi - 1e-9, np.pi])
def test_the_translation_is_that_of_the_exponential(angle, rng):
    """And its derivative is regular, at the identity and at pi, and on both sides of the switch to the series."""
    for _ in range(5):
        axis, p = rng.standard_normal((2, 3))
        phi = angle * axis / np.linalg.norm(axis)
        v, closed, casadi = translation()(phi, p)
        assert v[:, 0] == pytest.approx(exact(phi, p), abs=1e-13)
        assert closed == pytest.approx(casadi, abs=1e-12)
        step = 1e-4
        numeric = np.array([(exact(phi + step * d, p) - exact(phi - step * d, p)) / (2 * step) for d in np.eye(3)]).T
        assert closed == pytest.approx(numeric, abs=1e-6)


def difference(robot, q, target, frame="tip"):
    """The twist (6,) of the motion from the target to the frame, or (3,) in the plane, by SciPy's matrix logarithm."""
    twist = np.real(logm(np.linalg.inv(target) @ robot.pose(q, frame)))
    full = np.array([*twist[:3, 3], twist[2, 1], twist[0, 2], twist[1, 0]])
    return full[[0, 1, 5]] if robot.dimension == 2 else full


def near(robot, q, rng, size=0.4):
    return robot.pose(robot.integrate(q, rng.uniform(-size, size, robot.n)))


@pytest.mark.quick(3)
@pytest.mark.parametrize("name", [*ROBOTS, "plane"])
def test_error_is_the_matrix_logarithm(name, rng):
    robot = jtik.Robot.vehicle(3, heading=True) if name == "plane" else ROBOTS[name]()
    for _ in range(5):
        q = robot.random_configuration(rng)
        target = near(robot, q, rng)
        twist, split = difference(robot, q, target), robot.dimension
        for kind, expected in zip(KINDS, (twist[:split], twist[split:], twist), strict=True):
            ik = built(robot, jtik.FrameTask, "tip", kind, error="logarithm")
            assert report_at(ik, q, target).error == pytest.approx(expected, abs=LOGM)


@pytest.mark.thinned
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("angle", [0.0, 0.05, 1.0, np.pi - 1e-2])
@pytest.mark.parametrize("name", [*ROBOTS, "plane"])
def test_jacobian_is_the_derivative_of_the_error(name, angle, kind, rng):
    """On the target's orientation, near it, and at almost pi."""
    robot = jtik.Robot.vehicle(3, heading=True) if name == "plane" else ROBOTS[name]()
    ik = built(robot, jtik.FrameTask, "tip", kind, error="logarithm")
    q = robot.random_configuration(rng)
    target = robot.pose(q)
    axis = np.array([0, 0, 1.0]) if name == "plane" else rng.standard_normal(3)
    target[:3, :3] = target[:3, :3] @ Rotation.from_rotvec(angle * axis / np.linalg.norm(axis)).as_matrix()
    target[: robot.dimension, 3] += rng.uniform(-0.5, 0.5, robot.dimension)
    numeric = differences(lambda at: report_at(ik, at, target).error, robot, q)
    assert report_at(ik, q, target).jacobian == pytest.approx(numeric, abs=DIFFERENCES)


ARM = """
<mujoco><worldbody><body name="b1" pos="0 0 .3"><joint axis="0 0 1"/><geom size=".01" mass="1"/>
 <body name="b2" pos=".1 0 .1"><joint axis="0 1 0"/><geom size=".01" mass="1"/>
  <body name="b3" pos=".4 0 0"><joint axis="0 1 0"/><geom size=".01" mass="1"/>
   <body name="b4" pos=".3 .1 0"><joint axis="1 0 0"/><geom size=".01" mass="1"/>
    <body name="b5" pos=".2 0 .1"><joint axis="0 1 0"/><geom size=".01" mass="1"/>
     <body name="b6" pos=".1 0 0"><joint axis="0 0 1"/><geom size=".01" mass="1"/>
      <body name="tip" pos=".1 .05 .2" quat=".8 .2 .5 .1"><joint axis="1 0 0"/><geom size=".01" mass="1"/></body>
</body></body></body></body></body></body></worldbody></mujoco>
"""
COSTS = {"position": (1.0, 0.0), "orientation": (0.0, 1.0), "pose": (1.0, 1.0)}
ROWS = {"position": slice(3), "orientation": slice(3, 6), "pose": slice(6)}


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", KINDS)
def test_error_jacobian_and_step_are_those_of_minks_task(kind, rng):
    """A strict step on mink's own error and Jacobian, by their pseudo-inverse: Newton's step is the same."""
    model = mujoco.MjModel.from_xml_string(ARM)
    robot = jtik.Robot.from_mujoco(model)
    strategy = Newton(backtracking=False, q_limit=np.inf)
    ik = shared_solver(
        robot, jtik.FrameTask("tip", kind, error="logarithm"), strategy=strategy, limits=False, joints="all"
    )
    theirs = mink.FrameTask("tip", "body", *COSTS[kind])
    for _ in range(10):
        q = rng.uniform(-1, 1, 7)
        target = near(robot, q, rng)
        theirs.set_target(mink.SE3.from_matrix(target))
        configuration = mink.Configuration(model, q)
        error, J = theirs.compute_error(configuration)[ROWS[kind]], theirs.compute_jacobian(configuration)[ROWS[kind]]
        found = report_at(ik, q, target)
        sign = np.sign(error @ found.error)  # their sign is that of J, too
        assert found.error == pytest.approx(sign * error, abs=MINK)
        assert found.jacobian == pytest.approx(sign * J, abs=MINK)
        ik.reset()
        expected = -np.linalg.lstsq(J, error, rcond=None)[0]
        assert ik.step(q, target).q - q == pytest.approx(expected, abs=1e3 * MINK)  # times the condition of J


def test_the_steps_of_separate_errors_are_others(rng):
    """Of positions and poses; the rows of an orientation are the same."""
    arm, strategy = dh_arm(7, 2), Newton(backtracking=False, q_limit=np.inf)
    for kind, same in (("position", False), ("orientation", True), ("pose", False)):
        separate, logarithm = (
            shared_solver(arm, jtik.FrameTask("tip", kind, error=error), strategy=strategy)
            for error in ("separate", "logarithm")
        )
        apart = []
        for _ in range(10):
            q = rng.uniform(-1, 1, 7)
            target = near(arm, q, rng)
            first, second = (ik.solve(target, q0=q, max_iterations=1).q - q for ik in (separate, logarithm))
            apart.append(np.linalg.norm(first - second) / np.linalg.norm(second))
        assert np.median(apart) < 1e-12 if same else np.median(apart) > 0.1


def test_a_relative_task_is_minks_relative_task(rng):
    robot, model = two_arms(), two_arms_model()
    ik = built(robot, jtik.RelativeFrameTask, "left", "right", error="logarithm")
    theirs = mink.RelativeFrameTask("left", "body", "right", "body", position_cost=1.0, orientation_cost=1.0)
    configuration = mink.Configuration(model)
    for _ in range(5):
        q = robot.random_configuration(rng)
        configuration.update(robot.integrate(q, rng.uniform(-0.4, 0.4, robot.n)))
        target = configuration.get_transform("left", "body", "right", "body")
        theirs.set_target(target)
        configuration.update(q)
        found = report_at(ik, q, target.as_matrix())
        assert found.error == pytest.approx(theirs.compute_error(configuration), abs=MINK)
        assert found.jacobian == pytest.approx(theirs.compute_jacobian(configuration), abs=1e-10)


def test_distances_are_never_underestimated(rng):
    """|p| <= |G p| <= pi/2 |p|: a tolerance that the error meets is met by the distance."""
    for _ in range(200):
        axis, p = rng.standard_normal((2, 3))
        v = translation()(rng.uniform(0, np.pi) * axis / np.linalg.norm(axis), p)[0]
        ratio = np.linalg.norm(v) / np.linalg.norm(p)
        assert 1 - 1e-12 <= ratio <= np.pi / 2 + 1e-12


def test_the_default_is_separate(rng):
    robot = dh_arm(7, 2)
    q = robot.random_configuration(rng)
    target = near(robot, q, rng)
    found = report_at(built(robot, jtik.FrameTask, "tip", "pose"), q, target).error
    assert found[:3] == pytest.approx((robot.pose(q) - target)[:3, 3], abs=1e-12)
    other = report_at(built(robot, jtik.FrameTask, "tip", "pose", error="logarithm"), q, target).error
    assert np.abs(found - other).max() > 1e-3  # a rotation in between


@pytest.mark.thinned
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("make", [lambda: dh_arm(7, 2), lambda: planar(4)])
def test_a_solve_reaches_the_same_targets(make, kind, rng):
    robot = make()
    ik = shared_solver(robot, jtik.FrameTask("tip", kind, error="logarithm"))
    for _ in range(3):
        q = rng.uniform(-1, 1, robot.n)
        target = near(robot, q, rng, 0.3)
        pose = robot.pose(ik.solve(target, q0=q, restarts=5).q)
        if kind != "orientation":
            assert pose[:3, 3] == pytest.approx(target[:3, 3], abs=2e-6)
        if kind != "position":
            assert pose[:3, :3] == pytest.approx(target[:3, :3], abs=2e-6)


def test_axes_are_those_of_the_target(rng):
    robot = dh_arm(7, 2)
    q = robot.random_configuration(rng)
    target = near(robot, q, rng)
    full = report_at(built(robot, jtik.FrameTask, "tip", "pose", error="logarithm"), q, target)
    part = report_at(built(robot, jtik.FrameTask, "tip", "pose", axes=("z", "rx"), error="logarithm"), q, target)
    assert part.error == pytest.approx(full.error[[2, 3]], abs=1e-15)


def test_what_is_refused():
    with pytest.raises(jtik.ArgumentError, match="'separate' or 'logarithm'"):
        jtik.FrameTask("tip", error="log")
    with pytest.raises(jtik.ArgumentError, match="'separate' or 'logarithm'"):
        jtik.RelativeFrameTask("tip", "link1", error="twist")
    ik = shared_solver(dh_arm(7, 2), jtik.FrameTask("tip", error="logarithm"))
    with pytest.raises(jtik.ArgumentError, match="a pose"):
        ik.solve([0.3, 0.2, 0.5])


@pytest.mark.thinned
@pytest.mark.parametrize("kind", ["position", "pose"])
@pytest.mark.parametrize("make", [lambda: dh_arm(6, 2), lambda: planar(3)])
def test_problems_are_generated_for_it(make, kind):
    """A position needs a pose as its target; targets near singular poses are moved in the axes of the rows."""
    robot = make()
    task = jtik.FrameTask("tip", kind, error="logarithm")
    shape = (4, 4) if robot.dimension == 3 else (3,)
    for draw in (jtik.problems.reachable, jtik.problems.near_singular):
        for case in draw(robot, task, count=2, seed=1):
            assert np.shape(case.target) == shape
    ik = shared_solver(robot, task, limits=False)
    u = np.arange(1.0, 1 + task.row_count(robot)) * 1e-4
    q = np.linspace(0.3, 0.8, robot.n)
    moved = _along(task, robot, target_of(task, robot, q), u)
    assert report_at(ik, q, moved).error == pytest.approx(-u, abs=1e-6)


def test_the_rotation_part_does_not_depend_on_the_translation():
    """The closed form of the Jacobian uses the rate of the rotation vector."""
    phi = symbol("phi", 3)
    rate = CompiledFunction(function("rate", [phi], [rotation.log_rate(phi)]))
    phi, p = np.array([0.3, -0.5, 0.2]), np.array([0.4, 0.1, -0.7])
    assert rate(phi)[0] @ p == pytest.approx(translation()(phi, p)[0][:, 0], abs=1e-14)
