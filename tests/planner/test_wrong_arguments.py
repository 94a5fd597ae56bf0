"""Wrong arguments of what plans are made with: an error that names the argument, and never another one."""

from __future__ import annotations

import pytest

import jtik
from jtik.constraints import Limits
from jtik.errors import ArgumentError, JtikError
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.compare import measure
from jtik.planner.attempts.history import History
from jtik.planner.commit.commands import export
from jtik.planner.commit.committing import as_recorded, check, commit, timed
from jtik.planner.commit.trajectories import animation, as_trajectory, figure
from jtik.planner.files.plan_file import Plan
from jtik.planner.files.recovery import recover
from jtik.planner.files.sessions import new_folder, recoverable

from .conftest import make_attempt

ARM, ATTEMPT, LIMITS = jtik.Robot.planar(3), make_attempt(k=5), Limits(velocity=1.0, acceleration=1.0)
WRONG = (None, 3, "x", [1.0], object(), {"x": 1})

CALLS = {
    "measure.attempt": lambda x: measure(x, ARM),
    "measure.robot": lambda x: measure(ATTEMPT, x),
    "measure.bodies": lambda x: measure(ATTEMPT, ARM, bodies=x) if x is not None else _refuse(),
    "measure.accuracy": lambda x: measure(ATTEMPT, ARM, accuracy=x) if x != 3 else _refuse(),
    "check.motion": lambda x: check(x, ARM),
    "check.robot": lambda x: check(ATTEMPT, x),
    "check.limits": lambda x: check(ATTEMPT, ARM, limits=x) if x is not None else _refuse(),
    "check.scene": lambda x: check(ATTEMPT, ARM, scene=x) if x is not None else _refuse(),
    "timed.attempt": lambda x: timed(x, ARM),
    "timed.robot": lambda x: timed(ATTEMPT, x),
    "timed.limits": lambda x: timed(ATTEMPT, ARM, limits=x) if x is not None else _refuse(),
    "timed.period": lambda x: timed(ATTEMPT, ARM, period=x) if x != 3 else _refuse(),
    "timed.method": lambda x: timed(ATTEMPT, ARM, method=x) if x is not None else _refuse(),
    "timed.smoothing": lambda x: timed(ATTEMPT, ARM, smoothing=x) if x != 3 else _refuse(),
    "as_recorded": lambda x: as_recorded(x, ARM),
    "commit.format": lambda x: commit(ATTEMPT, ARM, "a.csv", x),
    "commit.path": lambda x: commit(ATTEMPT, ARM, x, "csv") if x != "x" else _refuse(),
    "export.commands": lambda x: export(x, "a.csv"),
    "as_trajectory": lambda x: as_trajectory(x, ARM),
    "figure.motion": lambda x: figure(x, ARM),
    "animation.motion": lambda x: animation("a.gif", x, ARM),
    "History.attempts": lambda x: History(x),
    "History.add": lambda x: History().add(x),
    "History.choose": lambda x: History((ATTEMPT,)).choose(x) if x is not None else _refuse(),
    "History.delete": lambda x: History((ATTEMPT,)).delete(x),
    "History.branch": lambda x: History((ATTEMPT,)).branch(ATTEMPT.name, x) if x != 3 else _refuse(),
    "History.rename": lambda x: History((ATTEMPT,)).rename(ATTEMPT.name, x) if x != "x" else _refuse(),
    "History.from_json": lambda x: History.from_json(x),
    "Attempt.from_json": lambda x: Attempt.from_json(x),
    "Attempt.index": lambda x: ATTEMPT.index(x) if x != 3 else _refuse(),
    "Plan.robot": lambda x: Plan(robot=x),
    "Plan.history": lambda x: Plan(robot=Plan.robot_of(ARM), history=x),
    "Plan.load": lambda x: Plan.load(x),
    "recover": lambda x: recover(x),
    "new_folder": lambda x: new_folder(x) if x not in (None, "x") else _refuse(),
    "recoverable": lambda x: recoverable(x) if x not in (None, "x") else _refuse(),
}


def _refuse():
    raise ArgumentError("argument", "a value that is accepted", "nothing to test")


@pytest.mark.thinned
@pytest.mark.parametrize("name", CALLS)
@pytest.mark.parametrize("value", WRONG, ids=[type(each).__name__ for each in WRONG])
def test_a_wrong_argument_is_refused(name, value, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(JtikError) as error:
        CALLS[name](value)
    assert str(error.value)
    assert list(tmp_path.iterdir()) == []
