"""The file of a plan: exact round trips, and the refusal of a stranger's files by file and key."""

from __future__ import annotations

import json
import os

import numpy as np
import pytest

import jtik
from jtik.errors import ArgumentError
from jtik.planner.attempts.history import History
from jtik.planner.files import plan_file
from jtik.planner.files.plan_file import Plan

from ..conftest import SCENE, make_attempt, same


def a_plan(arm) -> Plan:
    history = History().add(make_attempt(k=450, scenes=[(0.0, SCENE), (0.1, {})]))
    history = history.add(history.branch("attempt 1", 0.2)).choose("attempt 1.1")
    settings = {"strategy": "hybrid", "gains": {"joint_centering.gain": 0.1 + 0.2}, "preferred": [0.1, -0.2, 1e-300]}
    return Plan(robot=Plan.robot_of(arm), scene=SCENE, settings=settings, history=history)


def test_a_plan_is_read_back_to_the_last_bit(arm, tmp_path):
    plan = a_plan(arm)
    plan.save(tmp_path / "plan.json")
    again = Plan.load(tmp_path / "plan.json", arm)
    assert again.history.names == plan.history.names
    assert again.history.chosen == "attempt 1.1"
    assert all(map(same, again.history, plan.history))
    assert (again.scene, again.settings, again.robot) == (plan.scene, plan.settings, plan.robot)
    first = np.array(json.loads((tmp_path / "plan.json").read_text())["attempts"][0]["configurations"])
    assert first.tobytes() == plan.history["attempt 1"].configurations.tobytes()


def test_the_pieces_are_the_document_and_none_is_long(arm):
    plan = a_plan(arm)
    pieces = list(plan.pieces(journal=3))
    document = json.loads("".join(pieces))
    assert document["attempts"] == plan.history.to_json()["attempts"]
    assert document["journal"] == 3
    assert max(map(len, pieces)) < 80 * plan_file.ROWS


def test_a_plan_of_another_robot_is_refused(arm, tmp_path):
    a_plan(arm).save(tmp_path / "plan.json")
    with pytest.raises(ArgumentError, match="a plan of 'planar4'|a plan of"):
        Plan.load(tmp_path / "plan.json", jtik.Robot.planar(4))
    with pytest.raises(ArgumentError, match="history"):
        Plan(robot=Plan.robot_of(jtik.Robot.planar(4)), history=History().add(make_attempt(nq=3)))


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"\xff\xfe",
        b"[1, 2]",
        b"{}",
        b'{"format": "jtik study"}',
        b"[" * 200_000,
        b'{"format": "jtik plan", "version": NaN}',
        b'{"format": "jtik plan", "version": ' + b"9" * 10_000 + b"}",
        b'{"format": "jtik plan", "version": 2}',
        b"PK\x03\x04",
    ],
)
def test_a_file_that_is_no_plan_is_refused(tmp_path, text):
    path = tmp_path / "plan.json"
    path.write_bytes(text)
    with pytest.raises(ArgumentError, match="plan.json"):
        Plan.load(path)


@pytest.mark.parametrize(
    ("damage", "argument"),
    [
        (lambda data: data.pop("settings"), "plan.json"),
        (lambda data: data.update(scene=3), "plan.json: scene"),
        (lambda data: data["scene"]["obstacles"]["post"].update(shape="cone"), "plan.json: scene.obstacles.post.shape"),
        (
            lambda data: data["attempts"][0]["scenes"][0][1]["obstacles"]["post"].pop("radius"),
            "plan.json: attempts[0].scenes[0][1].obstacles.post.radius",
        ),
        (lambda data: data.update(settings=[]), "plan.json: settings"),
        (lambda data: data.update(robot={}), "plan.json: robot"),
        (lambda data: data["robot"].update(nq=-1), "plan.json: robot.nq"),
        (lambda data: data["robot"].update(nq=4), "plan.json: attempts"),
        (lambda data: data["robot"].update(joint_names="abc" * 99, nq=3), "plan.json: robot.joint_names"),
        (lambda data: data.update(attempts=None), "plan.json: attempts"),
        (lambda data: data["attempts"][1].update(targets=[[1]]), "plan.json: attempts[1].targets"),
        (lambda data: data["attempts"][1].update(times=[1e400]), "path"),
        (lambda data: data.update(chosen="x"), "plan.json: chosen"),
        (lambda data: data.update(journal="x"), "plan.json: journal"),
    ],
)
def test_a_damaged_plan_is_refused_by_file_and_key(arm, tmp_path, damage, argument):
    path = tmp_path / "plan.json"
    a_plan(arm).save(path)
    data = json.loads(path.read_text())
    damage(data)
    path.write_text(json.dumps(data))
    with pytest.raises(ArgumentError) as error:
        Plan.load(path)
    assert error.value.argument == argument


def test_what_is_no_regular_file_or_too_large_is_refused(tmp_path, monkeypatch):
    with pytest.raises(ArgumentError, match="exists"):
        Plan.load(tmp_path)
    with pytest.raises(ArgumentError, match="exists"):
        Plan.load(tmp_path / "none.json")
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.json")
        with pytest.raises(ArgumentError, match="exists"):
            Plan.load(tmp_path / "pipe.json")
    monkeypatch.setattr(plan_file, "LARGEST", 10)
    (tmp_path / "plan.json").write_text(" " * 11)
    with pytest.raises(ArgumentError, match="at most 10 bytes"):
        Plan.load(tmp_path / "plan.json")
