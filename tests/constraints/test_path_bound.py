"""(C6): what distances do between the samples of a step, for points and links of arms that pass balls."""

from __future__ import annotations

import functools

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.clearances import clearance_model
from jtik.constraints.clearance import SAMPLES
from jtik.constraints.motion_bound import MotionBound
from jtik_formulations import ObstacleAvoidance

from .._step.conftest import problem_of
from ..conftest import ball_arm, dh_arm, floating_arm, planar, planar_points
from .random_trees import far_out, path, positions, tree

FINE = 40
"""Points between two samples at which a path is evaluated here."""

SHARES = np.linspace(0, 1, FINE + 1)


def smoothed(f, rho):
    """psi: f from rho on, and below it a parabola with the same value and slope there."""
    return np.where(f >= rho, f, (f**2 / rho + rho) / 2)


def bound(robot, q, dq, rho):
    """D = L^2 / rho + L S of the step."""
    L, S = (float(casadi.DM(each)) for each in MotionBound(robot, casadi.SX(q)).lengths(casadi.SX(dq)))
    return L**2 / rho + L * S


def intervals(values):
    """Values (SAMPLES, FINE + 1, ...) on each interval of a path (SAMPLES * FINE + 1, ...), ends included."""
    return np.stack([values[k * FINE : (k + 1) * FINE + 1] for k in range(SAMPLES)])


def below_chord(values):
    """By how much values on the path lie below their chord on the interval between two samples, at most."""
    parts = intervals(values)
    share = SHARES.reshape(1, -1, *[1] * (parts.ndim - 2))
    return ((1 - share) * parts[:, :1] + share * parts[:, -1:] - parts).max()


ROBOTS = {
    "planar": lambda rng: planar(3),
    "spatial": lambda rng: dh_arm(6, 1),
    "ball": lambda rng: ball_arm(),
    "floating": lambda rng: floating_arm(),
    "tree": lambda rng: tree(rng, 5),
}


@pytest.mark.thinned
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("robot", ROBOTS)
def test_the_smoothed_distance_is_at_most_so_far_below_its_chord(robot, seed):
    """For points of links, and for the closest point of each, also where the path leads through the centre."""
    rng = np.random.default_rng(seed)
    robot = ROBOTS[robot](rng)
    for _ in range(20):
        q, rho = far_out(robot, rng), rng.uniform(0.01, 0.5)
        dq = rng.uniform(-1, 1, robot.n) * 10 ** rng.uniform(-2, 0)
        way = path(robot, q, robot.integrate(q, dq), SAMPLES * FINE + 1)
        places = positions(robot, way)
        dip = bound(robot, q, dq, rho) / (8 * SAMPLES**2) * (1 + 1e-6) + 1e-9
        for joint in robot.joints:
            share = np.linspace(0, 1, 9)[:, None, None]
            link = (1 - share) * places[joint.parent] + share * places[joint.child]  # (points, samples, 3)
            center = link[rng.integers(9), rng.integers(link.shape[1])] + rho * rng.normal(size=3) * rng.integers(3)
            psi = smoothed(np.linalg.norm(link - center, axis=-1), rho).T
            assert below_chord(psi) <= dip
            closest = intervals(psi.min(axis=1))
            assert (np.minimum(closest[:, :1], closest[:, -1:]) - closest).max() <= dip


def test_the_bound_is_attained():
    """One link turns past a ball just beyond its end: D, and not the share of it that the others leave."""
    robot, rho, q, dq = planar(1), 0.2, np.array([-0.02]), np.array([0.16])
    turned = q + np.linspace(0, 1, SAMPLES * FINE + 1)[:, None] * dq
    tips = np.stack([np.cos(turned[:, 0]), np.sin(turned[:, 0])], axis=1)
    gap = smoothed(np.linalg.norm(tips - [1 + rho, 0.0], axis=1), rho)
    dip = bound(robot, q, dq, rho) / (8 * SAMPLES**2)
    assert 0.98 * dip <= below_chord(gap) <= dip


SAFE = 0.05


@functools.cache
def judged():
    """Live parameters, and (q, dq, parameters) -> whether the step of an arm of three links keeps its clearance."""
    robot = planar(3)
    measure = ObstacleAvoidance(jtik.Circle((0.0, 0.0), 1.0), bodies="links")
    problem = problem_of(robot, clearances=[jtik.Clearance(measure, safe=SAFE)])
    live = problem.terms.parameters
    q, dq, parameters = casadi.SX.sym("q", 3), casadi.SX.sym("dq", 3), live.symbols()
    limits = casadi.SX(robot.lower), casadi.SX(robot.upper)
    model = clearance_model(problem, q, problem.measured.clearance(q, parameters), parameters, limits)
    return live, casadi.Function("judged", [q, dq, parameters], [model.keeps(dq)])


def gaps(q, center, radius):
    """The smallest distance of a link to the circle, at configurations (samples, n)."""
    points = np.concatenate([np.zeros((len(q), 1, 2)), planar_points(q)], axis=1)
    a, along = points[:, :-1], np.diff(points, axis=1)
    share = np.clip(((center - a) * along).sum(-1) / (along**2).sum(-1), 0, 1)
    return np.linalg.norm(a + share[..., None] * along - center, axis=-1).min(axis=1) - radius


def test_a_step_that_is_judged_safe_is_safe_on_its_whole_path(rng):
    """Circles at random distances from the path, most of them passed between two samples."""
    live, keeps = judged()
    kept, closest, at_samples = 0, np.inf, 0
    while kept < 80:
        q, dq = rng.uniform(-2, 2, 3), rng.uniform(-1, 1, 3) * 10 ** rng.uniform(-2, 0)
        way = q + np.linspace(0, 1, SAMPLES * FINE + 1)[:, None] * dq
        radius, on_path = 10 ** rng.uniform(-2, 0), way[rng.integers(len(way))]
        points = np.vstack([[0.0, 0.0], planar_points(on_path)])
        link, side = rng.integers(3), rng.normal(size=2)
        beside = points[link] + rng.uniform() * (points[link + 1] - points[link])
        center = beside + (radius + SAFE + rng.exponential(0.02)) * side / np.linalg.norm(side)
        gap = gaps(way, center, radius) - SAFE
        if gap[0] < 0:
            continue
        live["clearance.centers"], live["clearance.radii"] = center[None], [radius]
        at_samples += gap[::FINE].min() >= 0 > gap.min()
        if float(keeps(q, dq, live.memory)):
            kept += 1
            closest = min(closest, gap.min())
    assert closest >= -1e-9
    assert closest < 1e-3  # some are close
    assert at_samples > 0  # safe at the samples only


@pytest.mark.parametrize(("missing", "safe"), [(-0.1, True), (0.1, False)])
def test_the_judgement_changes_where_the_path_does(missing, safe):
    """The last link turns past a circle beyond its end, safe at the samples; ``missing`` is a share of the bound."""
    live, keeps = judged()
    q, dq, radius = np.array([0.3, 0.4, -0.02]), np.array([0.0, 0.0, 0.16]), 0.15
    dip = bound(planar(3), q, dq, radius + SAFE) / (8 * SAMPLES**2)
    elbow = planar_points(q)[1]
    center = elbow + (1 + radius + SAFE - missing * dip) * np.array([np.cos(0.7), np.sin(0.7)])
    live["clearance.centers"], live["clearance.radii"] = center[None], [radius]
    way = q + np.linspace(0, 1, SAMPLES * FINE + 1)[:, None] * dq
    gap = gaps(way, center, radius) - SAFE
    assert gap[::FINE].min() > 0.5 * dip
    assert (gap.min() >= 0) == safe
    assert bool(keeps(q, dq, live.memory)) == safe
