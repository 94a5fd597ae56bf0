"""The tests that every accepted step passes, for all combinations of their conditions."""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace

import casadi
import numpy as np
import pytest

from jtik.strategy import Evaluation, acceptance

from .conftest import numbers

DQ = casadi.SX([0.1, 0.2])


def evaluation(V=1.0, H=2.0):
    return Evaluation(casadi.SX([0.0, 0.0]), casadi.SX([np.sqrt(2 * V)]), casadi.SX(H))


def model(*, criterion=False, keeps=None, restores=0):
    """What `final_verdict` reads of a local model; with a clearance if ``keeps`` is given."""
    return SimpleNamespace(
        stagnation_damping=0,
        timed=False,
        has_criterion=criterion,
        clearance=None if keeps is None else SimpleNamespace(keeps=lambda dq: keeps),
        restoration=SimpleNamespace(accepts=lambda dq, length: restores),
    )


def verdict(model, accepted, *, longer=0, dq=DQ, candidate=None, evaluated=True):
    found = acceptance.final_verdict(
        model, dq, candidate or evaluation(), accepted, null_longer=longer, evaluated=evaluated
    )
    return tuple(bool(numbers(part)) for part in found)


@pytest.mark.parametrize("accepted", [0, 1])
def test_without_criterion_and_clearance_the_merit_decides_and_the_task_is_shortened(accepted):
    assert verdict(model(), accepted, longer=1) == (bool(accepted), True, False)


@pytest.mark.parametrize("longer", [0, 1])
def test_with_a_criterion_the_longer_part_is_shortened(longer):
    assert verdict(model(criterion=True), 0, longer=longer) == (False, not longer, bool(longer))


@pytest.mark.parametrize("value", [np.nan, np.inf])
class TestNotFinite:
    def test_a_candidate_is_refused(self, value):
        assert not verdict(model(), 1, candidate=evaluation(H=value))[0]
        assert not verdict(model(), 1, candidate=evaluation(V=value))[0]

    def test_a_candidate_that_is_not_evaluated_is_not_looked_at(self, value):
        assert verdict(model(), 1, candidate=evaluation(H=value), evaluated=False)[0]

    def test_a_displacement_is_refused(self, value):
        assert not verdict(model(), 1, dq=casadi.SX([0.0, value]), evaluated=False)[0]


@pytest.mark.parametrize(("accepted", "keeps", "restores", "longer"), list(product([0, 1], repeat=4)))
def test_a_step_keeps_the_clearances_and_lowers_the_merit_or_restores_them(accepted, keeps, restores, longer):
    found = verdict(model(criterion=True, keeps=keeps, restores=restores), accepted, longer=longer)
    unsafe = not keeps  # the whole step is too long, so that both parts are shortened
    task = (not longer or unsafe) and not (restores and keeps)  # a restoration says nothing about the task part
    assert found == (bool((accepted or restores) and keeps), bool(task), bool(longer or unsafe))
