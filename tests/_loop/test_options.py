"""Options of a solve: until, max_iterations, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering

from ..conftest import EXACT, planar, planar_points
from .conftest import solver


class TestUntil:
    def test_reached_stops_on_arrival_and_stationary_continues(self):
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
    def test_zero_iterations_evaluate_the_start(self):
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
        with pytest.raises(jtik.ArgumentError, match="max_iterations.*non-negative integer"):
            solver(planar(2)).solve([1.0, 1.0], max_iterations=limit)


class TestNullSpaceRate:
    @pytest.mark.parametrize("rate", [0, -1.0, np.nan, -np.inf, True, None, "x", 1j, [5.0], np.array([5.0])])
    def test_a_rate_is_a_positive_number(self, rate):
        with pytest.raises(jtik.ArgumentError) as caught:
            solver(planar(2), null_space_rate=rate)
        assert caught.value.argument == "null_space_rate"
        assert caught.value.given is rate
        assert "positive rate [1/s]" in str(caught.value)

    @pytest.mark.parametrize("rate", [1, np.float32(2.5), np.int64(3), np.array(5.0), np.inf])
    def test_any_positive_number_is_one(self, rate):
        solver(planar(2), null_space_rate=rate)


class TestOldNames:
    @pytest.mark.parametrize(
        "call",
        [
            lambda ik, until: ik.solve([1.0, 1.5], until=until),
            lambda ik, until: ik.solve_batch([[1.0, 1.5]], until=until),
            lambda ik, until: ik.track([[1.0, 1.5]], until=until),
        ],
    )
    def test_the_former_value_steady_warns_and_is_stationary(self, call):
        criteria = JointCentering()
        with pytest.warns(DeprecationWarning, match='until="steady" is deprecated: use until="stationary"') as caught:
            old = call(solver(planar(3), criteria=criteria), "steady")
        assert [one.filename for one in caught] == [__file__]  # the warning points to the caller's line
        assert old.q.tolist() == call(solver(planar(3), criteria=criteria), "stationary").q.tolist()
