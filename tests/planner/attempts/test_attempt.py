"""Attempts: exact round trips, cutting, and the refusal of what is no attempt."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jtik.errors import ArgumentError
from jtik.planner.attempts.attempt import Attempt

from ..conftest import SCENE, make_attempt

NUMBERS = st.floats(allow_nan=False, allow_infinity=False)


@given(st.lists(NUMBERS, min_size=3, max_size=3), st.floats(1e-300, 1e300), st.integers(1, 2**62))
def test_json_gives_the_same_attempt_to_the_last_bit(row, step, key):
    attempt = make_attempt(
        k=2,
        times=[0.0, step],
        configurations=[row, row],
        targets=[[0.0, -0.0], row[:2]],
        scenes=[(0.0, SCENE), (step, {"n": key})],
        settings={"x": row, "flag": False, "none": None},
    )
    again = Attempt.from_json(json.loads(json.dumps(attempt.to_json())))
    for name in ("times", "configurations", "targets"):
        assert getattr(attempt, name).tobytes() == getattr(again, name).tobytes()
    assert again.to_json() == attempt.to_json()
    assert again.scenes == attempt.scenes
    assert again.criteria == attempt.criteria == ("joint_centering",)


def test_an_attempt_keeps_copies_that_cannot_change():
    q, scene = np.zeros((2, 3)), {"post": {"radius": 1.0}}
    attempt = make_attempt(k=2, configurations=q, scenes=[(0.0, scene)])
    q[:] = 7.0
    scene["post"]["radius"] = 7.0
    attempt.scene_at(0.0)["post"]["radius"] = 7.0
    attempt.to_json()["scenes"][0][1]["post"]["radius"] = 7.0
    assert (attempt.configurations == 0).all()
    assert attempt.scene_at(0.0) == {"post": {"radius": 1.0}}
    with pytest.raises(ValueError, match="read-only"):
        attempt.configurations[0, 0] = 1.0
    with pytest.raises(AttributeError):
        attempt.name = "other"


def test_cut_keeps_the_samples_and_the_scenes_up_to_a_time():
    attempt = make_attempt(k=10, scenes=[(0.0, {"a": 1}), (3 / 60, {"a": 2}), (8 / 60, {"a": 3})])
    cut = attempt.cut(5.5 / 60)
    assert len(cut) == 6
    assert (cut.configurations == attempt.configurations[:6]).all()
    assert [scene for _, scene in cut.scenes] == [{"a": 1}, {"a": 2}]
    assert len(attempt.cut(0.0)) == 1
    assert attempt.scene_at(7.9 / 60) == {"a": 2}
    assert attempt.scene_at(8 / 60) == {"a": 3}


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"name": ""}, "name"),
        ({"name": "a\nb"}, "name"),
        ({"name": "x" * 101}, "name"),
        ({"dt": 0.0}, "dt"),
        ({"times": []}, "times"),
        ({"times": [0.1, 0.2]}, "times"),
        ({"times": [0.0, 0.0]}, "times"),
        ({"times": [0.0, math.inf]}, "times"),
        ({"configurations": [[1.0, 2.0, 3.0]]}, "configurations"),
        ({"configurations": [[1.0, 2.0], [3.0, math.nan]]}, "configurations"),
        ({"configurations": "q"}, "configurations"),
        ({"targets": [[1.0], [2.0]]}, "targets"),
        ({"targets": [[1.0, None], [2.0, 1.0]]}, "targets"),
        ({"scenes": [[0.1, {}]]}, "scenes[0][0]"),
        ({"scenes": [[0.0, {}], [-1.0, {}]]}, "scenes[1][0]"),
        ({"scenes": [[0.0, {"post": {"radius": math.inf}}]]}, "scenes[0][1].post.radius"),
        ({"scenes": [[0.0, []]]}, "scenes[0][1]"),
        ({"scenes": [[0.0]]}, "scenes[0]"),
        ({"scenes": 3}, "scenes"),
        ({"strategy": None}, "strategy"),
        ({"criteria": ["a", "a"]}, "criteria"),
        ({"settings": {"f": print}}, "settings.f"),
        ({"settings": {1: 2}}, "settings"),
        ({"parent": 3}, "parent"),
        ({"branched_at": 0.1}, "branched_at"),
        ({"parent": "a", "branched_at": -0.1}, "branched_at"),
    ],
)
def test_a_wrong_value_is_refused_by_its_name(changes, key):
    with pytest.raises(ArgumentError) as error:
        make_attempt(k=2, **changes)
    assert error.value.argument == key
    data = make_attempt(k=2).to_json() | changes
    with pytest.raises(ArgumentError) as error:
        Attempt.from_json(data, "plan.json: attempts[4]")
    assert error.value.argument == f"plan.json: attempts[4].{key}"


def test_missing_and_unknown_keys_are_named():
    data = make_attempt(k=2).to_json()
    with pytest.raises(ArgumentError, match="'extra'"):
        Attempt.from_json(data | {"extra": 1})
    del data["targets"]
    with pytest.raises(ArgumentError, match="'targets'"):
        Attempt.from_json(data)
    with pytest.raises(ArgumentError, match="a mapping with name"):
        Attempt.from_json([1])


def test_data_of_any_depth_is_refused_rather_than_followed():
    nested: object = 1
    for _ in range(10_000):
        nested = [nested]
    with pytest.raises(ArgumentError, match="nested more than"):
        make_attempt(settings={"deep": nested})
