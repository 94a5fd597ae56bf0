"""When a solve ends: errors by kind of row, tolerances, stationarity of task and criterion."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.inputs import Settings
from jtik._step.local_model import linearized
from jtik._step.stopping import OUTCOME, Code, StepOutcome, Stop
from jtik.strategy import Evaluation
from jtik_formulations import JointCentering

from ..conftest import planar, shared_solver
from .conftest import constants, inputs_of, numbers, problem_of

Q = np.array([0.4, -0.3, 0.8])


def stop_of(target, q=Q, task=None, *, robot=None, criteria=None, residual=None, **settings):
    problem = problem_of(robot or planar(3), task, criteria=criteria)
    inputs = constants(inputs_of(problem, target, **settings))
    at = linearized(problem, casadi.SX(q), inputs, {"neighbourhood": casadi.SX(1.0)}, None)
    return Stop(problem, at.model, Settings.of(inputs.settings), at.active_set, residual)


def flags(stop):
    return {name: bool(numbers(getattr(stop, name))) for name in ("reached_before", "done_before", "stationary")}


def test_the_outcome_is_found_by_name():
    assert list(OUTCOME) == list(range(6))
    assert StepOutcome._fields[OUTCOME.accepted] == "accepted"
    names = ["CONTINUE", "DONE", "STALLED", "NOT_FINITE", "SLOW", "UNSOLVED", "COMPROMISE"]
    assert [code.name for code in sorted(Code)] == names


class TestErrors:
    @pytest.mark.parametrize("stiffness", [1.0, [4.0, 9.0, 0.25], np.array([[2, 0.5, 0.1], [0.5, 1, 0], [0.1, 0, 3]])])
    def test_they_are_lengths_and_angles_whatever_the_stiffness(self, stiffness):
        pose = planar(3).pose(Q + np.array([0.1, -0.2, 0.3]))
        found = map(numbers, stop_of(pose, task=jtik.FrameTask(kind="pose", stiffness=stiffness)).errors_before)
        distance = np.linalg.norm(pose[:2, 3] - planar(3).position(Q))
        assert list(found) == pytest.approx([distance, 0.2])

    def test_a_kind_without_rows_has_no_error(self):
        assert numbers(stop_of([1.0, 1.0]).errors_before[1]) == 0


class TestReached:
    target = planar(3).position(Q) + np.array([0.01, 0.0])

    @pytest.mark.parametrize(("tolerance", "reached"), [(0.0101, True), (0.0099, False)])
    def test_the_position_tolerance(self, tolerance, reached):
        stop = stop_of(self.target, position_tolerance=tolerance)
        assert flags(stop) == {"reached_before": reached, "done_before": reached, "stationary": False}

    @pytest.mark.parametrize(("tolerance", "reached"), [(0.0101, True), (0.0099, False)])
    def test_the_orientation_tolerance(self, tolerance, reached):
        angle = Q.sum() + 0.01
        stop = stop_of(angle, task=jtik.FrameTask(kind="orientation"), orientation_tolerance=tolerance)
        assert flags(stop)["reached_before"] is reached

    def test_arrival_ends_a_solve_without_criterion(self):
        stop, there = stop_of([9.0, 9.0]), Evaluation(None, casadi.SX([1e-7, 0.0]), 0)
        assert numbers(stop.done_after(there))

    @pytest.mark.parametrize("until", [0, 1])
    def test_with_a_criterion_only_where_the_solve_is_to_end_on_arrival(self, until):
        stop = stop_of([9.0, 9.0], criteria=JointCentering(), until_stationary=until)
        assert bool(numbers(stop.done_after(Evaluation(None, casadi.SX([1e-7, 0.0]), 0)))) is (not until)


class TestCriterion:
    on_target = planar(3).position(Q)

    @pytest.mark.parametrize(("until", "done"), [(1, False), (0, True)])
    def test_on_target_a_criterion_that_can_fall_goes_on(self, until, done):
        assert flags(stop_of(self.on_target, criteria=JointCentering(), until_stationary=until))["done_before"] is done

    def test_at_its_minimum_it_ends(self):
        assert flags(stop_of(self.on_target, criteria=JointCentering(preferred=Q)))["done_before"]

    @pytest.mark.parametrize(("share", "done"), [(0.99, True), (1.01, False)])
    def test_the_residual_of_a_strategy_is_relative_to_the_gradient_but_at_least_to_one(self, share, done):
        criterion = JointCentering(100.0)
        size = max(1.0, np.linalg.norm(criterion.gradient(Q, planar(3))))
        assert size > 1
        residual = casadi.SX(share * 1e-3 * size)
        stop = stop_of(self.on_target, criteria=criterion, residual=residual, optimality_tolerance=1e-3)
        assert flags(stop)["done_before"] is done

    def test_off_the_target_it_never_ends(self):
        assert not flags(stop_of([0.5, 0.5], criteria=JointCentering(preferred=Q), until_stationary=0))["done_before"]


class TestStationary:
    def test_a_straight_arm_pulled_along_itself(self):
        assert flags(stop_of([2.0, 0.0], q=np.zeros(3)))["stationary"]
        assert not flags(stop_of([2.0, 0.0], q=np.array([0.0, 1e-3, 0.0])))["stationary"]

    def test_not_on_the_target(self):
        assert not flags(stop_of([3.0, 0.0], q=np.zeros(3)))["stationary"]

    def test_joints_that_the_task_pushes_outward_at_a_limit_do_not_count(self):
        robot = jtik.Robot.planar(2, lower=[-0.2, 0.1], upper=[0.2, 0.4])
        assert flags(stop_of([0.5, 1.5], q=np.array([0.2, 0.4]), robot=robot))["stationary"]
        assert not flags(stop_of([0.5, 1.5], q=np.array([0.2, 0.3]), robot=robot))["stationary"]


class TestStepAndReport:
    """The stopping test never measures less than the report of the solution, whichever limits are active."""

    @pytest.mark.thinned
    @pytest.mark.parametrize("weights", [None, np.array([1.0, 9.0, 0.25, 4.0, 1.0, 2.0, 1.0])])
    @pytest.mark.parametrize("kind", ["position", "pose"])
    def test_the_residual_of_the_step_is_at_least_that_of_the_report(self, kind, weights, rng):
        robot = jtik.Robot.planar(7, lower=-1.5, upper=1.0)
        criterion, task = JointCentering(preferred=[0.5] * 7), jtik.FrameTask(kind=kind)
        ik = shared_solver(robot, task, criteria=criterion, weights=weights)
        problem, q, flags = ik._engine.problem, casadi.SX.sym("q", 7), casadi.SX.sym("active", 7)
        target = casadi.SX.sym("target", problem.tasks.read_target(robot.pose(np.zeros(7))).size)
        inputs = constants(inputs_of(problem, robot.pose(np.zeros(7))))._replace(target=target)
        at = linearized(problem, q, inputs, {"neighbourhood": casadi.SX(1.0), "active": flags}, None)
        of_step = casadi.Function("of_step", [q, target, flags], [at.active_set.stationarity_residual(at.model)])
        equal = 0
        for _ in range(300):
            angles = rng.uniform(-1.4, 0.9, size=7)
            limits = rng.random((2, 7)) < 0.3
            angles[limits[0]], angles[limits[1]] = -1.5, 1.0
            pose = robot.pose(angles + rng.choice([0, 1e-7]) * rng.normal(size=7))
            report = ik.solve(pose, q0=angles, max_iterations=0).report
            found = float(of_step(angles, problem.tasks.read_target(pose), rng.random(7) < 0.7))
            assert found >= report.null_space_residual * (1 - 1e-9) - 1e-12
            equal += found <= report.null_space_residual * (1 + 1e-6)
        assert weights is not None or equal > 5
