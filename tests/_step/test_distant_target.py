"""Distant targets: which ones are, the direction of the gradient, and V falls with what the step is made for."""

from __future__ import annotations

import math

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.distant_target import NEARER, REACH, NearerTarget, robot_size
from jtik._step.local_model import linearized
from jtik.robot import JointType

from ..conftest import dh_arm, planar, planar_points
from .conftest import constants, inputs_of, numbers, problem_of

Q = np.array([0.4, -0.3, 0.8])


def model_at(robot, q, target, task=None, **options):
    problem = problem_of(robot, task)
    inputs = constants(inputs_of(problem, target))
    return problem, linearized(problem, casadi.SX(q), inputs, {"neighbourhood": casadi.SX(1.0)}, None, **options).model


def size_of(robot, *, limits=True):
    return robot_size(robot, problem_of(robot, jtik.FrameTask(robot.tip)).bounded if limits else ())


class TestTheSize:
    def test_it_is_the_sum_of_the_links(self):
        assert size_of(planar(3)) == pytest.approx(3.0)

    @pytest.mark.parametrize("robot", [dh_arm(6, 1), dh_arm(7, 2), jtik.Robot.builtin("panda")], ids=str)
    def test_it_bounds_the_distance_of_every_frame(self, robot, rng):
        farthest = max(
            np.linalg.norm(robot.position(robot.random_configuration(rng), frame))
            for frame in robot.frame_names
            for _ in range(20)
        )
        assert 0.5 * size_of(robot) < farthest <= size_of(robot)

    def test_a_stroke_counts(self):
        lift = jtik.Joint("lift", JointType.PRISMATIC, "base", "top", lower=-0.5, upper=2.0)
        assert size_of(jtik.Robot([lift])) == pytest.approx(2.0)
        assert math.isinf(size_of(jtik.Robot([lift]), limits=False))
        free = jtik.Joint("lift", JointType.PRISMATIC, "base", "top", lower=-0.5)
        assert math.isinf(size_of(jtik.Robot([free])))
        assert math.isinf(size_of(jtik.Robot([jtik.Joint("free", JointType.FREE, "base", "body")])))


class TestWhichTargets:
    @pytest.mark.parametrize(
        ("distance", "distant"), [(REACH * 3 - 1e-9, False), (REACH * 3 + 1e-9, True), (1e9, True)]
    )
    def test_by_their_distance(self, distance, distant):
        tip = planar_points(Q)[-1]
        _, model = model_at(planar(3), Q, tip + np.array([0, distance]))
        assert np.linalg.norm(numbers(model.here.residual)) == pytest.approx(NEARER * 3 if distant else distance)
        assert numbers(model.here.to_target) == pytest.approx([0, -distance], abs=1e-6)

    def test_a_residual_that_is_not_is_unchanged(self):
        problem, model = model_at(planar(3), Q, [1.0, 1.5])
        assert numbers(model.here.residual).tolist() == numbers(problem.residual(Q, [1.0, 1.5])).tolist()
        assert not numbers(model.shift).any()

    @pytest.mark.parametrize(
        ("robot", "task"),
        [
            (planar(3), jtik.FrameTask(kind="orientation")),
            (jtik.Robot([jtik.Joint("free", JointType.FREE, "base", "body")]), jtik.FrameTask("body")),
            (planar(3), jtik.FrameTask(kind="pose", stiffness=[[2, 0, 0.5], [0, 2, 0], [0.5, 0, 2]])),
        ],
        ids=["angles", "unlimited", "coupled"],
    )
    def test_a_problem_without_any(self, robot, task):
        problem = problem_of(robot, task)
        assert NearerTarget.of(problem, casadi.SX.sym("r", problem.m), by_level=False) is None

    def test_a_timed_step_has_none(self):
        state = {"remaining": casadi.SX(0.0), "neighbourhood": casadi.SX(1.0)}
        problem = problem_of(planar(3))
        inputs = constants(inputs_of(problem, [1e3, 0.0]))
        model = linearized(problem, casadi.SX(Q), inputs, state, None, timed=True).model
        assert numbers(model.here.V) == pytest.approx(5e5, rel=1e-2)

    def test_each_level_by_itself_if_the_strategy_respects_them(self):
        tasks = [
            jtik.FrameTask("link2", name="near", priority=0),
            jtik.FrameTask("tip", name="far", priority=1),
        ]
        target = {"near": [1.0, 1.0], "far": [1e4, 0.0]}
        problem, together = model_at(planar(3), Q, target, tasks)
        _, apart = model_at(planar(3), Q, target, tasks, by_level=True)
        near = numbers(problem.residual(Q, [1.0, 1.0, 1e4, 0.0]))[:2]
        assert numbers(apart.here.residual)[:2].tolist() == near.tolist()
        assert np.linalg.norm(numbers(apart.here.residual)[2:]) == pytest.approx(NEARER * 3)
        assert numbers(together.here.residual)[:2] == pytest.approx(near * NEARER * 3 / 1e4 * math.sqrt(2), rel=1e-3)


@pytest.mark.parametrize("kind", ["position", "pose"])
@pytest.mark.parametrize("distance", [1.0, 10.0, 1e5])
class TestTheStep:
    """By numbers: a random arm, random steps."""

    robot = dh_arm(6, 4)

    def cases(self, kind, distance, rng):
        for _ in range(8):
            q, there = self.robot.random_configuration(rng), self.robot.random_configuration(rng)
            target = self.robot.pose(there)
            direction = rng.normal(size=3)
            target[:3, 3] += distance * direction / np.linalg.norm(direction)
            yield q, target, model_at(self.robot, q, target, jtik.FrameTask(kind=kind))[1]

    @pytest.mark.thinned
    def test_it_follows_the_gradient_of_V(self, kind, distance, rng):
        ik = problem_of(self.robot, jtik.FrameTask(kind=kind))
        for q, target, model in self.cases(kind, distance, rng):
            numbers_of_target = ik.tasks.read_target(target)
            r, J = ik.residual(q, numbers_of_target).full(), ik.residual_jacobian(q, numbers_of_target).full()
            gradient, own = (J.T @ r)[:, 0], numbers(model.J.T @ model.here.residual)
            cosine = gradient @ own / np.linalg.norm(gradient) / np.linalg.norm(own)
            assert cosine == pytest.approx(1, abs=1e-12)

    @pytest.mark.thinned
    def test_V_falls_where_that_of_the_nearer_point_does(self, kind, distance, rng):
        fell = 0
        for _, _, model in self.cases(kind, distance, rng):
            for size in (1e-3, 0.1, 1.0):
                candidate = model.candidate(casadi.SX(size * rng.normal(size=6)))
                decrease = numbers(model.here.decrease(candidate))
                assert decrease == pytest.approx(numbers(model.here.V - candidate.V), abs=1e-9 + 1e-14 * distance)
                if decrease > 1e-12 * distance:
                    fell += 1
                    assert numbers(model.here.V_to_target) > numbers(candidate.V_to_target)
        assert fell > 4
