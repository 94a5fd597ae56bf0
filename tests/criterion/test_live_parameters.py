"""Nothing is compiled again when a parameter, a weight or a target changes."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ..conftest import planar
from .shared import STRATEGIES, link_height, solver


def count_compilations(monkeypatch):
    """Every call of what makes a casadi function, or binds one, wherever it has been imported."""
    import jtik.symbolic
    import jtik.symbolic.compile

    calls = []
    for original in (jtik.symbolic.function, jtik.symbolic.compile.bind):

        def counted(*arguments, _original=original, **options):
            calls.append(_original.__name__)
            return _original(*arguments, **options)

        for name, module in list(sys.modules.items()):
            if name.split(".")[0] in ("jtik", "jtik_formulations"):
                for attribute, value in list(vars(module).items()):
                    if value is original:
                        monkeypatch.setattr(module, attribute, counted)
    return calls


@pytest.mark.parametrize("strategy", STRATEGIES)
class TestNothingRecompiles:
    Q0 = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
    TARGET = np.array([3.5, 1.5])

    def walk(self, ik):
        """Four steps: the first may be refused."""
        q = self.Q0
        for _ in range(4):
            q = ik.step(q, self.TARGET).q
        return q

    def test_when_a_parameter_changes_between_steps(self, strategy, monkeypatch):
        ik = solver(planar(5), link_height, strategy)
        first = self.walk(ik)
        calls = count_compilations(monkeypatch)
        ik.parameters["link_height.height"] = -2.0
        ik.reset()
        second = self.walk(ik)
        assert calls == []
        fresh = solver(planar(5), link_height(height=-2.0), strategy)
        assert "bind" in calls  # the counter counts
        assert second.tolist() == self.walk(fresh).tolist()
        assert first.tolist() != second.tolist()

    def test_when_a_parameter_a_weight_or_a_target_changes_between_solves(self, strategy, monkeypatch):
        options = {"q0": self.Q0, "max_iterations": 60}
        ik = solver(planar(5), link_height, strategy)
        first = ik.solve(self.TARGET, **options)
        ik.warm_up()  # what a solve needs at its end is built when the first one converges
        calls = count_compilations(monkeypatch)
        ik.parameters["link_height.height"] = -2.0
        second = ik.solve(self.TARGET, **options)
        ik.parameters["link_height.weight"] = 0.2
        third = ik.solve(self.TARGET + 0.1, **options)
        assert calls == []
        fresh = [
            solver(planar(5), weight * link_height(height=-2.0), strategy).solve(target, **options)
            for weight, target in ((1.0, self.TARGET), (0.2, self.TARGET + 0.1))
        ]
        assert [second.q.tolist(), third.q.tolist()] == [solution.q.tolist() for solution in fresh]
        assert first.q.tolist() != second.q.tolist()
