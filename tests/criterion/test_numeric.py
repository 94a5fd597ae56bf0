"""Numeric criteria: functions of numbers, with a gradient that is given or by differences."""

from __future__ import annotations

import copy
import gc
import pickle
import weakref
from concurrent.futures import ThreadPoolExecutor

import casadi
import numpy as np
import pytest

import jtik
from jtik.testing import check_criterion
from jtik_formulations import JointCentering

from ..conftest import DIFFERENCES, EXACT, differences, planar, planar_points
from .shared import STRATEGIES, at, new_solver, solver


def height(q, aim):
    return 2 * (planar_points(q)[2][1] - aim) ** 2 + 0.1 * np.sum(np.sin(q))


@jtik.criterion(numeric=True)
def elbow(q, *, aim=0.5):
    """By NumPy alone: nothing of it can be traced."""
    return height(np.array([float(each) for each in q]), aim)


def elbow_gradient(q, *, aim):
    angle = np.cumsum(q)
    along = np.array([np.cos(angle[j:3]).sum() if j < 3 else 0.0 for j in range(len(q))])
    return 4 * (planar_points(q)[2][1] - aim) * along + 0.1 * np.cos(q)


@jtik.criterion(numeric=True, gradient=elbow_gradient)
def elbow_with_gradient(q, *, aim=0.5):
    return height(q, aim)


@jtik.criterion
def elbow_traced(q, robot, *, aim=0.5):
    return 2 * (robot.position(q, "link4")[1] - aim) ** 2 + 0.1 * casadi.sum1(casadi.sin(q))


@jtik.criterion(numeric=True)
def tilt(q, *, up=(0.0, 0.0, 1.0)):
    """Of a ball joint, whose configuration is a quaternion."""
    w, x, y, z = q[:4]
    R = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    return 1 - (R @ up)[2] + 0.05 * np.sum(q[4:] ** 2)


Q0, TARGET = np.array([0.3, 0.4, -0.2, 0.5, 0.1]), (2.8, 1.6)


class TestValuesAndDerivatives:
    @pytest.mark.parametrize("criterion", [elbow, elbow_with_gradient])
    def test_value_and_gradient(self, criterion, rng):
        robot = planar(5)
        q = robot.random_configuration(rng)
        assert criterion(q, robot) == pytest.approx(elbow_traced(q, robot), rel=EXACT)
        assert criterion(q, robot, aim=2.0) == pytest.approx(elbow_traced(q, robot, aim=2.0), rel=EXACT)
        assert criterion.gradient(q, robot) == pytest.approx(elbow_traced.gradient(q, robot), abs=1e-8)
        assert isinstance(criterion(aim=1.0), jtik.Criterion)
        assert criterion(aim=1.0)(q, robot) == pytest.approx(elbow_traced(q, robot, aim=1.0), rel=EXACT)

    @pytest.mark.slow
    @pytest.mark.parametrize("criterion", [elbow, elbow_with_gradient])
    def test_it_fulfils_the_contract(self, criterion):
        check_criterion(criterion, planar(5), samples=2)

    @pytest.mark.slow
    def test_on_a_ball_joint_the_derivatives_follow_rotations(self, rng):
        robot = jtik.Robot(
            [
                jtik.Joint("ball", jtik.JointType.BALL, "base", "socket"),
                jtik.Joint("elbow", jtik.JointType.REVOLUTE, "socket", "hand", axis=(1, 0, 0)),
            ]
        )
        q = robot.random_configuration(rng)
        expected = differences(lambda p: tilt(p, robot), robot, q)[0]
        assert tilt.gradient(q, robot) == pytest.approx(expected, abs=DIFFERENCES)
        check_criterion(tilt, robot, samples=2)

    def test_parameters_are_live_and_have_their_shapes(self):
        seen = []

        @jtik.criterion(numeric=True)
        def shaped(q, *, scale=2.0, point=(1.0, 2.0), matrix=((0.0, 1.0, 2.0), (3.0, 4.0, 5.0))):
            seen.append((scale, point, matrix))
            return float(scale * q[0] + point[1] + matrix[0, 1])

        robot, q = planar(3), np.array([0.1, 0.2, 0.3])
        ik = new_solver(robot, shaped)
        assert at(ik, q).cost == pytest.approx(0.2 + 2 + 1)
        ik.parameters["shaped.matrix"] = [[0, 10, 0], [0, 0, 0]]
        ik.parameters["shaped.scale"] = 1.0
        ik.parameters["shaped.weight"] = 2.0
        assert at(ik, q).cost == pytest.approx(2 * (0.1 + 2 + 10))
        assert (type(seen[0][0]), seen[0][1].shape, seen[0][2].shape) == (float, (2,), (2, 3))


class TestSolves:
    @pytest.mark.quick(3, slow=6)
    @pytest.mark.parametrize("strategy", [*STRATEGIES, "hybrid+qp", "hybrid+second_order"])
    def test_every_strategy_solves_as_with_the_traced_criterion(self, strategy):
        options = {"q0": Q0, "max_iterations": 3000, "position_tolerance": 1e-4, "optimality_tolerance": 1e-4}
        expected = solver(planar(5), elbow_traced, strategy).solve(TARGET, **options)
        for criterion in (elbow_with_gradient, *([elbow] if strategy in ("hybrid", "weighted_qp") else [])):
            found = new_solver(planar(5), criterion, strategy).solve(TARGET, **options)
            assert found.status is expected.status
            assert found.position_error <= 1e-4 or strategy == "weighted_qp"
            assert found.cost == pytest.approx(expected.cost, rel=1e-4)

    @pytest.mark.slow
    def test_the_minimum_is_recognised(self):
        solution = new_solver(planar(5), elbow, "hybrid+second_order").solve(TARGET, q0=Q0)
        expected = solver(planar(5), elbow_traced, "hybrid+second_order").solve(TARGET, q0=Q0)
        assert solution.second_order == expected.second_order == "minimum"
        assert solution.iterations == expected.iterations

    def test_together_with_a_traced_criterion(self):
        found = new_solver(planar(5), 0.5 * elbow + JointCentering()).solve(TARGET, q0=Q0)
        expected = new_solver(planar(5), 0.5 * elbow_traced + JointCentering()).solve(TARGET, q0=Q0)
        assert found.q == pytest.approx(expected.q, abs=1e-6)

    @pytest.mark.slow
    def test_step_track_trace_and_batch(self):
        ik, traced = new_solver(planar(5), elbow), solver(planar(5), elbow_traced)
        assert ik.step(Q0, TARGET, dt=0.01).q == pytest.approx(traced.step(Q0, TARGET, dt=0.01).q, abs=1e-9)
        path = [np.add(TARGET, (0.01 * k, 0.0)) for k in range(3)]
        assert ik.track(path, q0=Q0).q == pytest.approx(traced.track(path, q0=Q0).q, abs=1e-6)
        solution = ik.solve(TARGET, q0=Q0, trace=True)
        assert solution.trace.H[-1] == pytest.approx(solution.cost)
        assert ik.solve_batch([TARGET], q0=Q0).q[0] == pytest.approx(traced.solve(TARGET, q0=Q0).q, abs=1e-5)

    def test_evaluations_are_counted(self):
        calls = []

        @jtik.criterion(numeric=True)
        def counted(q):
            calls.append(q)
            return float(q @ q)

        ik = new_solver(planar(5), counted)
        before = len(calls)
        solution = ik.solve(TARGET, q0=Q0)
        assert solution.evaluations == len(calls) - before > 10 * solution.iterations
        assert f"evaluations {solution.evaluations} of numeric criteria" in repr(solution)
        assert pickle.loads(pickle.dumps(solution)).evaluations == solution.evaluations
        assert len({tuple(q) for q in calls}) > 0.9 * len(calls)  # hardly anything is computed twice
        cheaper = new_solver(planar(5), elbow_with_gradient).solve(TARGET, q0=Q0)
        assert cheaper.evaluations < new_solver(planar(5), elbow).solve(TARGET, q0=Q0).evaluations / 3
        assert solver(planar(5), elbow_traced).solve(TARGET, q0=Q0).evaluations == 0

    @pytest.mark.slow
    def test_copies_and_pickles(self):
        ik, options = new_solver(planar(5), elbow), {"q0": Q0, "max_iterations": 8}
        expected = ik.solve(TARGET, **options).q
        for again in (copy.deepcopy(ik), pickle.loads(pickle.dumps(ik))):
            assert again.solve(TARGET, **options).q.tolist() == expected.tolist()
        with ThreadPoolExecutor(2) as pool:
            twins = [copy.deepcopy(ik) for _ in range(4)]
            found = list(pool.map(lambda each: each.solve(TARGET, **options).q.tolist(), twins))
        assert found == [expected.tolist()] * 4

    @pytest.mark.slow
    def test_in_a_study(self):
        study = jtik.compare(
            planar(5),
            jtik.FrameTask(),
            strategies=["hybrid", "newton+qp"],
            criteria=elbow_with_gradient,
            count=2,
            repeats=1,
        )
        assert study.columns["success"].all()

    def test_the_robot_is_not_kept_alive(self):
        robot = jtik.Robot.planar(5)  # that of the fixtures is kept
        elbow(Q0, robot)
        gone = weakref.ref(robot)
        del robot
        gc.collect()
        assert gone() is None


class TestWrongInput:
    def refused(self, function, message, **options):
        with pytest.raises(jtik.CriterionError, match=message) as caught:
            new_solver(planar(3), jtik.criterion(numeric=True, **options)(function))
        return caught.value

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ("1.0", r"returned str '1.0' at q = \[0.0, 0.0, 0.0\]; expected one number, H"),
            (None, "returned NoneType at q"),
            (1j, "returned complex 1j at q"),
            (True, "returned bool True"),
            (np.ones(2), r"returned ndarray array\(\[1., 1.\]\)"),
            (np.nan, r"is nan at q = \[0., 0., 0.\]"),
            (np.inf, "is inf at q"),
        ],
    )
    def test_what_is_no_number_is_refused_with_the_configuration(self, given, message):
        self.refused(lambda q: given, message)

    def test_at_a_random_configuration(self):
        self.refused(lambda q: "far" if np.abs(q).max() > 0.5 else 1.0, r"returned str 'far' at q = \[0.86")

    def test_an_error_is_named(self):
        error = self.refused(lambda q: q[7], "raised IndexError: index 7 is out of bounds")
        assert isinstance(error.__cause__, IndexError)

    def test_a_gradient_of_wrong_shape(self):
        message = r"its gradient returned shape \(2,\) at q = \[0.0, 0.0, 0.0\]; expected dH/dv of shape \(3,\)"
        self.refused(lambda q: 1.0, message, gradient=lambda q: np.zeros(2))

    def test_an_error_within_a_solve_ends_it_and_is_kept(self):
        fails = []

        @jtik.criterion(numeric=True)
        def fragile(q):
            if fails:
                raise ZeroDivisionError("no contact")
            return float(q @ q)

        ik = new_solver(planar(3), fragile)
        fails.append(1)
        assert ik.solve((1.0, 1.0), q0=[0.7, 0.4, 0.3]).status is jtik.Status.NOT_FINITE
        assert "raised ZeroDivisionError: no contact" in str(fragile.failure(ik.robot))

    def test_compiled_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match="given True with the numeric criterion 'elbow'; accepted"):
            new_solver(planar(5), elbow, compiled=True)

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"numeric": 1}, "numeric: given 1"),
            ({"numeric": True, "residual": True}, "residual: given True; accepted: False with numeric=True"),
            ({"gradient": elbow_gradient}, "gradient: given .*accepted: None, or a function with numeric=True"),
            ({"numeric": True, "gradient": 3}, "gradient: given 3"),
            ({"numeric": True, "step": 0.0}, "step: given 0.0; accepted: a positive number"),
            ({"numeric": True, "step": np.nan}, "step: given nan"),
        ],
    )
    def test_options(self, options, message):
        with pytest.raises(jtik.ArgumentError, match=message):
            jtik.criterion(**options)(lambda q: 1.0)

    def test_the_signature(self):
        with pytest.raises(jtik.ArgumentError, match=r"accepted: a function f\(q, \*, parameter=first_value"):
            jtik.criterion(numeric=True)(lambda q, robot: 1.0)


class Square(casadi.Callback):
    """Of a user, in a traced criterion: with a Jacobian, or without derivatives."""

    def __init__(self, derivatives):
        casadi.Callback.__init__(self)
        self.derivatives = derivatives
        self.construct("square", {})

    def get_n_in(self):
        return 1

    def get_n_out(self):
        return 1

    def eval(self, arguments):
        return [float(arguments[0]) ** 2]

    def has_jacobian(self):
        return self.derivatives

    def get_jacobian(self, name, inputs, outputs, options):
        x, y = casadi.MX.sym("x"), casadi.MX.sym("y")
        return casadi.Function(name, [x, y], [2 * x], inputs, outputs)


class TestCallbacks:
    @pytest.mark.quick(2)
    @pytest.mark.parametrize("strategy", ["hybrid", "newton+qp", "hybrid+second_order", "lexicographic_qp"])
    def test_a_callback_of_ones_own(self, strategy):
        square = Square(derivatives=True)
        own = jtik.criterion(lambda q, robot: square(q[0]) + casadi.sumsqr(q[1:]))
        found = new_solver(planar(4), own, strategy).solve((2.0, 1.0), q0=[0.3] * 4)
        traced = jtik.criterion(lambda q, robot: casadi.sumsqr(q))
        expected = new_solver(planar(4), traced, strategy).solve((2.0, 1.0), q0=[0.3] * 4)
        assert found.status is expected.status
        assert found.q == pytest.approx(expected.q, abs=1e-8)

    def test_without_derivatives_and_compiled_it_is_refused(self):
        for derivatives, options, error, message in (
            (False, {}, jtik.CriterionError, r"numeric=True"),
            (True, {"compiled": True}, jtik.ArgumentError, "True with the casadi.Callback 'square' in a criterion"),
        ):
            square = Square(derivatives)
            with pytest.raises(error, match=message):
                new_solver(planar(3), _calling(square), **options)

    @pytest.mark.parametrize("strategy", ["hybrid", "hybrid+second_order"])
    def test_an_interpolant(self, strategy):
        table = casadi.interpolant("table", "bspline", [np.linspace(-4, 4, 41)], np.linspace(-4, 4, 41) ** 2)
        found = new_solver(planar(4), _calling(table), strategy).solve((2.0, 1.0), q0=[0.3] * 4)
        expected = new_solver(planar(4), jtik.criterion(lambda q, robot: q[0] ** 2), strategy).solve(
            (2.0, 1.0), q0=[0.3] * 4
        )
        assert found.status is expected.status


def _calling(function):
    def called(q, robot):
        return function(q[0])

    return jtik.criterion(called)


@pytest.mark.slow
@pytest.mark.parametrize("interruption", [KeyboardInterrupt, SystemExit])
def test_what_interrupts_a_function_reaches_the_caller(interruption):
    """Ctrl-C, or sys.exit, while a numeric function runs; the solver can be used afterwards."""
    arm, calls, moment = planar(5), [0], [0]

    @jtik.criterion(numeric=True)
    def interrupted(q, *, c=1.0):
        calls[0] += 1
        if calls[0] == moment[0]:
            raise interruption
        return float(((q - c) ** 2).sum())

    ik = jtik.InverseKinematics(arm, jtik.FrameTask(), criteria=interrupted)
    targets = [arm.position(arm.random_configuration(seed)) for seed in range(3)]
    expected = ik.solve_batch(targets)

    def set_off(after):
        calls[0], moment[0] = 0, after

    q = arm.random_configuration(9)
    for call in (
        lambda: ik.solve(targets[0], q0=q),
        lambda: ik.track(targets, q0=q, dt=0.1),
        lambda: ik.step(q, targets[1]),
    ):
        set_off(3)
        ik.reset()
        with pytest.raises(interruption):
            call()
        set_off(0)
        ik.solve(targets[2])  # other values are kept now
    again = ik.solve_batch(targets)
    assert np.array_equal(again.q, expected.q)


def test_an_interrupted_batch_has_the_rows_that_are_done():
    arm, calls = planar(5), [0]

    @jtik.criterion(numeric=True)
    def interrupted(q, *, c=1.0):
        calls[0] += 1
        if calls[0] == 600:
            raise KeyboardInterrupt
        return float(((q - c) ** 2).sum())

    ik = jtik.InverseKinematics(arm, jtik.FrameTask(), criteria=interrupted)
    targets = [arm.position(arm.random_configuration(seed)) for seed in range(40)]
    batch = ik.solve_batch(targets)
    assert not batch.complete
    assert 0 < len(batch) < len(targets)


class TestTheGivenGradient:
    """A gradient that is not that of the function is noticed when a solver is built."""

    @pytest.mark.parametrize("factor", [-1.0, 2.0, 1.05])
    def test_a_wrong_one_is_refused(self, factor):
        wrong = jtik.criterion(numeric=True, gradient=lambda q, *, aim: factor * elbow_gradient(q, aim=aim))(
            elbow_numbers
        )
        with pytest.raises(jtik.CriterionError, match="its gradient says that H changes by .* and the function by"):
            new_solver(planar(5), wrong)

    def test_a_coarse_one_is_accepted(self):
        coarse = jtik.criterion(numeric=True, gradient=lambda q, *, aim: 1.002 * elbow_gradient(q, aim=aim))(
            elbow_numbers
        )
        assert new_solver(planar(5), coarse).solve(TARGET, q0=Q0).status.on_target

    def test_a_function_with_a_kink_at_home_is_accepted(self):
        kinked = jtik.criterion(numeric=True, gradient=lambda q: np.sign(q))(kink)
        assert new_solver(planar(5), kinked).solve(TARGET, q0=Q0).status.on_target


def elbow_numbers(q, *, aim=0.5):
    return height(q, aim)


def kink(q):
    return float(np.abs(q).sum())
