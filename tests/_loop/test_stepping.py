"""step: one update a call, with its own state."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import EXACT, dh_arm, families_first, planar, planar_points, shared_solver, slow
from .conftest import STRATEGIES, solver


class TestStep:
    @pytest.mark.quick(2)
    @pytest.mark.parametrize("strategy", families_first(STRATEGIES, large=False))
    def test_a_sequence_is_a_solve(self, strategy):
        self.check_sequence(strategy, JointCentering())

    @pytest.mark.parametrize("strategy", ["hybrid", *slow("weighted_qp", "sns_qp")])
    def test_a_sequence_without_a_criterion_is_a_solve(self, strategy):
        self.check_sequence(strategy, None)

    def check_sequence(self, strategy, criteria):
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

    def test_it_converges_then_is_done_and_stays(self):
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

    def test_errors_are_those_after_the_step(self):
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


@pytest.mark.parametrize("wrong", [np.inf, -np.inf, np.nan])
def test_a_wrong_q_of_a_step_that_brakes_is_told_by_an_error_alone(wrong):
    ik = shared_solver(planar(3), jtik.FrameTask("tip"), limits=jtik.Limits(acceleration=10.0))
    q = np.full(3, 0.2)
    expected = ik.step(q, [1.0, 1.0], dt=0.01).q
    ik.reset()
    with pytest.raises(jtik.ArgumentError, match="q"):
        ik.step(np.full(3, wrong), [1.0, 1.0], dt=0.01)
    assert ik.step(q, [1.0, 1.0], dt=0.01).q.tolist() == expected.tolist()


def test_a_step_that_stagnates_does_not_forget_what_damps_it():
    """Two levels that conflict: every 20 steps without progress the state began anew, and the arm twitched."""
    arm = dh_arm(6, seed=1, limit=2.0)
    tasks = [
        jtik.FrameTask("tip", kind="position", name="first", priority=0),
        jtik.FrameTask(arm.frame_names[4], kind="position", name="second", priority=1),
    ]
    limits = jtik.Limits(velocity=1.0, acceleration=[15.0, np.inf, 5.0, 8.0, np.inf, 30.0])
    ik = shared_solver(arm, tasks, strategy="hybrid", limits=limits)
    q0 = np.random.default_rng(5).uniform(-2, 2, (3, 6))[2]
    target = {"first": arm.position(q0, "tip"), "second": arm.position(q0 + 0.3, arm.frame_names[4])}
    q = arm.home
    for _ in range(2000):
        q = ik.step(q, target, dt=0.01).q
    for _ in range(60):
        before, q = q, ik.step(q, target, dt=0.01).q
        assert np.abs(q - before).max() < 1e-5
