"""Edits: what an operator asks of the planner, as frozen dataclasses, to and from JSON.

In JSON an edit is an object with its kind and its fields, such as ``{"edit": "move_target", "position": [6.0, 1.5]}``.
An edit that is made knows only its own form; whether a joint, an obstacle or an attempt of that name exists is found
out where it is applied.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Any, ClassVar

from jtik.arguments import mapping
from jtik.errors import ArgumentError, UnknownNameError
from jtik.planner.edits.fields import (
    Coordinate,
    Direction,
    JointWeights,
    Name,
    Names,
    ObstacleData,
    Options,
    Point,
    Quaternion,
    Rotation,
    Value,
    Velocity,
)
from jtik.planner.files.plain import label
from jtik.strategy.options import NonNegative, Positive, read_options


@dataclass(frozen=True)
class Edit:
    """Base of the edits.

    Attributes:
        kind: its kind in JSON.

    Raises:
        ArgumentError: for a field of another form, naming it.
    """

    kind: ClassVar[str] = ""

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        cls.kind = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", cls.__name__).lower()
        EDITS[cls.kind] = cls

    def __post_init__(self) -> None:
        read_options(self)

    def to_json(self) -> dict[str, Any]:
        """The edit as plain data; `from_json` reads it."""
        return {"edit": self.kind, **{each.name: _plain(getattr(self, each.name)) for each in fields(self)}}


EDITS: dict[str, type[Edit]] = {}
"""The kinds of edits by name."""


def from_json(data: object) -> Edit:
    """The edit of plain data.

    Args:
        data: a dict with the kind under "edit", and an entry for each field, as ``to_json`` returns it.

    Raises:
        ArgumentError: for what is no edit, naming the field that is missing, not known or of another form.
        UnknownNameError: for a kind that does not exist.
    """
    given = mapping("edit", data, 'an object such as {"edit": "move_target", "position": [6.0, 1.5]}')
    kind = label("edit", given.pop("edit", None))
    if kind not in EDITS:
        raise UnknownNameError("edit", kind, EDITS)
    wanted = {each.name: each for each in fields(EDITS[kind])}
    accepted = f"{kind} with {', '.join(wanted) or 'no fields'}"
    for key in given:
        if key not in wanted:
            raise ArgumentError(str(key), given[key], accepted)
    for key, each in wanted.items():
        if key not in given and _is_required(each):
            raise ArgumentError(key, "nothing", accepted)
    return EDITS[kind](**given)


def _is_required(each: Field[Any]) -> bool:
    return each.default is MISSING and each.default_factory is MISSING


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    return [_plain(each) for each in value] if isinstance(value, (tuple, list)) else value


@dataclass(frozen=True)
class MoveTarget(Edit):
    """Move the target to a place, at most at its speed.

    Attributes:
        position: where to, (2,) or (3,) [m].
        orientation: its orientation there, a quaternion (w, x, y, z); None leaves it as it is.
    """

    position: Point
    orientation: Quaternion | None = None


@dataclass(frozen=True)
class HoldTarget(Edit):
    """Move the target at a velocity, at most at its speed, until the next edit of the target: a key or a stick is held.

    Attributes:
        velocity: velocity (2,) or (3,) [m/s]; zeros stop it.
        rotation: angular velocity about the axes of the base (3,) [rad/s]; None for none.
    """

    velocity: Velocity
    rotation: Rotation | None = None


@dataclass(frozen=True)
class Guide(Edit):
    """Guide another task from now on; the one before is held where its target is.

    Attributes:
        task: name of the task.
    """

    task: Name


@dataclass(frozen=True)
class SetTargetSpeed(Edit):
    """Set the largest speed of the target.

    Attributes:
        speed: largest speed [m/s].
        rotation: largest angular speed [rad/s]; None leaves it as it is.
    """

    speed: Positive
    rotation: Positive | None = None


@dataclass(frozen=True)
class AddObstacle(Edit):
    """Add an obstacle.

    Attributes:
        name: its name, which no other obstacle has.
        obstacle: the obstacle as plain data.
        gain: its gain, beside the gain of the criterion.
    """

    name: Name
    obstacle: ObstacleData
    gain: NonNegative = 1.0


@dataclass(frozen=True)
class ChangeObstacle(Edit):
    """Replace an obstacle: drag, resize or turn it.

    Attributes:
        name: its name.
        obstacle: the obstacle as plain data.
    """

    name: Name
    obstacle: ObstacleData


@dataclass(frozen=True)
class DeleteObstacle(Edit):
    """Delete an obstacle.

    Attributes:
        name: its name.
    """

    name: Name


@dataclass(frozen=True)
class SetObstacleGain(Edit):
    """Set the gain of one obstacle; 0 switches it off.

    Attributes:
        name: its name.
        gain: its gain, beside the gain of the criterion.
    """

    name: Name
    gain: NonNegative


@dataclass(frozen=True)
class SetPreferred(Edit):
    """Set the preferred position of one joint.

    Attributes:
        joint: name of the joint.
        value: position [rad] or [m].
    """

    joint: Name
    value: Coordinate


@dataclass(frozen=True)
class TakePosture(Edit):
    """Take the present posture as the preferred one."""


@dataclass(frozen=True)
class SetJointWeights(Edit):
    """Set weights of joints: a step minimises the weighted sum of squares of its joint motions.

    Attributes:
        weights: positive numbers by name of the joint; joints that are not named keep theirs.
    """

    weights: JointWeights


@dataclass(frozen=True)
class SetGain(Edit):
    """Set a live parameter.

    Attributes:
        parameter: its name, such as "joint_centering.stiffness", or "joint_centering.weight".
        value: a number, or as many as the parameter has.
    """

    parameter: Name
    value: Value


@dataclass(frozen=True)
class SetStrategy(Edit):
    """Choose the strategy.

    Attributes:
        name: name of a registered strategy, perhaps with a secondary term, as in "newton+qp".
        options: options of the strategy by name.
    """

    name: Name
    options: Options = field(default_factory=dict)


@dataclass(frozen=True)
class SetCriteria(Edit):
    """Choose the criteria.

    Attributes:
        names: their names; none for no criterion.
    """

    names: Names


@dataclass(frozen=True)
class SetLimits(Edit):
    """Switch the position limits.

    Attributes:
        on: whether they hold.
    """

    on: bool


@dataclass(frozen=True)
class SetClearance(Edit):
    """Switch the clearance to the obstacles.

    Attributes:
        on: whether it holds.
        safe: smallest distance allowed [m]; None leaves it as it is.
    """

    on: bool
    safe: NonNegative | None = None


@dataclass(frozen=True)
class Jog(Edit):
    """Move the arm along its self-motion while the target is at rest, until the next edit of this kind.

    Attributes:
        rate: signed speed along the self-motion [rad/s]; 0 stops it.
        direction: of a positive rate, as of `jtik.InverseKinematics.jog`: the name of a joint or of a criterion,
            "descent", an index from 0, or numbers (n,); None is 0.
    """

    rate: float
    direction: Direction | None = None
