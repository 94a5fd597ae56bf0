"""Distances of many pairs, with loops over them: those of each pair alone, and their derivatives."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.clearances import clearance_model
from jtik.constraints import many_distances
from jtik.robot import Joint, JointType
from jtik_formulations import ObstacleAvoidance, SelfCollision

from .._step.conftest import problem_of
from ..conftest import dh_arm, planar
from .random_trees import tree

ROUNDED = 1e-12
DIFFERENCES = 1e-6


def field(dimension, rng):
    """Obstacles of every kind, of some several, out of the arm's reach in part."""
    at = lambda count: rng.uniform(-1.5, 1.5, (count, dimension))  # noqa: E731
    capsule = [jtik.Capsule(a, b, 0.1) for a, b in zip(at(2), at(2), strict=True)]
    half_space = jtik.HalfSpace(3 * np.eye(dimension)[-1], -np.eye(dimension)[-1])
    if dimension == 2:
        corners = np.array([(0, 0), (0.4, 0.1), (0.3, 0.5)]) + at(1)
        boxes = [jtik.Box.at(center, (0.2, 0.1), 0.4) for center in at(2)]
        return [*(jtik.Circle(c, 0.2) for c in at(3)), *capsule, *boxes, half_space, jtik.Polygon(corners)]
    boxes = [jtik.Box.at(center, (0.2, 0.1, 0.3)) for center in at(2)]
    cylinder = jtik.Cylinder(*at(2), 0.15)
    return [*(jtik.Sphere(c, 0.2) for c in at(3)), *capsule, *boxes, half_space, cylinder]


def problems(robot, monkeypatch, measure):
    """The same problem with loops, and written out."""
    made = []
    for few in (0, 10**9):
        monkeypatch.setattr(many_distances, "FEW", few)
        monkeypatch.setattr(many_distances, "FEW_OPERATIONS", few)
        monkeypatch.setattr(many_distances, "GROUP", 12)
        clearances = [jtik.Clearance(measure, safe=0.03, margin=0.02, influence=0.8)]
        made.append(problem_of(robot, clearances=clearances))
    assert made[0].measured.rows
    assert not made[1].measured.rows
    return made


def robot_of(kind, rng):
    if kind == "planar":
        return planar(4, lower=-2.5, upper=2.5)
    return dh_arm(5, 1) if kind == "spatial" else tree(rng, 6)


@pytest.mark.parametrize("bodies", ["links", "joints", "both"])
@pytest.mark.parametrize("kind", ["planar", "spatial", "tree"])
def test_distances_jacobian_and_figures_are_those_of_each_pair(kind, bodies, rng, monkeypatch):
    robot = robot_of(kind, rng)
    obstacles = field(robot.dimension, rng)
    loops, written = problems(robot, monkeypatch, ObstacleAvoidance(obstacles, bodies=bodies))
    live = written.terms.parameters.memory
    assert loops.measured.pairs == written.measured.pairs
    assert sum(loops.measured.sizes) == sum(written.measured.sizes)
    for _ in range(10):
        q = robot.integrate(robot.neutral, rng.uniform(-2, 2, robot.n))
        found, expected = ([np.array(each) for each in p.measured.clearance(q, live)] for p in (loops, written))
        for one, other in zip(found, expected, strict=True):
            assert one == pytest.approx(other, abs=ROUNDED)
        distances = np.array(loops.measured.distances(q, live))
        assert distances == pytest.approx(found[0], abs=ROUNDED)
        step = 1e-6 * rng.normal(size=robot.n)
        moved = (np.array(loops.measured.distances(robot.integrate(q, s * step), live)) for s in (1, -1))
        difference = np.subtract(*moved)[:, 0]
        assert difference == pytest.approx(2 * found[1] @ step, abs=DIFFERENCES * 1e-3)


def test_solids_have_their_radii_and_absent_obstacles_are_far(rng, monkeypatch):
    panda = jtik.Robot.builtin("panda")
    balls = [jtik.Sphere((0.5, 0.1 * i, 0.4), 0.05) for i in range(3)]
    measure = ObstacleAvoidance(balls, bodies="shapes", capacity={"ball": 5, "box": 1})
    loops, written = problems(panda, monkeypatch, measure)
    live = written.terms.parameters.memory
    q = rng.uniform(panda.lower, panda.upper)
    found, expected = ([np.array(each) for each in p.measured.clearance(q, live)] for p in (loops, written))
    for one, other in zip(found, expected, strict=True):
        assert one == pytest.approx(other, abs=ROUNDED)
    absent = found[0][:, 0] >= 1e8
    assert absent.sum() == len(absent) / 2
    assert (found[1][absent] == 0).all()


def test_radii_that_are_numbers_belong_to_their_bodies(monkeypatch):
    """Of boxes without gains they are numbers: each body has its own."""
    radii = [0.011, *(0.5 + 0.01 * i for i in range(8))]
    balls = [jtik.Sphere((0, 10.0 * i, 0), radius) for i, radius in enumerate(radii)]
    robot = jtik.Robot([Joint("rail", JointType.PRISMATIC, "base", "cart", axis=(1, 0, 0))], shapes={"cart": balls})
    boxes = [jtik.Box.at((0, 0, 50.0 * i), (0.001, 0.3, 0.3)) for i in range(9)]
    loops, written = problems(robot, monkeypatch, ObstacleAvoidance(boxes, bodies="shapes"))
    for problem in (loops, written):
        figures = np.array(problem.measured.clearance([0.0], problem.terms.parameters.memory)[2])
        assert figures[:, 4] == pytest.approx(0.03 + np.repeat(radii, len(boxes)))


@pytest.mark.parametrize("kind", ["panda", "planar", "tree"])
def test_pairs_of_a_robot_with_itself(kind, rng, monkeypatch):
    robot = jtik.Robot.builtin("panda") if kind == "panda" else planar(6) if kind == "planar" else tree(rng, 7)
    measure = SelfCollision() if kind == "panda" else SelfCollision(bodies="links", radius=0.02)
    loops, written = problems(robot, monkeypatch, measure)
    assert loops.measured.pairs == written.measured.pairs
    live = written.terms.parameters.memory.copy()
    live[-1] = 0  # the last pair is absent
    for _ in range(10):
        q = robot.integrate(robot.neutral, rng.uniform(-1.5, 1.5, robot.n))
        found, expected = ([np.array(each) for each in p.measured.clearance(q, live)] for p in (loops, written))
        for one, other in zip(found, expected, strict=True):
            assert one == pytest.approx(other, abs=ROUNDED)
        assert found[0][-1] == 1e9
        assert np.array(loops.measured.distances(q, live)) == pytest.approx(found[0], abs=ROUNDED)


def test_several_measures_of_which_one_has_loops(rng, monkeypatch):
    robot = planar(4, lower=-2.5, upper=2.5)
    made = []
    for few in (10, 10**9):
        monkeypatch.setattr(many_distances, "FEW", few)
        few = ObstacleAvoidance([jtik.Circle((1, 1), 0.2)], bodies="joints")
        all_of_them = ObstacleAvoidance(field(2, np.random.default_rng(5)), bodies="links")
        clearances = [jtik.Clearance(few), jtik.Clearance(all_of_them, name="many", restore=False, safe=0.05)]
        made.append(problem_of(robot, clearances=clearances))
    live, q = made[0].terms.parameters.memory, rng.uniform(-2, 2, 4)
    assert made[0].measured.pairs == made[1].measured.pairs
    assert (made[0].measured.restored == made[1].measured.restored).all()
    for one, other in zip(*(problem.measured.clearance(q, live) for problem in made), strict=True):
        assert np.array(one) == pytest.approx(np.array(other), abs=ROUNDED)


def test_the_path_is_judged_the_same(rng, monkeypatch):
    robot = planar(4, lower=-2.5, upper=2.5)
    judged = []
    for problem in problems(robot, monkeypatch, ObstacleAvoidance(field(2, rng), bodies="links")):
        q, dq, live = casadi.SX.sym("q", 4), casadi.SX.sym("dq", 4), casadi.SX(problem.terms.parameters.memory)
        limits = casadi.SX(robot.lower), casadi.SX(robot.upper)
        model = clearance_model(problem, q, problem.measured.clearance(q, live), live, limits)
        judged.append(casadi.Function("judged", [q, dq], [model.keeps(dq), model.violation_after(dq)]))
    verdicts = []
    for _ in range(300):
        q, dq = rng.uniform(-2.5, 2.5, 4), rng.uniform(-1, 1, 4) * 10 ** rng.uniform(-3, -0.3)
        (keeps, violation), (expected, other) = (map(float, each(q, dq)) for each in judged)
        assert keeps == expected
        assert violation == pytest.approx(other, abs=ROUNDED)
        verdicts.append(keeps)
    assert 0.02 < np.mean(verdicts) < 0.98
