"""Whether distances stay safe along a step: only those within its reach are evaluated, with the same answer."""

from __future__ import annotations

import itertools

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.clearances import clearance_model
from jtik._step.safe_path import REACH
from jtik.constraints.clearance import SAMPLES, TOLERATED
from jtik.constraints.motion_bound import MotionBound
from jtik_formulations import ObstacleAvoidance, SelfCollision

from ..conftest import EXACT, dh_arm, planar
from .conftest import problem_of

SAFE, MARGIN = 0.05, 0.02
FEW = 80


def circles(count, rng):
    return [jtik.Circle(center, 0.2) for center in rng.uniform(-3, 3, (count, 2))]


def clearance(measure, **options):
    return jtik.Clearance(measure, safe=SAFE, margin=MARGIN, influence=0.5, **options)


def planar_problem(rng):
    """Four links among eight circles, of which only some are restored."""
    links, joints = (ObstacleAvoidance(circles(4, rng), bodies=each) for each in ("links", "joints"))
    return problem_of(
        planar(4, lower=-2.5, upper=2.5),
        clearances=[clearance(links), clearance(joints, restore=False, name="joints")],
    )


def spatial_problem(rng):
    """Six links in space, with a slot that is absent, beside a box and a half-space."""
    obstacles = [jtik.Sphere(center, 0.3) for center in rng.uniform(-1, 1, (3, 3))]
    obstacles += [jtik.Box.at((0.8, 0.2, 0.3), (0.2, 0.3, 0.1)), jtik.HalfSpace((0, 0, -0.5), (0, 0, 1))]
    capacity = {"ball": 4, "box": 1, "half_space": 1}
    return problem_of(
        dh_arm(6, 1), clearances=[clearance(ObstacleAvoidance(obstacles, bodies="links", capacity=capacity))]
    )


def panda_problem(rng):
    """A Panda and its own links, each pair a body."""
    return problem_of(jtik.Robot.builtin("panda"), clearances=[clearance(SelfCollision())])


def judged(problem):
    """(q, dq) -> distances, whether the path is safe, violation after it; of the model of the step."""
    q, dq, robot = casadi.SX.sym("q", problem.robot.nq), casadi.SX.sym("dq", problem.robot.n), problem.robot
    live = casadi.SX(problem.terms.parameters.memory)
    limits = casadi.SX(robot.lower), casadi.SX(robot.upper)
    model = clearance_model(problem, q, problem.measured.clearance(q, live), live, limits)
    return casadi.Function("judged", [q, dq], [model.distance, model.keeps(dq), model.violation_after(dq)])


def expected(problem, q, dq):
    """The same in NumPy, every distance evaluated at every sample (formulations/clearance.md, (C6))."""
    robot, live = problem.robot, problem.terms.parameters.memory
    figures = np.array(problem.measured.clearance(q, live)[2])
    safe, aim, radius = figures[:, 0], figures[:, 1], figures[:, 4]
    at = [np.clip(robot.integrate(q, k / SAMPLES * dq), robot.lower, robot.upper) for k in range(SAMPLES + 1)]
    distances = [np.array(problem.measured.distances(each, live)).ravel() for each in at]
    L, S = (float(casadi.DM(each)) for each in MotionBound(robot, casadi.SX(q)).lengths(casadi.SX(dq)))
    dip = np.minimum((L**2 / radius + L * S) / (8 * SAMPLES**2), L / (2 * SAMPLES))
    start, good = distances[0], True
    for before, after in itertools.pairwise(distances):
        low = np.minimum(before, after) - dip - np.minimum(safe, start)
        good &= bool((np.where(start < safe, after - start + 1e-12, low) >= 0).all())
    lacks = aim - distances[-1]
    counted = problem.measured.restored & (lacks > TOLERATED * (aim - safe))
    return good, lacks[counted].sum(), start - REACH * L >= aim


@pytest.mark.quick(1)
@pytest.mark.parametrize("problem", [planar_problem, spatial_problem, panda_problem])
def test_the_answer_is_that_of_all_distances(problem, rng):
    problem = problem(rng)
    robot, found = problem.robot, judged(problem)
    verdicts, violated, skipped = [], 0, []
    for _ in range(FEW):
        q = rng.uniform(np.maximum(robot.lower, -3), np.minimum(robot.upper, 3))
        dq = rng.uniform(-1, 1, robot.n) * 10 ** rng.uniform(-3, -0.3)
        good, violation, far = expected(problem, q, dq)
        distances, keeps, after = (np.array(each).ravel() for each in found(q, dq))
        assert distances.shape == far.shape
        assert bool(keeps[0]) is good
        assert after[0] == pytest.approx(violation, abs=EXACT)
        verdicts.append(good)
        violated += violation > 0
        skipped.append(far.mean())
    assert 0.05 < np.mean(verdicts) < 0.95
    assert violated > 0
    assert 0.1 < np.mean(skipped) < 0.9


class Counted(casadi.Callback):
    """The distance 1 - x of a point (x, y), and how often it was evaluated."""

    def __init__(self, name):
        casadi.Callback.__init__(self)
        self.calls = 0
        self.construct(name, {})

    def get_n_in(self):
        return 1

    def get_n_out(self):
        return 1

    def get_sparsity_in(self, i):
        return casadi.Sparsity.dense(2, 1)

    def get_sparsity_out(self, i):
        return casadi.Sparsity.dense(1, 1)

    def has_jacobian(self):
        return True

    def get_jacobian(self, name, inames, onames, opts):
        x, d = casadi.MX.sym("x", 2), casadi.MX.sym("d", 1)
        return casadi.Function(name, [x, d], [casadi.DM([[-1.0, 0.0]])], inames, onames, opts)

    def eval(self, arg):
        self.calls += 1
        return [1 - arg[0][0]]


class Walls:
    """The measure of the wall x = 1 from the two points of an arm, each by a function that counts its calls."""

    name = "walls"

    def __init__(self):
        self.counted = Counted("first"), Counted("second")

    def parameters(self, robot):
        return {}

    def distances(self, kinematics, parameters):
        points = [kinematics.position(frame) for frame in kinematics.robot.moving_frames]
        return [[each.call([point], False, True)[0]] for each, point in zip(self.counted, points, strict=True)]


def test_only_bodies_within_reach_are_evaluated():
    """The elbow is 1 from the wall, the tip 0.07; a step of 0.01 rad moves points by less than 0.03."""
    measure = Walls()
    problem = problem_of(jtik.Robot.planar([0.5, 0.9]), clearances=[jtik.Clearance(measure, safe=0.05, margin=0.01)])
    q = casadi.SX.sym("q", 2)
    path = judged_path(problem, q)
    turned = np.array([np.pi / 2, -np.pi / 2])  # the elbow above the base, the tip 0.9 in front of it
    for each in measure.counted:
        each.calls = 0
    assert [float(x) for x in path(turned, [0.01, 0.0], [1.0, 0.07])] == [1, 0]
    assert [each.calls for each in measure.counted] == [0, SAMPLES]
    assert [float(x) for x in path(turned, [0.01, 0.0], [1.0, 0.5])] == [1, 0]
    assert [each.calls for each in measure.counted] == [0, SAMPLES]  # none is in reach
    path(turned, [0.01, 0.0], [1.0, np.nan])
    assert [each.calls for each in measure.counted] == [0, 2 * SAMPLES]  # what is no number is evaluated


def judged_path(problem, q):
    """(q, dq, distances at q) -> whether the path is safe, violation after it."""
    dq, distance, robot = casadi.SX.sym("dq", 2), casadi.SX.sym("d", 2), problem.robot
    live = casadi.SX(problem.terms.parameters.memory)
    limits = casadi.SX(robot.lower), casadi.SX(robot.upper)
    _, J, figures = problem.measured.clearance(q, live)
    model = clearance_model(problem, q, (distance, J, figures), live, limits)
    return casadi.Function("path", [q, dq, distance], [model.keeps(dq), model.violation_after(dq)])
