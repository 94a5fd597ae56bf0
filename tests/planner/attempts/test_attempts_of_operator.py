"""Attempts in the loop: recorded, shown, undone, branched, solved again, saved, loaded and recovered."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.planner.edits.messages import AddObstacle, HoldTarget, Jog, MoveTarget, SetGain, SetObstacleGain, SetStrategy
from jtik.planner.edits.of_attempts import (
    Branch,
    Choose,
    DeleteAttempt,
    Live,
    LoadPlan,
    Pause,
    Play,
    Record,
    Recover,
    RenameAttempt,
    Resolve,
    SavePlan,
    Scrub,
    StopRecording,
    Undo,
)
from jtik.planner.files import sessions
from jtik.planner.files.journal import Journal
from jtik.planner.files.plan_file import Plan
from jtik.planner.session.loop import DT
from tests.planner.operator import ROBOT, START, Operator

GOAL = (2.4, 0.8)


def recorded(**options) -> Operator:
    """An operator who has recorded an attempt of one second, with a change of the scene."""
    operator = Operator(**options)
    operator.does(Record(), MoveTarget(GOAL), seconds=0.5)
    operator.does(SetObstacleGain("post", 0.5), seconds=0.5)
    return operator.does(StopRecording(), seconds=DT)


def test_an_attempt_is_what_the_arm_did() -> None:
    operator = Operator()
    frames = [operator.loop.frame]
    operator.loop.submit(Record())
    operator.loop.submit(MoveTarget(GOAL))
    for _ in range(30):
        operator.go()
        assert operator.loop.frame.recording
        frames.append(operator.loop.frame)
    operator.loop.submit(StopRecording())
    operator.go()
    (attempt,) = operator.loop.history
    assert attempt.name == "attempt 1"
    np.testing.assert_array_equal(attempt.configurations, [frame.q for frame in frames])
    np.testing.assert_array_equal(attempt.targets, [frame.position for frame in frames])
    np.testing.assert_allclose(np.diff(attempt.times), DT, rtol=1e-9)
    assert (attempt.strategy, attempt.criteria) == ("newton", ("joint_centering",))
    assert attempt.scene_at(0.2)["obstacles"]["post"]["gain"] == 1.0
    assert not operator.loop.frame.recording
    assert operator.told == []


def test_a_change_of_the_scene_is_part_of_the_attempt() -> None:
    attempt = recorded().loop.history["attempt 1"]
    assert attempt.scene_at(0.45)["obstacles"]["post"]["gain"] == 1.0
    assert attempt.scene_at(0.55)["obstacles"]["post"]["gain"] == 0.5


def test_an_attempt_is_played_paused_and_left() -> None:
    operator = recorded()
    attempt, q = operator.loop.history["attempt 1"], operator.loop.frame.q
    operator.does(Play("attempt 1"), seconds=0.5)
    frame = operator.loop.frame
    assert frame.mode == "playing"
    assert frame.shown[1] == pytest.approx(0.5)
    np.testing.assert_array_equal(frame.q, attempt.configurations[attempt.index(frame.shown[1])])
    assert operator.loop.status.words == "shows 'attempt 1'"
    operator.does(Pause(), seconds=1)
    assert operator.loop.frame.mode == "paused"
    assert operator.loop.frame.shown[1] == pytest.approx(0.5, abs=2 * DT)
    operator.does(Play("attempt 1", speed=2.0), seconds=0.2)
    assert operator.loop.frame.shown[1] == pytest.approx(0.9, abs=3 * DT)
    operator.go(1)
    assert operator.loop.frame.mode == "paused"
    np.testing.assert_array_equal(operator.loop.frame.q, attempt.configurations[-1])
    operator.does(Live(), seconds=DT)
    assert operator.loop.frame.mode == "live"
    np.testing.assert_allclose(operator.loop.frame.q, q, atol=0.05)  # the arm is where it was, and follows again
    operator.does(Play("attempt 1"), seconds=DT)
    assert operator.loop.frame.shown[1] == pytest.approx(DT)  # from its beginning again


def test_an_attempt_is_scrubbed_with_its_obstacles() -> None:
    operator = recorded()
    operator.does(Scrub("attempt 1", 0.2))
    assert operator.loop.frame.mode == "scrubbing"
    np.testing.assert_array_equal(operator.loop.frame.q, operator.loop.history["attempt 1"].configurations[12])
    assert operator.loop.settings.scene["post"]["gain"] == 1.0
    operator.does(Scrub("attempt 1", 99.0))
    assert operator.loop.frame.shown == ("attempt 1", pytest.approx(1.0))
    assert operator.loop.settings.scene["post"]["gain"] == 0.5


def test_an_arm_that_is_not_shown_is_not_guided() -> None:
    operator = recorded()
    operator.does(Scrub("attempt 1", 0.2), HoldTarget((0.0, 0.0)), Jog(0.0))
    assert operator.told == []
    operator.does(MoveTarget((1.0, 1.0)))
    assert "go back to the live arm" in operator.told[-1]
    assert operator.loop.frame.mode == "scrubbing"


def test_an_undo_puts_arm_target_and_obstacles_back() -> None:
    operator = recorded()
    attempt = operator.loop.history["attempt 1"]
    operator.loop.submit(Undo("attempt 1", 0.25))
    operator.go()
    assert operator.loop.frame.mode == "live"
    np.testing.assert_allclose(operator.loop.frame.q, attempt.configurations[15], atol=2 * DT)
    np.testing.assert_array_equal(operator.loop.frame.position, attempt.targets[15])
    assert operator.state.values.scene.gains["post"] == 1.0
    assert len(operator.loop.history) == 1


def test_a_branch_shares_its_beginning() -> None:
    operator = recorded()
    parent = operator.loop.history["attempt 1"]
    operator.does(Branch("attempt 1", 0.25, "other"), MoveTarget((1.5, 2.0)), seconds=0.5)
    assert operator.loop.frame.recording
    operator.does(StopRecording())
    branch = operator.loop.history["other"]
    assert (branch.parent, branch.branched_at) == ("attempt 1", pytest.approx(0.25))
    np.testing.assert_array_equal(branch.configurations[:16], parent.configurations[:16])
    assert branch.duration == pytest.approx(0.75, abs=2 * DT)
    assert np.abs(np.diff(branch.configurations, axis=0)).max() <= 2.0 * DT + 1e-9  # no jump at the branch
    assert operator.told == []


def test_recording_ends_when_an_attempt_is_shown() -> None:
    operator = recorded()
    operator.does(Record("second"), MoveTarget((1.5, 2.0)), seconds=0.3)
    operator.does(Scrub("attempt 1", 0.0))
    assert operator.loop.history.names == ("attempt 1", "second")
    assert not operator.loop.frame.recording


def test_attempts_are_chosen_renamed_and_deleted() -> None:
    operator = recorded()
    version = operator.loop.status.attempts
    operator.does(RenameAttempt("attempt 1", "low"), Choose("low"))
    assert operator.loop.history.chosen == "low"
    assert operator.loop.status.attempts > version
    operator.does(Scrub("low", 0.1), DeleteAttempt("low"))
    assert operator.loop.history.names == ()
    assert operator.loop.frame.mode == "live"


@pytest.mark.parametrize(
    "edit",
    [
        StopRecording(),
        Record("attempt 1"),
        Play("none"),
        Scrub("none", 0.0),
        Undo("none", 0.0),
        Undo("attempt 1", 5.0),
        Branch("attempt 1", 0.5, "attempt 1"),
        Choose("none"),
        DeleteAttempt("none"),
        RenameAttempt("none", "b"),
        Resolve("none"),
        Resolve("attempt 1", strategy="newtn"),
        Resolve("attempt 1", criteria=("none",)),
        LoadPlan("/no/such/file.json"),
        SavePlan("/no/such/folder/plan.json"),
        Recover("none"),
    ],
    ids=lambda edit: edit.kind,
)
def test_what_cannot_be_done_is_told_and_loses_nothing(edit) -> None:
    operator = recorded()
    operator.does(edit)
    assert len(operator.told) == 1
    assert operator.told[0].startswith(edit.kind)
    assert operator.loop.history.names == ("attempt 1",)
    assert operator.loop.frame.mode == "live"


def test_a_path_is_solved_again_with_another_strategy_and_criterion() -> None:
    operator = recorded()
    operator.does(Resolve("attempt 1", strategy="newton", criteria=(), name="plain"))
    first, again = operator.loop.history
    assert (again.name, again.parent, again.criteria, again.branched_at) == ("plain", "attempt 1", (), None)
    np.testing.assert_array_equal(again.targets, first.targets)
    reached = [ROBOT.position(q) for q in again.configurations]
    np.testing.assert_allclose(reached[30:], again.targets[30:], atol=0.05)
    # without a criterion a step has the smallest norm: no part of it is in the null space
    q, after = again.configurations[20:22]
    J = ROBOT.jacobian(q, rows="linear")
    dq = after - q
    assert np.linalg.norm(dq - np.linalg.pinv(J) @ (J @ dq)) < 1e-6
    assert operator.loop.settings.criteria == ("joint_centering",)


@pytest.mark.slow
def test_a_plan_is_saved_and_loaded(tmp_path: Path) -> None:
    operator = recorded()
    operator.does(SetGain("joint_centering.weight", 0.5), SetStrategy("hybrid", {"q_limit": 0.4}))
    operator.does(AddObstacle("box", {"shape": "box", "center": [3, 3], "half": [0.1, 0.2]}))
    operator.does(Choose("attempt 1"), SavePlan(str(tmp_path / "plan.json")))
    other = Operator()
    other.does(LoadPlan(str(tmp_path / "plan.json")), seconds=0.5)
    assert other.loop.history.to_json() == operator.loop.history.to_json()
    assert other.loop.history.chosen == "attempt 1"
    ours, theirs = operator.loop.settings.to_json(), other.loop.settings.to_json()
    for key in set(ours) - {"version", "capacity"}:
        assert theirs[key] == ours[key], key
    assert other.state.solver.ik.parameters["joint_centering.weight"] == 0.5


def test_a_file_that_is_no_plan_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text('{"format": "other"}')
    operator = recorded().does(LoadPlan(str(tmp_path / "plan.json")))
    assert operator.told[0].startswith("load_plan")
    assert operator.loop.history.names == ("attempt 1",)
    strange = Operator()
    plan = Plan(robot=Plan.robot_of(ROBOT), settings={"strategy": {"name": "no such"}})
    plan.save(tmp_path / "strange.json")
    strange.does(LoadPlan(str(tmp_path / "strange.json")))
    assert "no such" in strange.told[0]
    Plan(robot=Plan.robot_of(jtik.Robot.planar(3))).save(tmp_path / "three.json")
    strange.does(LoadPlan(str(tmp_path / "three.json")))
    assert "joint" in strange.told[1]
    assert strange.loop.settings.strategy["name"] == "newton"


def journaled(folder: Path) -> tuple[Operator, Journal]:
    journal = Journal(sessions.new_folder(folder), robot=Plan.robot_of(ROBOT))
    return Operator(journal=journal), journal


def test_what_a_killed_session_recorded_is_recovered(tmp_path: Path) -> None:
    operator, journal = journaled(tmp_path)
    operator.does(Record(), MoveTarget(GOAL), seconds=0.5)
    operator.does(StopRecording(), seconds=DT)
    operator.does(Record("unfinished"), MoveTarget((1.5, 2.0)), seconds=0.5)
    journal.write()  # what its thread does every second
    q = operator.loop.frame.q
    journal.close()  # as at the end of the process: the file is let go, and nothing says that the session ended
    former = sessions.recoverable(tmp_path)
    assert [session.closed for session in former] == [False]
    other = Operator(sessions=former)
    other.does(Recover(former[0].folder.name))
    assert other.loop.history.names == ("attempt 1", "unfinished")
    np.testing.assert_array_equal(other.loop.history["unfinished"].configurations[-1], q)
    assert "is recovered" in other.told[-1]


def test_a_session_that_is_closed_keeps_its_recording(tmp_path: Path) -> None:
    operator, _ = journaled(tmp_path)
    operator.does(Record(), MoveTarget(GOAL), seconds=0.5)
    operator.loop.close()
    (session,) = sessions.recoverable(tmp_path)
    assert session.closed
    other = Operator(sessions=(session,)).does(Recover(session.folder.name))
    assert other.loop.history.names == ("attempt 1",)
    np.testing.assert_array_equal(other.loop.history["attempt 1"].configurations[0], START)


def test_settings_are_kept_without_a_recording(tmp_path: Path) -> None:
    operator, journal = journaled(tmp_path)
    operator.does(AddObstacle("disc", {"shape": "circle", "center": [1, 3], "radius": 0.1}), seconds=3)
    journal.write()
    journal.close()
    (session,) = sessions.recoverable(tmp_path)
    other = Operator(sessions=(session,)).does(Recover(session.folder.name))
    assert set(other.loop.settings.scene) == {"post", "disc"}
