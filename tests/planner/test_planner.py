"""The public class: its defaults, its thread, and what it does with wrong arguments."""

from __future__ import annotations

import os
import threading
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.errors import ArgumentError, UnknownNameError
from jtik.planner import Planner
from jtik.planner.edits.messages import MoveTarget
from jtik.planner.edits.of_attempts import Record
from jtik.planner.files import sessions
from jtik.planner.session.loop import DT
from jtik_formulations import JointCentering, Newton, ObstacleAvoidance
from tests.planner.operator import Later

ARM = jtik.Robot.planar(3)


def made(robot=ARM, **options) -> Planner:
    values = {"folder": False, "criteria": "joint_centering", "strategy": "newton", "executor": Later()}
    return Planner(robot, **(values | options))


@pytest.mark.slow
def test_by_default_it_is_the_arm_of_the_paper_in_front_of_a_field() -> None:
    with Planner(folder=False, strategy="newton", criteria=()) as planner:
        setup, settings = planner.loop.setup, planner.loop.settings
        assert (setup.robot["nq"], setup.robot["dimension"]) == (10, 2)
        assert len(settings.scene) == 7
        assert planner.loop.status.words.startswith(("on target", "at rest"))
        assert setup.dt == pytest.approx(1 / 60)


@pytest.mark.slow
def test_a_spatial_robot_is_guided_in_its_pose_and_with_its_limits() -> None:
    planner = made(jtik.Robot.builtin("panda"))
    joints = planner.loop.setup.robot["joints"]
    assert planner.loop.setup.task["kind"] == "pose"
    assert all(joint["limited"] and np.isfinite([joint["lower"], joint["upper"]]).all() for joint in joints)
    assert planner.loop.settings.limits
    assert planner.loop.frame.position.shape == (3,)
    assert planner.loop.status.error < 1e-9


def test_joints_without_limits_have_ranges_for_sliders() -> None:
    for joint in made().loop.setup.robot["joints"]:
        assert not joint["limited"]
        assert (joint["lower"], joint["upper"]) == (-np.pi, np.pi)


def test_the_loop_runs_in_a_thread_of_its_own() -> None:
    arrived = threading.Event()
    with made(target_speed=(100.0, 1.0)) as planner:
        planner.loop.submit(MoveTarget((1.5, 1.5)))
        for _ in range(600):
            if np.linalg.norm(ARM.position(planner.loop.frame.q) - (1.5, 1.5)) < 1e-3:
                break
            arrived.wait(0.05)
        else:
            pytest.fail("the arm does not arrive")
    before = planner.loop.frame
    arrived.wait(0.1)
    assert planner.loop.frame is before
    assert not [thread for thread in threading.enumerate() if thread.name == "jtik planner"]


@pytest.mark.slow
def test_what_is_recorded_is_in_a_folder_from_the_first_second_on(tmp_path: Path) -> None:
    with made(folder=tmp_path) as planner:
        planner.loop.submit(Record())
        for _ in range(200):
            if sessions.recoverable(tmp_path) or any(tmp_path.iterdir()):
                break
            threading.Event().wait(0.05)
    (session,) = sessions.recoverable(tmp_path)
    assert session.closed
    assert made(folder=tmp_path).loop.sessions == ()  # nothing is left to be recovered


def test_criteria_and_strategy_may_be_objects() -> None:
    field = jtik.Scene({"disc": jtik.Circle((1.0, 1.0), 0.2)})
    criteria = 0.5 * JointCentering(2.0) + 0.1 * ObstacleAvoidance(field, bodies="links", capacity=2)
    planner = made(scene=field, criteria=criteria, strategy=Newton(q_limit=0.2))
    ik = planner.loop._state.solver.ik
    assert planner.loop.settings.strategy["name"] == "given"
    assert planner.loop.setup.strategies[0]["name"] == "given"
    assert ik.strategy.q_limit == 0.2
    assert ik.parameters["joint_centering.weight"] == 0.5
    np.testing.assert_array_equal(ik.parameters["obstacle_avoidance.gains"], [1.0, 0.0])


def test_setup_settings_and_status_are_plain_data() -> None:
    planner = made()
    for published in (planner.loop.setup, planner.loop.settings, planner.loop.status):
        assert _is_plain(published.to_json()), published


def _is_plain(value: object) -> bool:
    if isinstance(value, dict):
        return all(isinstance(key, str) and _is_plain(each) for key, each in value.items())
    if isinstance(value, list):
        return all(map(_is_plain, value))
    return value is None or type(value) in (bool, int, str) or (type(value) is float and np.isfinite(value))


@pytest.mark.parametrize(
    ("arguments", "argument"),
    [
        ({"robot": "panda"}, "robot"),
        ({"task": jtik.CenterOfMassTask()}, "task"),
        ({"scene": jtik.Sphere((0, 0, 0), 1)}, "scene"),
        ({"scene": 5}, "scene"),
        ({"strategy": 5}, "strategy"),
        ({"criteria": 5}, "criteria"),
        ({"criteria": ["joint_centering", "joint_centering"]}, "criteria"),
        ({"criteria": "look_at"}, "criteria"),
        ({"q0": [0.0]}, "q0"),
        ({"limits": 1}, "limits"),
        ({"safe": -1.0}, "safe"),
        ({"target_speed": (0.0, 1.0)}, "target_speed"),
        ({"dt": 0.0}, "dt"),
        ({"compiled": "yes"}, "compiled"),
        ({"folder": True}, "folder"),
        ({"folder": 5}, "folder"),
    ],
)
def test_a_wrong_argument_is_named(arguments: dict, argument: str) -> None:
    with pytest.raises(ArgumentError) as raised:
        made(**arguments)
    assert raised.value.argument == argument


@pytest.mark.parametrize(
    "arguments", [{"strategy": "newtn"}, {"criteria": "joint_centring"}, {"task": jtik.FrameTask("hand")}]
)
def test_an_unknown_name_is_named(arguments: dict) -> None:
    with pytest.raises(UnknownNameError):
        made(**arguments)


@pytest.mark.slow
def test_a_session_killed_before_anything_was_done_is_not_offered(tmp_path) -> None:
    now = [0.0]
    planner = made(folder=tmp_path, clock=lambda: now[0])
    journal = planner.loop._journal
    for _ in range(600):
        now[0] += DT
        planner.loop.tick(now[0])
    assert journal.write()
    os.close(journal._file)  # what the end of the process does
    assert sessions.recoverable(tmp_path) == ()
    planner.loop.submit(Record())
    planner.loop.tick(now[0] + DT)
    journal._file = os.open(journal.folder / "journal.jsonl", os.O_WRONLY | os.O_APPEND)
    assert journal.write()
    os.close(journal._file)
    assert [each.folder for each in sessions.recoverable(tmp_path)] == [journal.folder]
