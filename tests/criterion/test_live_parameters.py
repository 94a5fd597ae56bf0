"""Nothing is compiled again when a parameter, a weight or a target changes."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from ..conftest import planar
from .shared import STRATEGIES, link_height, new_solver


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


Q0 = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
TARGET = np.array([3.5, 1.5])


def walk(ik):
    """Four steps: the first may be refused."""
    q = Q0
    for _ in range(4):
        q = ik.step(q, TARGET).q
    return q


@pytest.mark.quick(2, slow=5)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_nothing_is_compiled_when_a_parameter_a_weight_or_a_target_changes(strategy, monkeypatch):
    """Between steps, and between solves; the answers are those of solvers built with these values."""
    options = {"q0": Q0, "max_iterations": 60}
    ik = new_solver(planar(5), link_height, strategy)
    first_steps, first = walk(ik), ik.solve(TARGET, **options)
    ik.warm_up()  # what a solve needs at its end is built when the first one converges
    calls = count_compilations(monkeypatch)
    ik.parameters["link_height.height"] = -2.0
    ik.reset()
    steps, second = walk(ik), ik.solve(TARGET, **options)
    ik.parameters["link_height.weight"] = 0.2
    third = ik.solve(TARGET + 0.1, **options)
    assert calls == []
    fresh, light = (new_solver(planar(5), weight * link_height(height=-2.0), strategy) for weight in (1.0, 0.2))
    assert "bind" in calls  # the counter counts
    assert steps.tolist() == walk(fresh).tolist()
    assert second.q.tolist() == fresh.solve(TARGET, **options).q.tolist()
    assert third.q.tolist() == light.solve(TARGET + 0.1, **options).q.tolist()
    assert first_steps.tolist() != steps.tolist()
    assert first.q.tolist() != second.q.tolist()
