"""Fields of edits, each with the reader of its values: what an edit declares by its annotations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

import numpy as np

from jtik import arguments
from jtik.arguments import array_of, mapping, positive_number
from jtik.errors import ArgumentError
from jtik.planner.files.plain import label

LARGEST = 1e6
"""Largest coordinate, angle or gain that an edit may have, in its unit: beyond it is a slip of the keyboard."""


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


def _coordinate(argument: str, value: object) -> float:
    accepted = f"one number up to {LARGEST:g} [rad] or [m]"
    return float(array_of(argument, value, [()], accepted, lambda x: np.isfinite(x) & (np.abs(x) <= LARGEST)))


def _direction(argument: str, value: object) -> str | int | tuple[float, ...]:
    if isinstance(value, str):
        return label(argument, value)
    accepted = "a joint, a criterion, an index from 0, or numbers, one for each velocity entry"
    if isinstance(value, int) and not isinstance(value, bool):
        return arguments.integer(argument, value, accepted=accepted)
    return tuple(array_of(argument, value, [(None,)], accepted).tolist())


def _weights(argument: str, value: object) -> Mapping[str, float]:
    found = mapping(argument, value, "a mapping from the names of joints to their weights")
    return {label(argument, key): positive_number(f"{argument}[{key!r}]", each) for key, each in found.items()}


def _obstacle(argument: str, value: object) -> Mapping[str, Any]:
    return dict(mapping(argument, value, 'an obstacle, such as {"shape": "circle", "center": [4, 1], "radius": 0.5}'))


def _options(argument: str, value: object) -> Mapping[str, Any]:
    found = mapping(argument, value, "a mapping from the names of options to their values")
    return {label(argument, key): each for key, each in found.items()}


def _names(argument: str, value: object) -> tuple[str, ...]:
    return tuple(label(argument, each) for each in arguments.names(argument, value, "names of criteria"))


Name: TypeAlias = Annotated[str, label]
Point: TypeAlias = Annotated[tuple[float, ...], _point]
Velocity: TypeAlias = Annotated[tuple[float, ...], _velocity]
Rotation: TypeAlias = Annotated[tuple[float, ...], _rotation]
Quaternion: TypeAlias = Annotated[tuple[float, ...], _quaternion]
Value: TypeAlias = Annotated[float | tuple[Any, ...], _value]
Coordinate: TypeAlias = Annotated[float, _coordinate]
Direction: TypeAlias = Annotated[str | int | tuple[float, ...], _direction]
ObstacleData: TypeAlias = Annotated[Mapping[str, Any], _obstacle]
Options: TypeAlias = Annotated[Mapping[str, Any], _options]
JointWeights: TypeAlias = Annotated[Mapping[str, float], _weights]
Names: TypeAlias = Annotated[tuple[str, ...], _names]
