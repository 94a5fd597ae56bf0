"""The trace of a solve: every figure, once an iteration."""

from __future__ import annotations

import numpy as np
import pytest

from jtik_formulations import JointCentering

from ..conftest import EXACT, planar, planar_points
from .conftest import EVERY_STRATEGY, solver


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

    def test_there_is_none_by_default(self):
        assert solver(planar(2)).solve([1.0, 1.0], q0=[0.1, 0.2]).trace is None

    @pytest.mark.parametrize("strategy", EVERY_STRATEGY)
    def test_has_every_figure_it_promises_once_an_iteration(self, strategy):
        self.check_figures(strategy, JointCentering())

    def test_has_them_without_a_criterion_too(self):
        self.check_figures("hybrid", None)

    def check_figures(self, strategy, criteria):
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
