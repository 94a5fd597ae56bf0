"""Edits: what an operator asks of the planner, as frozen dataclasses, to and from JSON.

In JSON an edit is an object with its kind and its fields, such as ``{"edit": "move_target", "position": [6.0, 1.5]}``.
An edit that is made knows only its own form; whether a joint, an obstacle or an attempt of that name exists is found
out where it is applied.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import MISSING, Field, dataclass, field, fields
from typing import Annotated, Any, ClassVar, TypeAlias

import numpy as np

from jtik import arguments
from jtik.arguments import array_of, mapping
from jtik.errors import ArgumentError, UnknownNameError
from jtik.strategy.options import NonNegative, Positive, read_options

LARGEST = 1e6
"""Largest coordinate, angle or gain that an edit may have, in its unit: beyond it is a slip of the keyboard."""

LONGEST_NAME = 100
"""Largest length of a name, in characters."""


def _name(argument: str, value: object) -> str:
    if isinstance(value, str) and 0 < len(value) <= LONGEST_NAME and value.isprintable() and value == value.strip():
        return str(value)
    raise ArgumentError(argument, repr(value), f"a name: 1 to {LONGEST_NAME} printable characters")


def _numbers(argument: str, value: object, sizes: tuple[int, ...], accepted: str) -> tuple[float, ...]:
    shapes = [(size,) for size in sizes]
    found = array_of(argument, value, shapes, accepted, lambda x: np.isfinite(x) & (np.abs(x) <= LARGEST))
    return tuple(found.tolist())


def _point(argument: str, value: object) -> tuple[float, ...]:
    return _numbers(argument, value, (2, 3), f"2 or 3 numbers up to {LARGEST:g} [m]")


def _velocity(argument: str, value: object) -> tuple[float, ...]:
    return _numbers(argument, value, (2, 3), f"2 or 3 numbers up to {LARGEST:g} [m/s]")


def _rotation(argument: str, value: object) -> tuple[float, ...]:
    return _numbers(argument, value, (3,), f"3 numbers up to {LARGEST:g} [rad/s], about x, y and z")


def _quaternion(argument: str, value: object) -> tuple[float, ...]:
    accepted = "a quaternion (w, x, y, z) other than zero"
    found = np.array(_numbers(argument, value, (4,), accepted))
    norm = float(np.linalg.norm(found))
    if norm < 1e-6:
        raise ArgumentError(argument, value, accepted)
    return tuple((found / norm).tolist())


def _value(argument: str, given: object) -> float | tuple[Any, ...]:
    accepted = f"a number, or numbers in a list or in rows, up to {LARGEST:g}"
    shapes = [(), (None,), (None, None)]
    found = array_of(argument, given, shapes, accepted, lambda x: np.isfinite(x) & (np.abs(x) <= LARGEST))
    value: float | tuple[Any, ...] = _nested(found.tolist())
    return value


def _nested(value: Any) -> Any:
    return tuple(_nested(each) for each in value) if isinstance(value, list) else value


def _direction(argument: str, value: object) -> tuple[float, ...]:
    found = array_of(argument, value, [(None,)], "numbers, one for each velocity entry")
    return tuple(found.tolist())


def _obstacle(argument: str, value: object) -> Mapping[str, Any]:
    return dict(mapping(argument, value, 'an obstacle, such as {"shape": "circle", "center": [4, 1], "radius": 0.5}'))


def _options(argument: str, value: object) -> Mapping[str, Any]:
    found = mapping(argument, value, "a mapping from the names of options to their values")
    return {_name(argument, key): each for key, each in found.items()}


def _names(argument: str, value: object) -> tuple[str, ...]:
    return tuple(_name(argument, each) for each in arguments.names(argument, value, "names of criteria"))


Name: TypeAlias = Annotated[str, _name]
Point: TypeAlias = Annotated[tuple[float, ...], _point]
Velocity: TypeAlias = Annotated[tuple[float, ...], _velocity]
Rotation: TypeAlias = Annotated[tuple[float, ...], _rotation]
Quaternion: TypeAlias = Annotated[tuple[float, ...], _quaternion]
Value: TypeAlias = Annotated[float | tuple[Any, ...], _value]
Direction: TypeAlias = Annotated[tuple[float, ...], _direction]
ObstacleData: TypeAlias = Annotated[Mapping[str, Any], _obstacle]
Options: TypeAlias = Annotated[Mapping[str, Any], _options]
Names: TypeAlias = Annotated[tuple[str, ...], _names]


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

    Raises:
        ArgumentError: for what is no edit, naming the field that is missing, not known or of another form.
        UnknownNameError: for a kind that does not exist.
    """
    given = mapping("edit", data, 'an object such as {"edit": "move_target", "position": [6.0, 1.5]}')
    kind = _name("edit", given.pop("edit", None))
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
    value: float


@dataclass(frozen=True)
class TakePosture(Edit):
    """Take the present posture as the preferred one."""


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
    """Move the arm along its self-motion, with the end effector at rest, until the next edit of this kind.

    Attributes:
        rate: signed speed along the self-motion [rad/s]; 0 stops it.
        direction: which of the self-motions, (n,); None for the one along which it moves most freely.
    """

    rate: float
    direction: Direction | None = None
