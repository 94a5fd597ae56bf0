"""The queue of edits and the schedule of the periods."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.planner.edits.messages import ChangeObstacle, DeleteObstacle, HoldTarget, MoveTarget, SetGain, TakePosture
from jtik.planner.session.inbox import Inbox
from jtik.planner.session.schedule import EARLY, PULL, Schedule


def test_edits_come_in_their_order() -> None:
    inbox = Inbox()
    edits = [TakePosture(), DeleteObstacle("a"), TakePosture()]
    assert all(inbox.put(edit) for edit in edits)
    assert inbox.take() == (edits, 0)
    assert inbox.take() == ([], 0)


def test_the_latest_target_wins() -> None:
    inbox = Inbox()
    for edit in (MoveTarget((1, 1)), TakePosture(), HoldTarget((1, 1)), MoveTarget((2, 2))):
        inbox.put(edit)
    assert inbox.take()[0] == [TakePosture(), MoveTarget((2, 2))]


def test_a_later_change_of_an_obstacle_replaces_an_earlier_one_and_no_other() -> None:
    inbox = Inbox()
    edits = [
        ChangeObstacle("a", {"x": 1}),
        ChangeObstacle("b", {"x": 1}),
        SetGain("g", 1),
        ChangeObstacle("a", {"x": 2}),
    ]
    for edit in edits:
        inbox.put(edit)
    assert inbox.take()[0] == edits[1:]


def test_a_full_queue_refuses_edits_but_no_target() -> None:
    inbox = Inbox(largest=3)
    assert [inbox.put(TakePosture()) for _ in range(5)] == [True, True, True, False, False]
    assert inbox.put(HoldTarget((0, 0)))
    edits, refused = inbox.take()
    assert len(edits) == 4
    assert refused == 2
    assert inbox.put(TakePosture())


def test_a_period_that_is_on_time_waits_for_the_next() -> None:
    schedule = Schedule(0.5, 10.0)
    assert schedule.wait(9.75) == 0.25
    schedule.done(10.25)
    assert schedule.wait(10.25) == 0.25
    assert schedule.late == 0


@pytest.mark.parametrize(("ended", "late", "wait"), [(10.75, 0, 0.0), (11.25, 1, 0.0), (13.75, 6, 0.0)])
def test_late_periods_are_left_out(ended: float, late: int, wait: float) -> None:
    schedule = Schedule(0.5, 10.0)
    schedule.done(ended)
    assert schedule.late == late
    assert schedule.wait(ended) == wait
    schedule.done(ended)  # the period that was due at once
    assert 0 < schedule.wait(ended) <= 0.5


def answered(edits: list[float], until: float) -> tuple[list[float], list[float]]:
    """When periods of 1 s begin while edits come at these times [s], and how long each edit waits."""
    schedule, now, begun, taken = Schedule(1.0, 0.0), 0.0, [], 0
    while now < until:
        due = now + schedule.wait(now)
        if taken < len(edits) and edits[taken] <= due:
            now = max(now, edits[taken])
            due = now + schedule.asked(now)
        now = due
        begun.append(now)
        taken = int(np.searchsorted(edits, now, side="right"))
        schedule.done(now)
    return begun, [begun[int(np.searchsorted(begun, at))] - at for at in edits if at < begun[-1]]


def test_without_edits_periods_begin_when_they_are_due() -> None:
    assert answered([], 50.0)[0] == list(range(51))


@pytest.mark.parametrize("phase", [0.03, 0.3, 0.5, 0.77, 0.97])
def test_edits_in_a_rhythm_are_answered_without_a_wait_after_some_periods(phase: float) -> None:
    _, waits = answered([k + phase for k in range(200)], 200.0)
    assert max(waits[20:]) < 1e-9


@pytest.mark.quick(1)
@pytest.mark.parametrize("spacing", [0.1, 0.37, 0.5, 0.73, 0.99, 1.0, 1.01, 1.9])
def test_edits_make_no_more_periods_and_none_long(spacing: float) -> None:
    generator = np.random.default_rng(0)
    for tremble in (0.0, 0.3):
        edits = sorted(k * spacing + tremble * generator.uniform() for k in range(int(300 / spacing)))
        begun, _ = answered(edits, 300.0)
        assert abs(len(begun) - 300) <= 2
        assert np.diff(begun).max() <= 1 + EARLY + PULL + 1e-9
        assert np.diff(begun).min() >= 1 - EARLY - PULL - 1e-9
