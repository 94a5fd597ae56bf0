"""Edits: their JSON form, and what a wrong one says."""

from __future__ import annotations

import json

import pytest

from jtik.errors import ArgumentError, UnknownNameError
from jtik.planner.edits import of_attempts as edits_of_attempts
from jtik.planner.edits.messages import EDITS, HoldTarget, MoveTarget, SetGain, from_json

EXAMPLES = [
    {"edit": "move_target", "position": [6.0, 1.5], "orientation": [1.0, 0.0, 0.0, 0.0]},
    {"edit": "hold_target", "velocity": [0.0, 0.0, 0.1], "rotation": [0.0, 0.0, 1.0]},
    {"edit": "guide", "task": "left hand"},
    {"edit": "set_target_speed", "speed": 0.5, "rotation": None},
    {"edit": "add_obstacle", "name": "disc", "obstacle": {"shape": "circle"}, "gain": 0.5},
    {"edit": "change_obstacle", "name": "disc", "obstacle": {"shape": "circle"}},
    {"edit": "delete_obstacle", "name": "disc"},
    {"edit": "set_obstacle_gain", "name": "disc", "gain": 0.0},
    {"edit": "set_preferred", "joint": "joint1", "value": 0.5},
    {"edit": "take_posture"},
    {"edit": "set_joint_weights", "weights": {"joint1": 20.0, "joint2": 0.5}},
    {"edit": "set_gain", "parameter": "joint_centering.stiffness", "value": [1.0, 2.0]},
    {"edit": "set_strategy", "name": "hybrid+qp", "options": {"q_limit": None}},
    {"edit": "set_criteria", "names": ["joint_centering"]},
    {"edit": "set_limits", "on": False},
    {"edit": "set_clearance", "on": True, "safe": 0.02},
    {"edit": "jog", "rate": -0.5, "direction": "joint2"},
    {"edit": "record", "name": None},
    {"edit": "stop_recording", "keep": False},
    {"edit": "play", "attempt": "attempt 1", "speed": 2.0},
    {"edit": "pause"},
    {"edit": "live"},
    {"edit": "scrub", "attempt": "attempt 1", "time": 0.5},
    {"edit": "undo", "attempt": "attempt 1", "time": 0.5},
    {"edit": "branch", "attempt": "attempt 1", "time": 0.5, "name": "b"},
    {"edit": "choose", "attempt": None},
    {"edit": "delete_attempt", "attempt": "attempt 1"},
    {"edit": "rename_attempt", "attempt": "attempt 1", "name": "b"},
    {"edit": "resolve", "attempt": "a", "strategy": "newton", "options": {}, "criteria": [], "name": None},
    {"edit": "save_plan", "path": "plan.json"},
    {"edit": "load_plan", "path": "plan.json"},
    {"edit": "recover", "session": "2026"},
]


@pytest.mark.parametrize("data", EXAMPLES, ids=lambda data: data["edit"])
def test_an_edit_is_the_same_after_json(data: dict) -> None:
    edit = from_json(json.loads(json.dumps(data)))
    assert edit.to_json() == data
    assert from_json(edit.to_json()) == edit


def test_every_edit_is_among_the_examples() -> None:
    assert edits_of_attempts.Record.kind in EDITS
    assert {data["edit"] for data in EXAMPLES} == set(EDITS) - {"take_plan"}  # whose plan is an object


@pytest.mark.parametrize(
    ("data", "argument"),
    [
        (None, "edit"),
        ([], "edit"),
        ({}, "edit"),
        ({"edit": 5}, "edit"),
        ({"edit": "move_target"}, "position"),
        ({"edit": "move_target", "position": [1.0]}, "position"),
        ({"edit": "move_target", "position": [1.0, float("nan")]}, "position"),
        ({"edit": "move_target", "position": [1e300, 0.0]}, "position"),
        ({"edit": "move_target", "position": "12"}, "position"),
        ({"edit": "move_target", "position": [True, False]}, "position"),
        ({"edit": "move_target", "position": [1.0, 2.0], "orientation": [0, 0, 0, 0]}, "orientation"),
        ({"edit": "move_target", "position": [1.0, 2.0], "colour": "red"}, "colour"),
        ({"edit": "hold_target", "velocity": [1.0, 2.0], "rotation": [1.0]}, "rotation"),
        ({"edit": "set_target_speed", "speed": 0.0}, "speed"),
        ({"edit": "set_limits", "on": 1}, "on"),
        ({"edit": "set_preferred", "joint": "a", "value": None}, "value"),
        ({"edit": "set_preferred", "joint": "", "value": 1.0}, "joint"),
        ({"edit": "set_preferred", "joint": "a", "value": 1e7}, "value"),
        ({"edit": "set_gain", "parameter": "a.b", "value": {"a": 1}}, "value"),
        ({"edit": "set_criteria", "names": ["a", "a"]}, "names"),
        ({"edit": "set_strategy", "name": "newton", "options": [1]}, "options"),
        ({"edit": "add_obstacle", "name": "a\nb", "obstacle": {}}, "name"),
        ({"edit": "add_obstacle", "name": "a", "obstacle": 3}, "obstacle"),
        ({"edit": "jog", "rate": 1.0, "direction": -1}, "direction"),
        ({"edit": "scrub", "attempt": "a", "time": -1.0}, "time"),
        ({"edit": "play", "attempt": "a" * 101}, "attempt"),
    ],
)
def test_a_wrong_message_names_its_field(data: object, argument: str) -> None:
    with pytest.raises(ArgumentError) as raised:
        from_json(data)
    assert raised.value.argument == argument


def test_an_unknown_kind_lists_the_kinds() -> None:
    with pytest.raises(UnknownNameError, match="move_target"):
        from_json({"edit": "move_taget"})


def test_edits_are_values() -> None:
    assert MoveTarget([1, 2]) == MoveTarget((1.0, 2.0))
    assert hash(HoldTarget([1, 2])) == hash(HoldTarget((1.0, 2.0)))
    assert SetGain("a.b", [[1, 2]]).value == ((1.0, 2.0),)
    assert MoveTarget((0, 0, 0), (0, 0, 0, 2)).orientation == (0.0, 0.0, 0.0, 1.0)
