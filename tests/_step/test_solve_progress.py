"""Progress of a solve: what counts as progress, and after how much without any a solve ends."""

from __future__ import annotations

import math
from types import SimpleNamespace

import casadi
import numpy as np
import pytest

from jtik._step.solve_progress import (
    CYCLING,
    FALL,
    FREE_FALL,
    REFUSALS,
    STAGNANT,
    STAGNATIONS,
    STEEP,
    STUCK,
    UNKNOWN,
    Progress,
    initial_progress,
)
from jtik._step.stopping import Code

from .conftest import numbers


def run(
    steps,
    *,
    evaluated=True,
    patience=math.inf,
    reached=0,
    stationary=0,
    flat=1,
    progress=None,
    clearance=None,
    H=None,
    near=0,
    timed=False,
    limits_task=0,
):
    """States and codes of successive steps, each given as (V before, V after, accepted); H is (before, after)."""
    state = initial_progress(evaluated=evaluated) | {"patience": np.full(1, patience)}
    stop = SimpleNamespace(reached_before=reached, stationary=stationary, flat=flat)
    found = []
    for V, after, accepted in steps:
        here, candidate = (SimpleNamespace(V=casadi.SX(v), H=h) for v, h in zip((V, after), H or (0, 0), strict=True))
        here.V_to_target, here.decrease = here.V, lambda there, V=V: V - there.V
        model = SimpleNamespace(
            here=here, clearance=clearance, has_criterion=H is not None, near_target=near, timed=timed
        )
        update = SimpleNamespace(candidate=candidate, progress=progress)
        columns = {name: casadi.SX(value) for name, value in state.items()}
        at = Progress.of(model, columns, stop, SimpleNamespace(limits_task=limits_task))
        next_state, stalled = at.after(model, columns, update, accepted, stop, None, evaluated=evaluated)
        assert set(next_state) == set(state)
        state = {name: np.atleast_1d(numbers(value)) for name, value in next_state.items()}
        found.append((state, Code(int(numbers(at.code(0, stalled))))))
    return found


def codes(*arguments, **options):
    return [code for _, code in run(*arguments, **options)]


def test_the_first_state_has_seen_no_V_and_has_endless_patience():
    first = initial_progress(evaluated=True)
    assert {name: value.item() for name, value in first.items()} == {
        "refused": 0,
        "stagnant": 0,
        "without_progress": 0,
        "best": UNKNOWN,
        "patience": math.inf,
    }
    assert set(initial_progress(evaluated=False)) == {*first, "V"}


class TestPatience:
    def test_an_error_below_a_share_of_the_smallest_so_far_is_progress(self):
        """V is half the squared error."""
        falls, keeps = (FALL - 1e-9) ** 2, (FALL + 1e-9) ** 2
        states = [state for state, _ in run([(1.0, 1, 1), (keeps, 1, 1), (falls, 1, 1), (2.0, 1, 1)])]
        assert [state["without_progress"].item() for state in states] == [0, 1, 0, 1]
        assert [state["best"].item() for state in states] == [1, 1, falls, falls]

    @pytest.mark.parametrize("patience", [3, STUCK - 1])
    def test_of_an_attempt_that_a_restart_replaces_a_slower_fall_is_progress_while_no_limit_is_active(self, patience):
        for share, options in ((FREE_FALL, {}), (FALL, {"limits_task": 1}), (FALL, {"timed": True})):
            falls, keeps = (share - 1e-9) ** 2, (share + 1e-9) ** 2
            steps = [(1.0, 1, 1), (keeps, 1, 1), (falls, 1, 1)]
            states = [state for state, _ in run(steps, patience=patience, **options)]
            assert [state["without_progress"].item() for state in states] == [0, 1, 0]

    def test_where_exploring_is_to_begin_it_is_none(self):
        slowly = [(1.0, 1, 1), ((FREE_FALL - 1e-9) ** 2, 1, 1)]
        assert run(slowly, patience=STUCK)[-1][0]["without_progress"].item() == 1

    def test_a_solve_is_slow_after_so_many_calls_without_progress(self):
        steps = [(1.0, 0.9, 1)] * 5
        assert codes(steps, patience=3) == [Code.CONTINUE] * 3 + [Code.SLOW] * 2

    def test_on_the_target_it_is_not(self):
        assert codes([(1.0, 0.9, 1)] * 5, patience=3, reached=1) == [Code.CONTINUE] * 5


class TestStalled:
    def test_by_refusals_in_a_row(self):
        found = codes([(1.0, 1.0, 0)] * REFUSALS)
        assert found == [Code.CONTINUE] * (REFUSALS - 1) + [Code.STALLED]
        between = [(1.0, 1.0, 0)] * (REFUSALS - 1) + [(1.0, 0.9, 1)] + [(1.0, 1.0, 0)] * (REFUSALS - 1)
        assert set(codes(between)) == {Code.CONTINUE}

    @pytest.mark.parametrize(("fall", "stalls"), [(0.5 * STAGNANT, True), (2 * STAGNANT, False)])
    def test_by_steps_that_lower_V_too_little(self, fall, stalls):
        found = codes([(1.0, 1.0 - fall, 1)] * STAGNATIONS)
        assert found[:-1] == [Code.CONTINUE] * (STAGNATIONS - 1)
        assert (found[-1] is Code.STALLED) is stalls

    @pytest.mark.parametrize(("fall", "stalls"), [(0.5 * STEEP * STAGNANT, True), (0.5 * STAGNANT, False)])
    def test_where_the_task_is_not_stationary_slow_steps_go_on(self, fall, stalls):
        V = 1 / STEEP  # so that the difference is no rounding
        found = codes([(V, V - V * fall, 1)] * STAGNATIONS, flat=0)
        assert (found[-1] is Code.STALLED) is stalls

    def test_by_the_progress_that_a_strategy_reports_instead(self):
        assert codes([(1.0, 0.5, 1)] * STAGNATIONS, progress=0.0)[-1] is Code.STALLED
        assert codes([(1.0, 1.0, 1)] * STAGNATIONS, progress=0.1)[-1] is Code.CONTINUE

    @pytest.mark.parametrize("near", [0, 1])
    @pytest.mark.parametrize("progress", [None, 0.0])
    @pytest.mark.parametrize(("fall", "lowers"), [(0.5 * STAGNANT, False), (2 * STAGNANT, True)])
    def test_near_the_target_a_step_that_lowers_the_criterion_is_progress(self, near, progress, fall, lowers):
        """A long motion in the null space raises the error again and again, within the neighbourhood of the target."""
        found = codes([(1.0, 1.1, 1)] * STAGNATIONS, H=(-3.0, -3.0 * (1 + fall)), near=near, progress=progress)
        assert (found[-1] is Code.STALLED) == (not (near and lowers))

    def test_on_the_target_steps_may_lower_the_criterion_only(self):
        assert set(codes([(1.0, 1.0, 1)] * (STAGNATIONS + 1), reached=1)) == {Code.CONTINUE}

    def test_at_a_stationary_task(self):
        assert codes([(1.0, 0.5, 1)], stationary=1) == [Code.STALLED]

    def test_without_the_error_at_the_end_V_of_the_step_before_is_compared(self):
        falls = [(0.5**k, math.nan, 1) for k in range(STAGNATIONS + 2)]
        assert set(codes(falls, evaluated=False)) == {Code.CONTINUE}
        assert codes([(1.0, math.nan, 1)] * (STAGNATIONS + 1), evaluated=False)[-2:] == [Code.CONTINUE, Code.STALLED]

    @pytest.mark.quick(1)
    @pytest.mark.parametrize("options", [{"evaluated": False}, {"clearance": "some"}], ids=["every step", "clearances"])
    def test_by_cycling(self, options):
        """V alternates: no step stagnates, and none is progress."""
        steps = [(1.0 + k % 2, 2.0 - k % 2, 1) for k in range(CYCLING + STAGNATIONS + 2)]
        found = codes(steps, **options)
        assert set(found[: CYCLING + 1]) == {Code.CONTINUE}
        assert found[-1] is Code.STALLED


def test_an_end_takes_precedence_over_a_stall_and_a_stall_over_slowness():
    at = Progress(falls=0, without_progress=9, slow=1)
    assert [numbers(at.code(done, stalled)) for done, stalled in ((1, 1), (0, 1), (0, 0))] == [
        Code.DONE,
        Code.STALLED,
        Code.SLOW,
    ]


def test_a_compromise_takes_precedence_over_slowness():
    at = Progress(falls=0, without_progress=9, slow=1)
    ends = ((1, 0, 1), (0, 1, 1), (0, 0, 1), (0, 0, 0))
    assert [numbers(at.code(*end)) for end in ends] == [Code.DONE, Code.STALLED, Code.COMPROMISE, Code.SLOW]
