"""InverseKinematics: solve, step, track, and what they refuse at the door."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.strategy import Update
from jtik.symbolic.compile import CompilerError
from jtik_formulations import JointCentering, ObstacleAvoidance

from .conftest import EXACT, ball_arm, dh_arm, floating_arm, planar, planar_points

STRATEGIES = sorted(jtik.strategies)
FIELD = [jtik.Circle((4.0, 2.0), 0.6), jtik.Circle((6.5, -1.0), 0.8)]


def solver(robot, *, kind="position", **options):
    return jtik.InverseKinematics(robot, jtik.FrameTask("tip", kind), **options)


class TestSolve:
    def test_the_example_of_the_readme(self):
        ik = jtik.InverseKinematics(
            jtik.Robot.planar(10),
            jtik.FrameTask("tip", kind="position"),
            criteria=1.0 * JointCentering() + 0.3 * ObstacleAvoidance(FIELD),
            strategy="hybrid",
        )
        solution = ik.solve([6.0, 3.0], q0=[0.1] * 10)
        assert solution.status is jtik.Status.CONVERGED
        assert planar_points(solution.q)[-1] == pytest.approx([6, 3], abs=1e-6)

    @pytest.mark.parametrize("strategy", STRATEGIES)
    @pytest.mark.parametrize("n", [1, 2, 3, 7, 15])
    def test_any_number_of_joints(self, strategy, n):
        robot = planar(n)
        q0 = np.linspace(0.5, 0.1, n)
        target = robot.position(q0 + 0.1)
        for criteria in (None, JointCentering()):
            solution = solver(robot, strategy=strategy, criteria=criteria).solve(
                target, q0=q0, max_iterations=5000, position_tolerance=1e-3
            )
            assert robot.position(solution.q) == pytest.approx(target, abs=1e-3)
            assert solution.jacobian.shape == (2, n)
            assert solution.gradient.shape == (n,)

    def test_tolerances_are_kept_and_matter(self):
        ik, q0 = solver(planar(5)), [0.3] * 5
        for tolerance in (1e-1, 1e-4, 1e-10):
            solution = ik.solve([2.0, 3.0], q0=q0, position_tolerance=tolerance)
            assert solution.converged
            assert solution.position_error <= tolerance
            assert solution.position_error == pytest.approx(
                np.linalg.norm(planar_points(solution.q)[-1] - (2, 3)), abs=EXACT
            )
        assert ik.solve([2.0, 3.0], q0=q0, position_tolerance=1e-1).position_error > 1e-10

    def test_position_and_orientation_have_tolerances_of_their_own(self):
        ik, target = solver(planar(5), kind="pose"), (2.0, 3.0, 1.0)
        loose = ik.solve(target, q0=[0.3] * 5, position_tolerance=1e-9, orientation_tolerance=10.0)
        assert loose.position_error <= 1e-9
        other = ik.solve(target, q0=[0.3] * 5, position_tolerance=10.0, orientation_tolerance=1e-9)
        assert other.orientation_error <= 1e-9
        assert other.iterations <= loose.iterations

    def test_optimality_tolerance_is_what_is_left_of_the_projected_gradient(self):
        ik = solver(planar(6), criteria=JointCentering())
        q0 = [0.8, -0.5, 0.3, 0.9, -0.2, 0.4]
        for tolerance in (1e-1, 1e-3, 1e-8):
            solution = ik.solve([3.0, 2.0], q0=q0, optimality_tolerance=tolerance)
            J, g = solution.jacobian, solution.gradient
            h = g - np.linalg.pinv(J) @ J @ g
            assert solution.status is jtik.Status.CONVERGED
            assert np.linalg.norm(h) <= tolerance * max(1, np.linalg.norm(g))
            assert solution.null_space_residual == pytest.approx(np.linalg.norm(h), abs=1e-10)

    def test_from_the_neutral_configuration_by_default(self):
        robot = jtik.Robot.planar(3, lower=[0.2, -1, -1], upper=[2, 1, 1])
        ik = solver(robot)
        assert ik.solve([2.0, 1.5]).q.tolist() == ik.solve([2.0, 1.5], q0=robot.neutral).q.tolist()

    def test_what_comes_in_is_not_changed_and_what_goes_out_is_ours(self):
        q0 = np.array([0.3, 0.4, 0.5])
        ik = solver(planar(3))
        first = ik.solve([1.0, 1.5], q0=q0)
        kept = first.q.copy()
        first_error = first.error.copy()
        ik.solve([0.5, 2.0], q0=first.q)
        assert q0.tolist() == [0.3, 0.4, 0.5]
        assert first.q.tolist() == kept.tolist()
        assert first.error.tolist() == first_error.tolist()

    def test_on_the_target_already_nothing_is_tried(self):
        q0 = np.array([0.3, 0.4, 0.5])
        ik = solver(planar(3))
        solution = ik.solve(planar_points(q0)[-1], q0=q0)
        assert solution.status is jtik.Status.CONVERGED
        assert solution.iterations == 0
        assert solution.q.tolist() == q0.tolist()

    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_the_same_question_has_the_same_answer(self, strategy):
        options = {"criteria": JointCentering() + ObstacleAvoidance(FIELD), "strategy": strategy}
        ik, q0 = solver(planar(10), **options), np.full(10, 0.1)
        first = ik.solve([6.0, 3.0], q0=q0, max_iterations=300)
        ik.solve([1.0, 1.0], q0=-q0, max_iterations=50)
        ik.step(q0, [3.0, 3.0])
        again = ik.solve([6.0, 3.0], q0=q0, max_iterations=300)
        traced = ik.solve([6.0, 3.0], q0=q0, max_iterations=300, trace=True)
        elsewhere = solver(planar(10), **options).solve([6.0, 3.0], q0=q0, max_iterations=300)
        for other in (again, traced, elsewhere):
            assert other.q.tolist() == first.q.tolist()
            assert other.iterations == first.iterations
            assert other.status is first.status

    def test_nothing_is_printed(self, capfd):
        ik = solver(planar(5), criteria=JointCentering() + ObstacleAvoidance(FIELD))
        for target in ([3.0, 1.0], [9.0, 0.0]):
            ik.solve(target, trace=True)
            ik.step([0.1] * 5, target)
        ik.track([[3.0, 1.0], [3.0, 1.2]])
        repr(ik)
        assert capfd.readouterr() == ("", "")

    def test_limits_can_be_left_out_of_account(self):
        robot = jtik.Robot.planar(3, lower=-0.2, upper=0.2)
        assert solver(robot).solve([0.5, 2.0]).status is not jtik.Status.CONVERGED
        free = solver(robot, limits=False).solve([0.5, 2.0], q0=[0.1, 0.1, 0.1])
        assert free.converged
        assert np.abs(free.q).max() > 0.2

    def test_repr_names_its_parts(self):
        text = repr(solver(planar(3), criteria=JointCentering() + ObstacleAvoidance(jtik.Point((1, 1)))))
        for part in ("planar3", "FrameTask('tip'", "joint_centering + obstacle_avoidance", "Hybrid("):
            assert part in text


class TestUntil:
    def test_reached_stops_on_arrival_steady_goes_on(self):
        ik, q0 = solver(planar(6), criteria=JointCentering()), [0.8, -0.5, 0.3, 0.9, -0.2, 0.4]
        arrived = ik.solve([3.0, 2.0], q0=q0, until="reached")
        settled = ik.solve([3.0, 2.0], q0=q0, until="stationary")
        assert arrived.status is jtik.Status.REACHED
        assert arrived.converged
        assert settled.status is jtik.Status.CONVERGED
        assert arrived.iterations < settled.iterations
        assert arrived.position_error <= 1e-6
        assert settled.cost < arrived.cost

    def test_reached_on_the_target_tries_nothing(self):
        ik, q0 = solver(planar(3), criteria=JointCentering()), np.array([0.3, 0.4, 0.5])
        solution = ik.solve(planar_points(q0)[-1], q0=q0, until="reached")
        assert solution.q.tolist() == q0.tolist()
        assert solution.iterations == 0
        assert solution.converged

    def test_without_a_criterion_both_are_one(self):
        ik = solver(planar(4))
        both = [ik.solve([2.0, 2.0], q0=[0.2] * 4, until=until) for until in ("reached", "stationary")]
        assert both[0].q.tolist() == both[1].q.tolist()
        assert both[0].status is both[1].status is jtik.Status.CONVERGED

    @pytest.mark.parametrize("until", ["done", None, 1])
    def test_something_else_is_refused(self, until):
        with pytest.raises(jtik.ArgumentError, match="until.*'stationary' or 'reached'"):
            solver(planar(2)).solve([1.0, 1.0], until=until)


class TestMaxIterations:
    def test_zero_looks_and_does_not_move(self):
        q0 = np.array([0.3, 0.4, 0.5])
        ik = solver(planar(3), criteria=JointCentering())
        solution = ik.solve([1.0, 2.0], q0=q0, max_iterations=0)
        assert solution.q.tolist() == q0.tolist()
        assert solution.iterations == 0
        assert solution.status is jtik.Status.ITERATION_LIMIT
        assert not solution.converged
        assert solution.error == pytest.approx(planar_points(q0)[-1] - (1, 2), abs=EXACT)
        assert solution.cost == pytest.approx(q0 @ q0 / 2)

    @pytest.mark.parametrize("limit", [1, 2, 5])
    def test_are_never_exceeded(self, limit):
        solution = solver(planar(8), strategy="transpose").solve([3, 3], q0=[0.1] * 8, max_iterations=limit, trace=True)
        assert solution.iterations == limit
        assert len(solution.trace) == limit
        assert solution.status is jtik.Status.ITERATION_LIMIT

    def test_numpy_integers_count(self):
        assert solver(planar(3)).solve([1, 1], q0=[0.3] * 3, max_iterations=np.int64(1)).iterations == 1

    @pytest.mark.parametrize("limit", [-1, 2.5, "many", None])
    def test_something_else_is_refused(self, limit):
        with pytest.raises(jtik.ArgumentError, match="max_iterations.*integer from 0"):
            solver(planar(2)).solve([1.0, 1.0], max_iterations=limit)


class TestTrace:
    FIGURES = (
        "V",
        "H",
        "V2",
        "alpha",
        "beta",
        "predicted_decrease",
        "actual_decrease",
        "accepted",
        "null_residual",
        "sigma_min",
        "leakage",
        "escaped",
    )

    def solution(self, strategy="hybrid", criteria=None, **options):
        ik = solver(planar(6), strategy=strategy, criteria=criteria)
        return ik.solve([3.0, 2.0], q0=[0.8, -0.5, 0.3, 0.9, -0.2, 0.4], trace=True, **options)

    def test_none_unless_asked_for(self):
        assert solver(planar(2)).solve([1.0, 1.0], q0=[0.1, 0.2]).trace is None

    @pytest.mark.parametrize("strategy", STRATEGIES)
    @pytest.mark.parametrize("criteria", [None, JointCentering()])
    def test_has_every_figure_it_promises_once_an_iteration(self, strategy, criteria):
        solution = self.solution(strategy, criteria, max_iterations=30)
        trace = solution.trace
        assert len(trace) == solution.iterations > 0
        assert trace.q.shape == (len(trace) + 1, 6)
        assert trace.error.shape == (len(trace) + 1,)
        for name in self.FIGURES:
            assert getattr(trace, name).shape == (len(trace),), name
            assert trace.figures[name] is getattr(trace, name)

    def test_figures_are_what_they_say(self):
        solution = self.solution(criteria=JointCentering())
        trace = solution.trace
        robot = planar(6)
        for k, q in enumerate(trace.q[:-1]):
            e = planar_points(q)[-1] - (3, 2)
            J = robot.jacobian(q)[:2]
            assert trace.V[k] == pytest.approx(e @ e / 2, rel=1e-9, abs=1e-20)
            assert trace.error[k] == pytest.approx(np.linalg.norm(e), abs=EXACT)
            assert trace.H[k] == pytest.approx(q @ q / 2, rel=EXACT)
            assert trace.sigma_min[k] == pytest.approx(np.linalg.svd(J, compute_uv=False)[-1], abs=1e-10)
            h = q - np.linalg.pinv(J) @ J @ q
            assert trace.null_residual[k] == pytest.approx(np.linalg.norm(h), abs=1e-10)
            if trace.accepted[k] == 1:
                after = planar_points(trace.q[k + 1])[-1] - (3, 2)
                assert trace.actual_decrease[k] == pytest.approx(e @ e / 2 - after @ after / 2, abs=1e-11)
            else:
                assert trace.q[k + 1].tolist() == q.tolist()
        assert trace.q[-1].tolist() == solution.q.tolist()
        assert trace.error[-1] == pytest.approx(solution.position_error, abs=EXACT)

    def test_rows_are_there_without_an_iteration_too(self):
        q0 = np.array([0.3, 0.4])
        ik = solver(planar(2))
        for options in ({"max_iterations": 0}, {}):
            target = planar_points(q0)[-1] + (0.1 if options else 0.0)
            trace = ik.solve(target, q0=q0, trace=True, **options).trace
            assert len(trace) == 0
            assert trace.q.tolist() == [q0.tolist()]
            assert trace.V.shape == (0,)

    def test_a_figure_that_is_not_there_lists_those_that_are(self):
        trace = self.solution().trace
        with pytest.raises(AttributeError, match="q, error, V, H.*not 'speed'"):
            _ = trace.speed
        assert not hasattr(trace, "speed")

    def test_survives_copying_and_pickling(self):
        import copy
        import pickle

        trace = self.solution().trace
        for twin in (copy.copy(trace), copy.deepcopy(trace), pickle.loads(pickle.dumps(trace))):
            assert twin.V.tolist() == trace.V.tolist()


class TestRefusals:
    @pytest.mark.parametrize("q", [[0.1], [0.1] * 3, 0.1, [[0.1, 0.2]], [0.1, np.nan], [np.inf, 0], "ab", [0.1, None]])
    def test_a_configuration_of_another_shape_or_not_finite_by_name(self, q):
        ik = solver(planar(2))
        for call, name in (
            (lambda: ik.solve([1.0, 1.0], q0=q), "q0"),
            (lambda: ik.step(q, [1.0, 1.0]), "q"),
            (lambda: ik.track([[1.0, 1.0]], q0=q), "q0"),
        ):
            with pytest.raises(jtik.ArgumentError, match=r"shape \(2,\)") as caught:
                call()
            assert caught.value.argument == name

    @pytest.mark.parametrize("dtype", [np.float32, np.int64, bool])
    def test_other_numbers_are_read_as_floats(self, dtype):
        ik = solver(planar(2))
        q = np.array([1, 0], dtype=dtype)
        assert ik.step(q, np.array([1, 1], dtype=np.float32)).q.tolist() == ik.step([1.0, 0.0], [1.0, 1.0]).q.tolist()

    @pytest.mark.parametrize("name", ["position_tolerance", "orientation_tolerance", "optimality_tolerance"])
    @pytest.mark.parametrize("value", [0.0, -1e-6, np.nan, np.inf, "small", [1e-6, 1e-6]])
    def test_tolerances_are_finite_and_positive(self, name, value):
        with pytest.raises(jtik.ArgumentError) as caught:
            solver(planar(2)).solve([1.0, 1.0], **{name: value})
        assert caught.value.argument == name

    @pytest.mark.parametrize("robot", [None, "planar", 3])
    def test_what_is_no_robot(self, robot):
        with pytest.raises(jtik.ArgumentError, match="robot.*a jtik.Robot"):
            solver(robot)

    def test_limits_that_are_crossed(self):
        with pytest.raises(jtik.ArgumentError, match="limits"):
            jtik.Robot.planar(2, lower=[0.0, 1.0], upper=[1.0, 0.0])

    def test_a_zero_quaternion(self):
        robot = ball_arm()
        q0 = robot.neutral.copy()
        q0[:4] = 0
        with pytest.raises(jtik.ArgumentError, match="quaternion"):
            solver(robot).solve([0.5, 0.5, 0.5], q0=q0)
        with pytest.raises(jtik.ArgumentError, match="quaternion"):
            solver(robot).step(q0, [0.5, 0.5, 0.5])

    def test_a_refusal_leaves_the_solver_as_it_was(self):
        ik, q0 = solver(planar(3)), [0.3, 0.2, 0.1]
        before = ik.solve([1.0, 1.0], q0=q0).q.tolist()
        for wrong in (
            {"q0": [np.nan] * 3},
            {"position_tolerance": -1},
            {"max_iterations": -1},
            {"until": "x"},
        ):
            with pytest.raises(jtik.ArgumentError):
                ik.solve([2.0, 0.0], **wrong)
        with pytest.raises(jtik.ArgumentError):
            ik.solve([np.nan, 0.0])
        assert ik.solve([1.0, 1.0], q0=q0).q.tolist() == before

    def test_a_controllers_arrays_are_checked_as_lists_are(self):
        """The fast way for arrays must not let NaN, infinity or another shape through."""
        ik = solver(planar(2))
        good, target = np.array([0.1, 0.2]), np.array([1.0, 1.0])
        for q, x, name in (
            (np.array([np.nan, 0.0]), target, "q"),
            (np.array([-np.inf, 0.0]), target, "q"),
            (np.zeros(3), target, "q"),
            (np.zeros((2, 1)), target, "q"),
            (good, np.array([np.nan, 0.0]), "target"),
            (good, np.array([np.inf, 0.0]), "target"),
            (good, np.zeros(3), "target"),
        ):
            with pytest.raises(jtik.ArgumentError) as caught:
                ik.step(q, x)
            assert caught.value.argument == name


class TestStep:
    @pytest.mark.parametrize("strategy", STRATEGIES)
    @pytest.mark.parametrize("criteria", [None, JointCentering()])
    def test_a_sequence_is_a_solve(self, strategy, criteria):
        ik = solver(planar(6), strategy=strategy, criteria=criteria)
        q0 = np.array([0.8, -0.5, 0.3, 0.9, -0.2, 0.4])
        solution = ik.solve([3.0, 2.0], q0=q0, trace=True, max_iterations=40)
        q = q0
        for k in range(solution.iterations):
            assert q.tolist() == solution.trace.q[k].tolist()
            step = ik.step(q, [3.0, 2.0])
            assert step.accepted == (solution.trace.accepted[k] == 1)
            q = step.q
        assert q.tolist() == solution.q.tolist()

    def test_it_converges_and_then_says_so_and_stays(self):
        ik, q = solver(dh_arm(7, 3), kind="pose"), np.full(7, 0.3)
        target = ik.robot.pose(q + 0.2)
        for _ in range(50):
            step = ik.step(q, target)
            q = step.q
            if step.done:
                break
        assert step.done
        assert step.position_error <= 1e-6
        assert step.orientation_error <= 1e-6
        assert ik.robot.pose(q) == pytest.approx(target, abs=3e-6)
        again = ik.step(q, target)
        assert again.done
        assert again.q.tolist() == q.tolist()

    def test_errors_are_those_of_where_it_arrives(self):
        ik, q = solver(planar(4)), [0.4, 0.3, 0.2, 0.1]
        step = ik.step(q, [2.0, 2.0])
        assert step.accepted
        assert step.position_error == pytest.approx(np.linalg.norm(planar_points(step.q)[-1] - 2.0), abs=EXACT)
        assert step.orientation_error == 0

    def test_reset_forgets_the_past(self):
        """After refusals the trust region is small; a reset makes it what it was at first."""
        ik = solver(planar(4), strategy=jtik.strategies["hybrid"](q_limit=3.0))
        q, target = np.array([0.4, 0.3, 0.2, 0.1]), np.array([-1.0, 0.1])
        first = ik.step(q, target)
        for _ in range(5):
            ik.step(q, target)
        ik.reset()
        assert ik.step(q, target).q.tolist() == first.q.tolist()

    def test_reset_before_any_step_is_harmless(self):
        solver(planar(2)).reset()

    def test_its_result_does_not_change_under_the_next_call(self):
        ik, q = solver(planar(3)), np.array([0.4, 0.3, 0.2])
        first = ik.step(q, [1.0, 1.0])
        kept = first.q.copy()
        ik.step(first.q, [0.5, 2.0])
        assert first.q.tolist() == kept.tolist()
        assert q.tolist() == [0.4, 0.3, 0.2]

    def test_a_solve_in_between_does_not_disturb_it(self):
        q, target = np.array([0.4, 0.3, 0.2, 0.1]), np.array([1.0, 2.0])
        alone, disturbed = solver(planar(4)), solver(planar(4))
        a = b = q
        for _ in range(4):
            a = alone.step(a, target).q
            disturbed.solve([3.0, 0.5], q0=q)
            b = disturbed.step(b, target).q
        assert a.tolist() == b.tolist()

    def test_options_of_an_earlier_solve_do_not_linger(self):
        """What a step does and calls done does not depend on the tolerances of whatever was solved before."""
        q = np.array([0.8, -0.5, 0.3, 0.9])
        for target in (planar_points(q)[-1], planar_points(q)[-1] + 1e-2):
            ik = solver(planar(4), criteria=JointCentering())
            fresh = ik.step(q, target)
            ik.reset()
            ik.solve([1.0, 2.0], q0=q, position_tolerance=0.5, until="reached")
            after = ik.step(q, target)
            assert after.q.tolist() == fresh.q.tolist()
            assert after.done == fresh.done


class TestTrack:
    def circle(self, count=40):
        angle = np.linspace(0, 2 * np.pi, count)
        return np.stack([2.0 + 0.5 * np.cos(angle), 1.5 + 0.5 * np.sin(angle)], axis=1)

    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_a_circle_is_followed(self, strategy):
        ik = solver(planar(4), strategy=strategy)
        q0 = ik.solve(self.circle()[0], q0=[0.5, 0.4, 0.3, 0.2], max_iterations=5000).q
        path = ik.track(self.circle(), q0=q0, dt=0.1, max_iterations=2000)
        assert path.converged
        assert len(path) == 40
        assert path.times == pytest.approx(0.1 * np.arange(1, 41))
        for q, target in zip(path.q, self.circle(), strict=True):
            assert planar_points(q)[-1] == pytest.approx(target, abs=2e-6)
        assert path.errors.max() <= 1e-6
        assert np.abs(np.diff(path.q, axis=0)).max() < 0.5  # no jumps

    @pytest.mark.parametrize("strategy", STRATEGIES)
    @pytest.mark.parametrize("criteria", [None, JointCentering()])
    def test_velocity_limits_hold_from_target_to_target(self, strategy, criteria, rng):
        speed, dt = np.array([0.5, 1.0, 0.3, 2.0]), 0.05
        robot = jtik.Robot.planar(4, velocity_limit=speed)
        ik = solver(robot, strategy=strategy, criteria=criteria)
        q0 = np.array([0.5, 0.4, 0.3, 0.2])
        targets = planar_points(q0)[-1] + np.cumsum(rng.uniform(-0.2, 0.2, (25, 2)), axis=0)
        path = ik.track(targets, q0=q0, dt=dt, until="stationary")
        steps = np.abs(np.diff(np.vstack([q0, path.q]), axis=0))
        assert (steps <= speed * dt + EXACT).all()
        assert (steps > 0.9 * speed * dt).any()  # the limits did bind

    def test_a_target_too_fast_is_followed_as_far_as_the_limits_allow(self):
        robot = jtik.Robot.planar(3, velocity_limit=1.0)
        q0 = np.array([0.5, 0.4, 0.3])
        goal = robot.position(q0 + 0.5)
        path = solver(robot).track([goal] * 30, q0=q0, dt=0.05)
        assert path.statuses[0] is jtik.Status.LIMITS
        assert not path.converged
        assert path.statuses[-1] is jtik.Status.CONVERGED
        assert (np.diff(path.errors) <= 1e-9).all()

    def test_position_limits_hold_as_well_and_come_back_unchanged(self, rng):
        robot = jtik.Robot.planar(4, lower=-0.6, upper=0.6, velocity_limit=2.0)
        ik = solver(robot)
        before = ik.solve([3.0, 1.0], q0=[0.1] * 4).q.tolist()
        path = ik.track(rng.uniform(0, 3, (20, 2)), q0=[0.1] * 4, dt=0.1)
        assert (np.abs(path.q) <= 0.6).all()
        assert ik.solve([3.0, 1.0], q0=[0.1] * 4).q.tolist() == before

    def test_a_start_outside_its_limits_is_led_back_no_faster_than_it_may(self):
        robot = jtik.Robot.planar(3, lower=-0.5, upper=0.5, velocity_limit=1.0)
        q0 = np.array([1.0, 0.2, 0.1])
        path = solver(robot).track([[2.5, 1.0]] * 20, q0=q0, dt=0.1)
        steps = np.abs(np.diff(np.vstack([q0, path.q]), axis=0))
        assert (steps <= 0.1 + EXACT).all()
        assert path.q[0, 0] == pytest.approx(0.9, abs=EXACT)
        assert (np.abs(path.q[5:]) <= 0.5 + EXACT).all()

    def test_a_floating_base_keeps_its_speed_too(self):
        """Velocity limits of free and ball joints are limits like any other."""
        robot = jtik.Robot(
            [
                jtik.Joint("ball", jtik.JointType.BALL, "base", "arm", velocity_limit=0.5),
                jtik.Joint("tip", jtik.JointType.FIXED, "arm", "tip", origin=_shift(1.0)),
            ]
        )
        path = solver(robot).track([[0.0, 1.0, 0.0]] * 3, dt=0.1)
        turned = robot.difference(robot.neutral, path.q[0])
        assert (np.abs(turned) <= 0.05 + EXACT).all()

    def test_refusals(self):
        ik = solver(planar(2))
        with pytest.raises(jtik.ArgumentError, match="targets.*at least one"):
            ik.track([])
        for dt in (0.0, -0.1, np.nan):
            with pytest.raises(jtik.ArgumentError, match="dt"):
                ik.track([[1.0, 1.0]], dt=dt)

    def test_a_wrong_target_on_the_way_leaves_the_limits_as_they_were(self):
        robot = jtik.Robot.planar(3, velocity_limit=0.1)
        ik = solver(robot)
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.track([[1.0, 1.0], [np.nan, 1.0]], q0=[0.3] * 3, dt=0.01)
        assert ik.solve([1.0, 1.0], q0=[0.3] * 3).converged

    def test_repr_sums_it_up(self):
        path = solver(planar(3)).track([[1.0, 1.0], [9.0, 0.0]], q0=[0.3] * 3)
        assert "1 of 2 targets reached" in repr(path)


def _shift(x):
    pose = np.eye(4)
    pose[0, 3] = x
    return pose


class TestManifolds:
    """Ball and free joints: nq is not n, and quaternions stay unit quaternions."""

    @pytest.mark.parametrize("name", ["ball", "floating"])
    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_pose_tasks_with_criteria(self, name, strategy, rng):
        robot = {"ball": ball_arm, "floating": floating_arm}[name]()
        criteria = JointCentering() + 0.1 * ObstacleAvoidance(jtik.Sphere((0.6, 0.6, 0.2), 0.1))
        ik = solver(robot, kind="pose", strategy=strategy, criteria=criteria)
        q0 = np.clip(robot.random_configuration(rng), robot.lower, robot.upper)
        moved = robot.integrate(q0, rng.uniform(-0.1, 0.1, robot.n))
        target = robot.pose(np.clip(moved, robot.lower, robot.upper))
        solution = ik.solve(
            target,
            q0=q0,
            trace=True,
            restarts=3,  # a limit may hold the first attempt
            max_iterations=3000,
            position_tolerance=1e-4,
            orientation_tolerance=1e-4,
            optimality_tolerance=1e-4,
        )
        assert robot.pose(solution.q) == pytest.approx(target, abs=3e-4)
        starts = [3] if name == "floating" else [0, 6]
        for start in starts:
            lengths = np.linalg.norm(solution.trace.q[:, start : start + 4], axis=1)
            assert lengths == pytest.approx(1.0, abs=EXACT)
        assert solution.gradient.shape == (robot.n,)
        assert solution.jacobian.shape == (6, robot.n)

    @pytest.mark.parametrize("name", ["ball", "floating"])
    def test_hybrid_converges_to_a_constrained_optimum(self, name, rng):
        robot = {"ball": ball_arm, "floating": floating_arm}[name]()
        ik = solver(robot, kind="pose", criteria=JointCentering())
        for _ in range(5):
            q0 = robot.random_configuration(rng)
            target = robot.pose(robot.integrate(q0, rng.uniform(-0.2, 0.2, robot.n)))
            solution = ik.solve(target, q0=q0)
            assert solution.position_error <= 1e-6
            assert solution.orientation_error <= 1e-6
            assert solution.status is jtik.Status.CONVERGED

    def test_a_quaternion_that_is_not_of_unit_length_is_read_as_a_direction(self):
        robot = ball_arm()
        q0 = robot.integrate(robot.neutral, np.full(robot.n, 0.1))
        long = q0.copy()
        long[:4] *= 3.0
        ik = solver(robot)
        target = robot.position(robot.integrate(q0, np.linspace(-0.3, 0.3, robot.n)))
        solution = ik.solve(target, q0=long)
        assert solution.converged
        assert np.linalg.norm(solution.q[:4]) == pytest.approx(1.0, abs=EXACT)
        assert robot.position(solution.q) == pytest.approx(target, abs=2e-6)


class Stubborn(jtik.Strategy):
    """A law that never takes its own step."""

    def update(self, model, state):
        term = model.rows.least_squares(model.here.residual).vector
        return Update(model.moved(term), 0, {}, term, term, 0 * term)


class TestStatuses:
    """Each says something else, and each can be met. LIMITS and SINGULAR have tests of their own."""

    def test_converged_and_reached(self):
        ik = solver(planar(4), criteria=JointCentering())
        assert ik.solve([2.0, 2.0], q0=[0.3] * 4).status is jtik.Status.CONVERGED
        assert ik.solve([2.0, 2.0], q0=[0.9, -0.3, 0.8, 0.1], until="reached").status is jtik.Status.REACHED

    def test_local_minimum(self):
        solution = solver(planar(2)).solve([3.0, 0.5], q0=[0.3, 0.4])
        assert solution.status is jtik.Status.LOCAL_MINIMUM
        assert solution.position_error == pytest.approx(np.hypot(3, 0.5) - 2, abs=1e-6)
        assert not solution.converged

    def test_stalled(self):
        q0 = np.array([0.3, 1.2])  # two joints and a near target: V is convex here, and nothing to escape from
        solution = solver(planar(2), strategy=Stubborn()).solve(planar_points(q0)[-1] + 0.05, q0=q0)
        assert solution.status is jtik.Status.STALLED
        assert solution.q.tolist() == q0.tolist()

    def test_iteration_limit(self):
        status = solver(planar(3)).solve([1.0, 1.5], q0=[0.3] * 3, max_iterations=1).status
        assert status is jtik.Status.ITERATION_LIMIT

    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_not_finite_where_the_criterion_is_not(self, strategy):
        @jtik.criterion
        def rooted(q, robot, *, edge=0.0):
            return (q[0] - edge) ** 1.5

        ik = solver(planar(3), criteria=rooted, strategy=strategy)
        q0 = [-0.5, 0.4, 0.3]
        for options in ({}, {"trace": True}):
            solution = ik.solve([1.0, 1.5], q0=q0, **options)
            assert solution.status is jtik.Status.NOT_FINITE
            assert solution.q.tolist() == q0
            assert not solution.converged
            assert "finite" in repr(solution)
        step = ik.step(q0, [1.0, 1.5])
        assert not step.accepted
        assert step.q.tolist() == q0

    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_a_step_into_where_it_is_not_finite_is_not_taken(self, strategy):
        @jtik.criterion
        def walled(q, robot):
            return -np.e * (0.5 - q[0]) ** 0.5 + q[1] ** 2

        ik = solver(planar(3), criteria=walled, strategy=strategy)
        solution = ik.solve([-1.0, 2.0], q0=[0.45, 0.4, 0.3], trace=True, max_iterations=200)
        assert np.isfinite(solution.q).all()
        assert np.isfinite(solution.trace.H).all()
        assert (solution.trace.q[:, 0] <= 0.5).all()

    def test_a_gradient_that_is_not_finite(self):
        @jtik.criterion
        def cusp(q, robot):
            return q[0] ** 0.5

        solution = solver(planar(3), criteria=cusp).solve([1.0, 1.5], q0=[0.0, 0.4, 0.3])
        assert solution.status is jtik.Status.NOT_FINITE

    def test_not_finite_on_the_target_is_no_success(self):
        @jtik.criterion
        def rooted(q, robot):
            return (q[0]) ** 1.5

        q0 = np.array([-0.5, 0.4, 0.3])
        for until in ("stationary", "reached"):
            solution = solver(planar(3), criteria=rooted).solve(planar_points(q0)[-1], q0=q0, until=until)
            assert solution.status is jtik.Status.NOT_FINITE

    def test_a_law_that_goes_astray_ends_with_the_last_good_configuration(self):
        class Astray(jtik.Strategy):
            def update(self, model, state):
                term = model.rows.least_squares(model.here.residual).vector
                return Update(model.moved(term * np.nan), 1, {}, term, term, 0 * term)

        solution = solver(planar(3), strategy=Astray()).solve([1.0, 1.5], q0=[0.3] * 3)
        assert solution.q.tolist() == [0.3] * 3
        assert not solution.converged

    def test_values_are_sentences(self):
        assert all(len(status.value.split()) > 3 for status in jtik.Status)


class TestCompiled:
    """The same step as generated C."""

    def test_agrees_with_the_virtual_machine(self, tmp_path, monkeypatch):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        options = {"criteria": JointCentering() + 0.3 * ObstacleAvoidance(FIELD[:1])}
        try:
            fast = solver(planar(4), compiled=True, **options)
        except CompilerError as error:
            pytest.skip(str(error))
        slow = solver(planar(4), **options)
        for target in ([2.0, 2.0], [3.0, -1.0], [5.0, 5.0]):
            one, other = (ik.solve(target, q0=[0.3, 0.2, 0.1, 0.4]) for ik in (fast, slow))
            assert one.status is other.status
            assert one.q == pytest.approx(other.q, abs=1e-6)  # the compiler may contract a * b + c

    def test_without_a_compiler_says_what_was_tried(self, tmp_path, monkeypatch):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        monkeypatch.setenv("CC", "/nowhere/to/be/found")
        with pytest.raises(jtik.JtikError, match="/nowhere/to/be/found"):
            solver(planar(2), compiled=True)
