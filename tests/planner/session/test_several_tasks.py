"""Several tasks: the operator guides one, the others are held where their targets are."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.planner import Planner
from jtik.planner.edits.messages import Guide, MoveTarget
from jtik.planner.edits.of_attempts import Branch, Record, Resolve, StopRecording, Undo
from jtik.planner.session.loop import DT
from tests.planner.operator import Later

ROBOT = jtik.Robot.planar(7)
START = np.array([0.9, -0.5, -0.5, 0.4, 0.5, -0.6, -0.5])
TASKS = [jtik.FrameTask("tip"), jtik.FrameTask("link4", name="elbow")]
NEAR = 2e-4


class Session:
    """A planner whose clock is the test's."""

    def __init__(self, tasks=TASKS) -> None:
        self.now = 0.0
        self.planner = Planner(
            ROBOT, tasks, criteria=(), q0=START, folder=False, executor=Later(), clock=lambda: self.now
        )
        self.loop = self.planner.loop

    def does(self, *edits, seconds: float = 0.2) -> None:
        for edit in edits:
            self.loop.submit(edit)
        for _ in range(round(seconds / DT)):
            self.now += DT
            self.loop.tick(self.now)

    def at(self, frame: str) -> np.ndarray:
        return ROBOT.position(self.loop.frame.q, frame)

    @property
    def told(self) -> list[str]:
        return [message.text for message in self.loop.messages if message.level == "error"]


@pytest.mark.slow
def test_the_first_is_guided_and_the_other_is_held() -> None:
    session = Session()
    elbow, tip = session.at("link4"), session.at("tip")
    session.does(MoveTarget(tuple(tip + np.array([-0.4, 0.3]))), seconds=2)
    np.testing.assert_allclose(session.at("tip"), np.add(tip, [-0.4, 0.3]), atol=NEAR)
    np.testing.assert_allclose(session.at("link4"), elbow, atol=NEAR)
    tasks = session.loop.settings.tasks
    assert [task["name"] for task in tasks] == ["tip", "elbow"]
    assert tasks[0]["held"] is None
    np.testing.assert_allclose(tasks[1]["held"], elbow)
    assert session.told == []


@pytest.mark.slow
def test_another_one_is_guided_from_where_its_target_is() -> None:
    session = Session()
    elbow, tip = session.at("link4"), session.at("tip")
    session.does(MoveTarget(tuple(tip + np.array([-0.4, 0.3]))), seconds=2)
    session.does(Guide("elbow"))
    np.testing.assert_allclose(session.loop.frame.position, elbow)
    session.does(MoveTarget(tuple(elbow + np.array([0.1, -0.3]))), seconds=2)
    np.testing.assert_allclose(session.at("link4"), np.add(elbow, [0.1, -0.3]), atol=NEAR)
    np.testing.assert_allclose(session.at("tip"), np.add(tip, [-0.4, 0.3]), atol=NEAR)
    session.does(Guide("wrist"))
    assert "elbow" in session.told[0]
    assert [task["held"] is None for task in session.loop.settings.tasks] == [False, True]


@pytest.mark.slow
def test_attempts_keep_which_one_was_guided_and_where_the_others_were() -> None:
    session = Session()
    elbow, tip = session.at("link4"), session.at("tip")
    session.does(Guide("elbow"), Record())
    session.does(Guide("tip"))
    assert "while an attempt is recorded" in session.told[0]
    session.does(MoveTarget(tuple(elbow + np.array([0.1, -0.3]))), seconds=1)
    session.does(StopRecording(), Guide("tip"))
    session.does(MoveTarget(tuple(tip + np.array([-0.4, 0.3]))), seconds=1)
    session.does(Resolve("attempt 1", strategy="newton", name="again"))
    for name in ("attempt 1", "again"):
        attempt = session.loop.history[name]
        path = np.array([ROBOT.position(q, "link4") for q in attempt.configurations])
        np.testing.assert_allclose(path[-1], np.add(elbow, [0.1, -0.3]), atol=NEAR)
        np.testing.assert_allclose(ROBOT.position(attempt.configurations[-1], "tip"), tip, atol=NEAR)
    session.does(Undo("attempt 1", 0.0))
    assert [task["held"] is None for task in session.loop.settings.tasks] == [False, True]
    np.testing.assert_allclose(session.at("tip"), tip, atol=NEAR)
    session.does(Branch("again", 0.3))
    session.does(MoveTarget(tuple(elbow)), seconds=1)
    session.does(StopRecording())
    np.testing.assert_allclose(session.at("link4"), elbow, atol=NEAR)
    assert session.loop.history.names == ("attempt 1", "again", "again.1")


def test_an_orientation_counts_for_the_tasks_that_have_one() -> None:
    tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link5", kind="orientation", name="turn")]
    session = Session(tasks)
    tip, turned = session.at("tip"), ROBOT.pose(START, "link5")[0, 0]
    session.does(MoveTarget(tuple(tip + np.array([-0.5, 0.2]))), seconds=2)
    np.testing.assert_allclose(session.at("tip"), np.add(tip, [-0.5, 0.2]), atol=NEAR)
    assert ROBOT.pose(session.loop.frame.q, "link5")[0, 0] == pytest.approx(turned, abs=NEAR)
    session.does(Guide("turn"), Record())
    session.does(StopRecording())
    assert session.loop.history["attempt 1"].targets.shape[1] == 7


@pytest.mark.parametrize("wrong", [[], [jtik.FrameTask("tip"), 3], "tip", [jtik.FrameTask("tip")] * 2])
def test_tasks_that_cannot_be_used_are_refused(wrong) -> None:
    with pytest.raises(jtik.ArgumentError, match="task"):
        Session(wrong)
