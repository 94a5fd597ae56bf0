"""The status of a solve: each status occurs.

Its tests are thinned: ``--full`` runs all of them.
"""

from __future__ import annotations

from dataclasses import replace

import casadi
import numpy as np
import pytest

import jtik
from jtik.strategy import Update
from jtik_formulations import JointCentering

from ..conftest import planar, planar_points
from .conftest import EVERY_STRATEGY, solver

pytestmark = pytest.mark.thinned(together=True, times=2)


class Stubborn(jtik.Strategy):
    """A strategy that never accepts its own step."""

    def update(self, model, state):
        return Update(model.row_space.least_squares(-model.here.residual).vector, accepted=0)


class TestStatuses:
    """Each status occurs. LIMITS and SINGULAR have tests of their own."""

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

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
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

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_a_step_into_where_it_is_not_finite_is_not_taken(self, strategy):
        @jtik.criterion
        def walled(q, robot):
            return -np.e * (0.5 - q[0]) ** 0.5 + q[1] ** 2

        ik = solver(planar(3), criteria=walled, strategy=strategy)
        solution = ik.solve([-1.0, 2.0], q0=[0.45, 0.4, 0.3], trace=True, max_iterations=200)
        assert np.isfinite(solution.q).all()
        assert np.isfinite(solution.trace.H).all()
        assert (solution.trace.q[:, 0] <= 0.5).all()

    @pytest.mark.quick(2)
    @pytest.mark.parametrize("strategy", [*EVERY_STRATEGY, "hybrid+qp", "newton+second_order"])
    def test_where_only_the_slope_is_not_finite_the_task_goes_on(self, strategy):
        """norm(q) has no slope at zero, and the straight arm starts there."""

        @jtik.criterion
        def size(q, robot):
            return casadi.norm_2(q)

        ik, q0 = solver(planar(4), criteria=size, strategy=strategy), [0.0] * 4
        solution = ik.solve([2.0, 1.5], q0=q0)
        assert solution.position_error < 1e-4
        assert solution.status is jtik.Status.CONVERGED or strategy == "weighted_qp"  # a soft compromise
        assert ik.step(q0, [2.0, 1.5]).accepted
        there = ik.solve([4.0, 0.0], q0=q0)  # the criterion is all that is left
        assert there.status is jtik.Status.NOT_FINITE
        assert (there.iterations, there.q.tolist()) == (0, q0)
        assert ik.solve([4.0, 0.0], q0=q0, until="reached").status is jtik.Status.NOT_FINITE

    def test_at_the_closest_posture_the_slope_counts(self):
        @jtik.criterion
        def cusp(q, robot):
            return casadi.fabs(q[0]) ** 0.5

        solution = solver(planar(1), criteria=cusp).solve([2.0, 0.0], q0=[0.0])
        assert solution.status is jtik.Status.NOT_FINITE

    def test_not_finite_on_the_target_is_no_success(self):
        @jtik.criterion
        def rooted(q, robot):
            return (q[0]) ** 1.5

        q0 = np.array([-0.5, 0.4, 0.3])
        for until in ("stationary", "reached"):
            solution = solver(planar(3), criteria=rooted).solve(planar_points(q0)[-1], q0=q0, until=until)
            assert solution.status is jtik.Status.NOT_FINITE

    def test_a_strategy_that_diverges_ends_with_the_last_finite_configuration(self):
        class Astray(jtik.Strategy):
            def update(self, model, state):
                dq = model.row_space.least_squares(-model.here.residual).vector
                return Update(dq, candidate=replace(model.candidate(dq * np.nan), dq=dq))

        solution = solver(planar(3), strategy=Astray()).solve([1.0, 1.5], q0=[0.3] * 3)
        assert solution.q.tolist() == [0.3] * 3
        assert not solution.converged

    def test_values_are_sentences(self):
        assert all(len(status.value.split()) > 3 for status in jtik.Status)
