"""Edits of attempts: record, play, undo, branch, compare, save. Importing this module registers them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from jtik.planner.edits.fields import Name, Names, Options
from jtik.planner.edits.messages import Edit
from jtik.strategy.options import NonNegative, Positive


@dataclass(frozen=True)
class Record(Edit):
    """Begin to record an attempt.

    Attributes:
        name: its name; None for a free one.
    """

    name: Name | None = None


@dataclass(frozen=True)
class StopRecording(Edit):
    """End the recording.

    Attributes:
        keep: whether the attempt is kept.
    """

    keep: bool = True


@dataclass(frozen=True)
class Play(Edit):
    """Show an attempt as it was recorded; of the one that is paused, go on.

    Attributes:
        attempt: its name.
        speed: how much faster than it was recorded.
    """

    attempt: Name
    speed: Positive = 1.0


@dataclass(frozen=True)
class Pause(Edit):
    """Pause what is played."""


@dataclass(frozen=True)
class Live(Edit):
    """Leave the attempt that is shown; the arm is where it was before."""


@dataclass(frozen=True)
class Scrub(Edit):
    """Show an attempt at a time.

    Attributes:
        attempt: its name.
        time: time from its beginning [s].
    """

    attempt: Name
    time: NonNegative


@dataclass(frozen=True)
class Undo(Edit):
    """Go on with the arm and the target where they were at a time of an attempt.

    Attributes:
        attempt: its name.
        time: time from its beginning [s].
    """

    attempt: Name
    time: NonNegative


@dataclass(frozen=True)
class Branch(Edit):
    """As `Undo`, and record a new attempt that shares its beginning with the old one.

    Attributes:
        attempt: name of the old one.
        time: time from its beginning [s].
        name: name of the new one; None for a free one.
    """

    attempt: Name
    time: NonNegative
    name: Name | None = None


@dataclass(frozen=True)
class Choose(Edit):
    """Choose an attempt to commit to.

    Attributes:
        attempt: its name; None for none.
    """

    attempt: Name | None


@dataclass(frozen=True)
class DeleteAttempt(Edit):
    """Delete an attempt.

    Attributes:
        attempt: its name.
    """

    attempt: Name


@dataclass(frozen=True)
class RenameAttempt(Edit):
    """Give an attempt another name.

    Attributes:
        attempt: its name.
        name: its new name.
    """

    attempt: Name
    name: Name


@dataclass(frozen=True)
class Resolve(Edit):
    """Follow the targets of an attempt again with the scene as it is now, as a new attempt.

    Attributes:
        attempt: its name.
        strategy: name of the strategy; None for the present one.
        options: options of the strategy.
        criteria: names of the criteria; None for the present ones.
        name: name of the new attempt; None for a free one.
    """

    attempt: Name
    strategy: Name | None = None
    options: Options | None = None
    criteria: Names | None = None
    name: Name | None = None


@dataclass(frozen=True)
class SavePlan(Edit):
    """Save the plan: attempts, scene and settings.

    Attributes:
        path: path of the file.
    """

    path: str


@dataclass(frozen=True)
class LoadPlan(Edit):
    """Load a plan in place of the present one.

    Attributes:
        path: path of the file.
    """

    path: str


@dataclass(frozen=True)
class Recover(Edit):
    """Load what a former session has left, in place of the present plan.

    Attributes:
        session: name of its folder.
    """

    session: Name


@dataclass(frozen=True)
class TakePlan(Edit):
    """Take a plan in place of the present one.

    Attributes:
        plan: the plan, a `jtik.planner.files.plan_file.Plan`.
    """

    plan: Any
