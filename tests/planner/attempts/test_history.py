"""The tree of attempts: branches keep their parents, names are unique, and what is no history is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from jtik.errors import ArgumentError, UnknownNameError
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.history import History
from jtik.planner.attempts.recording import Recording

from ..conftest import make_attempt, same


def test_a_branch_has_the_samples_of_its_parent_and_leaves_it_as_it_is():
    history = History().add(make_attempt(k=20))
    beginning = history.branch("attempt 1", 10.2 / 60)
    assert beginning.name == "attempt 1.1"
    assert beginning.parent == "attempt 1"
    assert beginning.branched_at == 10 / 60
    recording = Recording(beginning)
    for i in range(5):
        recording.add(100.0 + i / 60, np.full(3, float(i)), np.zeros(2))
    history = history.add(recording.attempt())
    assert len(history["attempt 1"]) == 20
    child = history["attempt 1.1"]
    assert (child.configurations[:11] == history["attempt 1"].configurations[:11]).all()
    assert (child.configurations[11:] == np.arange(5.0)[:, None]).all()
    assert np.allclose(np.diff(child.times), 1 / 60)
    assert history.children("attempt 1") == (child,)
    assert history.free_name() == "attempt 2"
    assert history.free_name("attempt 1") == "attempt 1.2"
    assert history.branch("attempt 1.1", 0.0).name == "attempt 1.1.1"


def test_every_change_gives_another_history():
    first = History()
    second = first.add(make_attempt())
    third = second.choose("attempt 1")
    assert (len(first), len(second), second.chosen, third.chosen) == (0, 1, None, "attempt 1")
    assert third.choose(None).chosen is None


def test_those_below_a_deleted_attempt_move_below_its_parent():
    history = History().add(make_attempt(k=30))
    history = history.add(history.branch("attempt 1", 20 / 60))
    history = history.add(history.branch("attempt 1.1", 20 / 60))
    history = history.add(history.branch("attempt 1.1", 10 / 60))
    history = history.choose("attempt 1.1").delete("attempt 1.1")
    assert history.names == ("attempt 1", "attempt 1.1.1", "attempt 1.1.2")
    assert history.chosen is None
    assert {each.parent for each in history.children("attempt 1")} == {"attempt 1"}
    assert history["attempt 1.1.2"].branched_at == 10 / 60
    rest = history.delete("attempt 1")
    assert [each.parent for each in rest] == [None, None]
    assert [each.branched_at for each in rest] == [None, None]


def test_rename_keeps_the_tree_and_the_choice():
    history = History().add(make_attempt(k=30))
    history = history.add(history.branch("attempt 1", 0.1)).choose("attempt 1")
    history = history.rename("attempt 1", "around the post")
    assert history.chosen == "around the post"
    assert history["attempt 1.1"].parent == "around the post"
    with pytest.raises(ArgumentError, match="'attempt 1.1'"):
        history.rename("around the post", "attempt 1.1")


def test_wrong_names_and_times_are_refused():
    history = History().add(make_attempt(k=30))
    with pytest.raises(ArgumentError, match="a name of its own"):
        history.add(make_attempt())
    with pytest.raises(ArgumentError, match="parent"):
        history.add(make_attempt("b", parent="c"))
    with pytest.raises(ArgumentError, match="time"):
        history.branch("attempt 1", 1.0)
    with pytest.raises(ArgumentError, match="time"):
        history.branch("attempt 1", -1.0)
    for call in (history.choose, history.delete, history.__getitem__, lambda name: history.branch(name, 0.0)):
        with pytest.raises(UnknownNameError, match="attempt 1"):
            call("attempt 2")


COMMANDS = st.lists(st.tuples(st.sampled_from(["add", "branch", "delete", "choose"]), st.integers(0, 9)), max_size=12)


@given(COMMANDS)
def test_any_sequence_of_changes_gives_a_tree_that_survives_json(commands):
    history = History()
    for command, which in commands:
        name = history.names[which % len(history)] if len(history) else None
        if command == "add":
            history = history.add(make_attempt(history.free_name(), k=4))
        elif name is not None and command == "branch":
            history = history.add(history.branch(name, min(which / 180, history[name].duration)))
        elif name is not None and command == "delete":
            history = history.delete(name)
        elif name is not None:
            history = history.choose(name)
    again = History.from_json(json.loads(json.dumps(history.to_json())))
    assert again.names == history.names
    assert again.chosen == history.chosen
    assert all(same(a, b) for a, b in zip(again, history, strict=True))
    for attempt in history:
        if attempt.branched_at is not None:
            parent, k = history[attempt.parent], round(attempt.branched_at * 60) + 1
            assert (attempt.configurations[:k] == parent.configurations[:k]).all()


@pytest.mark.parametrize(
    ("damage", "key"),
    [
        (lambda data: data.update(chosen="attempt 9"), "chosen"),
        (lambda data: data.update(chosen=1), "chosen"),
        (lambda data: data.update(attempts={}), "attempts"),
        (lambda data: data.update(other=1), ""),
        (lambda data: data.pop("chosen"), ""),
        (lambda data: data["attempts"].append(3), "attempts[2]"),
        (lambda data: data["attempts"].append(data["attempts"][0]), "attempts"),
        (lambda data: data["attempts"].reverse(), "attempts[0].parent"),
        (lambda data: data["attempts"][1].update(dt=-1), "attempts[1].dt"),
    ],
)
def test_a_strangers_history_is_refused_by_file_and_key(damage, key):
    history = History().add(make_attempt(k=3))
    data = history.add(history.branch("attempt 1", 0.01)).to_json()
    damage(data)
    with pytest.raises(ArgumentError) as error:
        History.from_json(data, "plan.json")
    assert error.value.argument == ("plan.json" + f": {key}" * bool(key))


def test_a_recording_replaces_a_sample_of_the_same_time_and_tells_when_the_scene_changed():
    recording = Recording(make_attempt(k=1))
    recording.add(5.0, np.zeros(3), np.zeros(2))
    recording.add(5.0, np.ones(3), np.ones(2))
    recording.change_scene({"a": {"radius": 1.0}})
    recording.add(5.5, np.zeros(3), np.zeros(2))
    recording.change_scene({"a": {"radius": 2.0}})
    recording.change_scene({"a": {"radius": 3.0}})
    attempt = recording.attempt()
    assert np.allclose(attempt.times, [0.0, 1 / 60, 1 / 60 + 0.5])
    assert (attempt.configurations[1] == 1).all()
    assert attempt.scene_at(0.0) == {}
    assert [scene.get("a", {}).get("radius") for _, scene in attempt.scenes] == [None, 1.0, 3.0]
    assert isinstance(Attempt.from_json(attempt.to_json()), Attempt)
