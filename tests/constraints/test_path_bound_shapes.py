"""(C6) for every shape: no step that is judged safe comes closer, between samples, than the clearance allows."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.clearances import clearance_model
from jtik.geometry import Slots
from jtik_formulations import ObstacleAvoidance

from .._step.conftest import problem_of
from ..conftest import dh_arm, planar, planar_points, shared_solver
from ..geometry.coal_distances import by_coal, in_coal
from ..geometry.shapes import PLANAR, SPATIAL, distance, random_obstacle
from ..geometry.test_distances import corners_of, planar_truth, to_cylinder
from .random_trees import positions

SAFE, FINE = 0.03, 65

SHARES = np.linspace(0, 1, FINE)


def moved(obstacle, step):
    """The obstacle moved by a vector."""
    match obstacle:
        case jtik.Box():
            return jtik.Box.at(obstacle.center + step, obstacle.half, obstacle.rotation)
        case jtik.HalfSpace():
            return jtik.HalfSpace(obstacle.point + step, obstacle.normal)
        case jtik.Polygon():
            return jtik.Polygon(obstacle.vertices + step)
        case jtik.Capsule() | jtik.Cylinder():
            return type(obstacle)(obstacle.start + step, obstacle.end + step, obstacle.radius)
    return type(obstacle)(obstacle.center + step, obstacle.radius)


def in_space(obstacle):
    """A planar obstacle as a solid on both sides of the plane, at the same distance from segments in the plane."""
    match obstacle:
        case jtik.Box():
            turn = np.array([np.cos(obstacle.rotation / 2), 0, 0, np.sin(obstacle.rotation / 2)])
            return jtik.Box.at([*obstacle.center, 0], [*obstacle.half, 1], turn)
        case jtik.HalfSpace():
            return jtik.HalfSpace([*obstacle.point, 0], [*obstacle.normal, 0])
        case jtik.Capsule():
            return jtik.Capsule([*obstacle.start, 0], [*obstacle.end, 0], obstacle.radius)
    return jtik.Sphere([*obstacle.center, 0], obstacle.radius)


def gaps(obstacle, links):
    """The smallest distance of a link (samples, links, 2, d) to an obstacle at each sample, not by jtik."""
    if isinstance(obstacle, jtik.Polygon):
        return np.array([min(planar_truth(obstacle.vertices, link) for link in each) for each in links])
    if isinstance(obstacle, jtik.Cylinder):
        share = np.linspace(0, 1, 101)[:, None]
        points = links[:, :, None, 0] + share * (links[:, :, None, 1] - links[:, :, None, 0])
        return to_cylinder(points.reshape(-1, 3), obstacle).reshape(len(links), -1).min(axis=1)
    placed = in_coal(obstacle if obstacle.dimension == 3 else in_space(obstacle))
    flat = np.pad(links, ((0, 0),) * 3 + ((0, 3 - links.shape[-1]),))
    return np.array([min(by_coal(placed, tuple(link), 1e-9) + 1e-9 for link in each) for each in flat])


class Judged:
    """Whether steps of an arm keep a clearance of one obstacle of a kind, by jtik; and its links on a path."""

    def __init__(self, kind, dimension):
        self.robot = planar(3) if dimension == 2 else dh_arm(4, 1)
        self.slots = Slots({kind: 1}, dimension)
        measure = ObstacleAvoidance([], capacity={kind: 1}, bodies="links")
        problem = problem_of(self.robot, clearances=[jtik.Clearance(measure, safe=SAFE)])
        self.live, self.measured = problem.terms.parameters, problem.measured.clearance
        q, dq = casadi.SX.sym("q", self.robot.nq), casadi.SX.sym("dq", self.robot.n)
        parameters = self.live.symbols()
        limits = casadi.SX(self.robot.lower), casadi.SX(self.robot.upper)
        model = clearance_model(problem, q, problem.measured.clearance(q, parameters), parameters, limits)
        self.keeps = casadi.Function("judged", [q, dq, parameters], [model.keeps(dq)])

    def place(self, obstacle, gain=1.0):
        for name, value in self.slots.parameters([obstacle], [gain]).items():
            self.live[f"clearance.{name}"] = value

    def links(self, way):
        if self.robot.dimension == 2:
            points = np.concatenate([np.zeros((len(way), 1, 2)), planar_points(way)], axis=1)
            return np.stack([points[:, :-1], points[:, 1:]], axis=2)
        places = positions(self.robot, way)
        pairs = [np.stack([places[a], places[b]], axis=1) for a, b in self.robot.segments]
        return np.stack(pairs, axis=1)


EVERY = [*((kind, 2) for kind in PLANAR), *((kind, 3) for kind in SPATIAL)]


QUICK = [*((kind, 2) for kind in PLANAR), ("box", 3)]


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("kind", "dimension"),
    [pytest.param(*case, marks=[] if case in QUICK else pytest.mark.slow) for case in EVERY],
)
def test_a_step_that_is_judged_safe_is_safe_on_its_whole_path(kind, dimension, rng):
    """Obstacles beside a link somewhere on the path, which most steps pass between two samples."""
    judged = Judged(kind, dimension)
    kept, refused, closest = 0, 0, np.inf
    while kept < 8:
        q = rng.uniform(-2, 2, judged.robot.n)
        dq = rng.uniform(-1, 1, judged.robot.n) * 10 ** rng.uniform(-1.5, -0.2)
        links = judged.links(q + SHARES[:, None] * dq)
        link = links[rng.integers(FINE), rng.integers(links.shape[1])]
        if np.ptp(link, axis=0).max() < 1e-6:
            continue  # a link without length
        obstacle = random_obstacle(kind, dimension, rng)
        d, gradient = distance(obstacle, *link)
        beside = np.split(gradient, 2)[0] + np.split(gradient, 2)[1]
        obstacle = moved(obstacle, (d - SAFE - rng.exponential(0.01)) * beside)
        if distance(obstacle, *link)[0] < SAFE:
            continue
        if gaps(obstacle, links[:1])[0] < SAFE:
            continue
        judged.place(obstacle)
        if float(judged.keeps(q, dq, judged.live.memory)):
            kept += 1
            closest = min(closest, gaps(obstacle, links).min() - SAFE)
        else:
            refused += 1
    assert closest >= -1e-7
    assert closest < 0.01  # some are close
    assert refused > 0


@pytest.mark.quick(4)
@pytest.mark.parametrize(("kind", "dimension"), EVERY)
def test_an_obstacle_that_is_absent_constrains_nothing(kind, dimension, rng):
    judged = Judged(kind, dimension)
    q, dq = np.full(judged.robot.n, 0.3), np.full(judged.robot.n, 0.5)
    obstacle = random_obstacle(kind, dimension, rng)
    for gain in (1.0, 0.0):
        judged.place(obstacle, gain)
        d, J, _ = (each.full() for each in judged.measured(q, judged.live.memory))
        present = gain > 0
        assert (d < 1e3).all() == present
        assert (np.abs(J).max() > 0.1) == present
    assert d.min() == 1e9
    assert not J.any()
    assert float(judged.keeps(q, dq, judged.live.memory))


def test_corners_of_every_planar_shape_with_corners(rng):
    """The oracle of this file is the obstacle's: its corners are on its surface."""
    for kind in ("box", "polygon"):
        obstacle = random_obstacle(kind, 2, rng)
        for corner in corners_of(obstacle):
            assert distance(obstacle, corner)[0] == pytest.approx(0, abs=1e-12)


class Unproved(ObstacleAvoidance):
    """Distances of which one is none to a fixed set."""

    def rounding(self, robot, parameters):
        return [[0.0, None] for _ in self.body_names(robot)]


def test_a_distance_without_a_bound_is_refused():
    measure = Unproved([jtik.Point((1, 1)), jtik.Point((2, 1))], name="unproved")
    with pytest.raises(jtik.ArgumentError, match=r"measure.*distance 1 of link2.*bounded"):
        problem_of(planar(3), clearances=[jtik.Clearance(measure)])


def test_the_radius_of_a_body_makes_longer_steps_safe(rng):
    """A thick link beside the edge of a box: its axis is as far away as the radius, and turns in a wide arc."""
    shape = {"link2": [jtik.Capsule((0, 0, 0), (1, 0, 0), 0.2)]}
    robot = jtik.Robot(planar(2).joints, planar=True, shapes=shape)
    box = jtik.Box.at((1.5, 1.0), (0.3, 0.3))
    found = {}
    for bodies in ("shapes", "links"):
        measure = ObstacleAvoidance(box, bodies=bodies)
        rounding = measure.rounding(
            robot, {name: casadi.SX(value) for name, value in measure.parameters(robot).items()}
        )
        found[bodies] = [each for body in rounding for each in body]
    assert found["links"] == [0.0, 0.0]
    assert found["shapes"] == [0.2]


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["weighted_qp", "hybrid+qp"])
@pytest.mark.parametrize("influence", [0.3, np.inf])
def test_a_clearance_gains_and_loses_obstacles_while_in_use(strategy, influence):
    """Empty slots neither constrain nor are reported; a wall that appears in a slot stops the arm in front of it."""
    robot, capacity = planar(3), {"ball": 2, "half_space": 2, "box": 1}
    measure = ObstacleAvoidance([], capacity=capacity, bodies="links")
    clearance = jtik.Clearance(measure, safe=SAFE, influence=influence)
    task = jtik.FrameTask(kind="position")
    ik = shared_solver(robot, task, strategy=strategy, clearances=clearance)
    free = shared_solver(robot, task, strategy=strategy)
    q0, target = [0.1, 0.2, 0.3], [0.8, 2.3]
    slots, wall = measure.slots(robot), jtik.HalfSpace((0.0, 2.0), (0.0, -1.0))
    for obstacles in ([], [wall], []):
        for name, value in slots.parameters(obstacles).items():
            ik.parameters[f"clearance.{name}"] = value
        solution = ik.solve(target, q0=q0)
        highest = max(robot.position(solution.q, frame)[1] for frame in robot.moving_frames)
        if obstacles:
            assert not solution.converged
            assert SAFE - 1e-6 <= 2.0 - highest <= SAFE + 0.02
            assert any("half_space 0" in name for name in solution.active_clearances)
        else:
            assert solution.converged
            assert solution.q == pytest.approx(free.solve(target, q0=q0).q, abs=1e-5)
            assert not solution.active_clearances
            assert not solution.relaxed
