"""Values of joints as callers give them: numbers, a dict by joint name, or those of the robot before `Robot.subset`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, UnknownNameError, finite_array
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.configuration_space import ConfigurationSpace

_FLOAT = np.dtype(np.float64)


def read_configuration(space: ConfigurationSpace, q: Any, argument: str) -> Array:
    """A checked copy of a configuration, (nq,); see `ConfigurationSpace.configuration`."""
    quaternions = space.quaternions
    if type(q) is np.ndarray and q.shape == (space.nq,) and q.dtype == _FLOAT and not quaternions:
        copy: Array = q.copy()
        if math.isfinite(sum(copy.tolist())):
            return copy
    if isinstance(q, Mapping):
        array = _from_names(space, q, argument, space.neutral)
        _check_quaternions(space, argument, array)
        return array
    if space.full is not space:
        shape = _shape(q)
        sizes = _sizes(space)
        if shape is not None and shape != sizes[:1]:
            if shape not in [(size,) for size in sizes]:
                raise ArgumentError(argument, f"shape {shape}", f"{_accepted(sizes)}, or a dict by joint name")
            return space.reduced(space.full.configuration(q, argument=argument))
    array = finite_array(argument, q, (space.nq,))
    _check_quaternions(space, argument, array)
    return array


def read_joint_values(space: ConfigurationSpace, values: Any, argument: str, default: ArrayLike) -> Array:
    """One number for each entry of q, (nq,); see `ConfigurationSpace.joint_values`."""
    if isinstance(values, Mapping):
        others = finite_array("default", default, () if _shape(default) == () else (space.nq,))
        return _from_names(space, values, argument, np.broadcast_to(others, space.nq))
    sizes, shape = _sizes(space), _shape(values)
    accepted = f"{_accepted(sizes)}, one number for all of them, or a dict by joint name"
    if shape not in (None, (), *((size,) for size in sizes)):
        raise ArgumentError(argument, f"shape {shape}", accepted)
    try:
        array = finite_array(argument, values, shape or ())
    except ArgumentError as error:
        raise ArgumentError(argument, error.given, accepted) from None
    return _kept(space, array) if array.ndim else np.full(space.nq, array)


def _kept(space: ConfigurationSpace, values: Array) -> Array:
    """Of one number for each entry of q, or of q of a robot that this one was made from, those of this robot."""
    return values if values.size == space.nq else _kept(space.full, values)[space.kept_indices]


def _from_names(space: ConfigurationSpace, named: Mapping[str, Any], argument: str, default: Array) -> Array:
    """The numbers of a dict by joint name; joints that are not named have those of ``default``."""
    q, own = default.copy(), set(space.joint_names)
    known = _outermost(space).joint_names
    for name, value in named.items():
        if name not in known:
            raise UnknownNameError(f"joint in {argument}", name, known)
        if name in own:
            indices = space.q_slice(name)
            size = indices.stop - indices.start
            shape = () if size == 1 and _shape(value) == () else (size,)
            q[indices] = finite_array(f"{argument}[{name!r}]", value, shape)
    return q


def _check_quaternions(space: ConfigurationSpace, argument: str, q: Array) -> None:
    for name, indices in space.quaternions.items():
        if not q[indices].any():
            given = f"a zero quaternion for joint {name!r}"
            raise ArgumentError(argument, given, "quaternions (w, x, y, z) other than zero")


def _outermost(space: ConfigurationSpace) -> ConfigurationSpace:
    """The robot that no other one was reduced to."""
    while space.full is not space:
        space = space.full
    return space


def _sizes(space: ConfigurationSpace) -> tuple[int, ...]:
    """The lengths that are accepted: that of the robot, then those of the robots that it was made from."""
    sizes = [space.nq]
    while space.full is not space:
        space = space.full
        if space.nq not in sizes:
            sizes.append(space.nq)
    return tuple(sizes)


def _accepted(sizes: tuple[int, ...]) -> str:
    own, *full = sizes
    more = f", or {' or '.join(map(str, full))} for the full robot" if full else ""
    return f"{own} number{'s' if own > 1 else ''} for ik.robot{more}"


def _shape(q: Any) -> tuple[int, ...] | None:
    """The shape of an array-like; None for a ragged one."""
    try:
        shape: tuple[int, ...] = np.shape(q)
    except ValueError:
        return None
    return shape
