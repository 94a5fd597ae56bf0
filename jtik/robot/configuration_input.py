"""Values of joints as callers give them: numbers, a dict by joint name, or those of the robot before `Robot.subset`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array
from jtik.arguments import shape_of as _shape
from jtik.errors import ArgumentError, UnknownNameError
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.configuration_space import ConfigurationSpace

_FLOAT = np.dtype(np.float64)

ROUNDING = 1e-12
"""Difference of the norm of a quaternion from 1 that is rounding."""


def read_configuration(space: ConfigurationSpace, q: Any, argument: str) -> Array:
    """A checked copy of a configuration, (nq,); see `ConfigurationSpace.configuration`."""
    quaternions = space.quaternions
    if type(q) is np.ndarray and q.shape == (space.nq,) and q.dtype == _FLOAT and not quaternions:
        copy: Array = q.copy()
        if math.isfinite(sum(copy.tolist())):
            return copy
    if isinstance(q, Mapping):
        array = _from_names(space, q, argument, space.neutral)
        return _with_unit_quaternions(space, argument, array)
    if space.full is not space:
        shape = _shape(q)
        sizes = _sizes(space)
        if shape is not None and shape != sizes[:1]:
            if shape not in [(size,) for size in sizes]:
                raise ArgumentError(argument, f"shape {shape}", f"{_accepted(sizes)}, or a dict by joint name")
            return space.reduced(space.full.configuration(q, argument=argument))
    array = finite_array(argument, q, (space.nq,))
    return _with_unit_quaternions(space, argument, array)


def read_joint_values(space: ConfigurationSpace, values: Any, argument: str, default: ArrayLike) -> Array:
    """One number for each entry of q, (nq,); see `ConfigurationSpace.joint_values`."""
    others = _default(default, space.nq)
    if isinstance(values, Mapping):
        return _from_names(space, values, argument, others)
    array = _numbers(values, argument, _sizes(space))
    return _kept(space, array) if array.ndim else np.full(space.nq, array)


def read_velocity_values(space: ConfigurationSpace, values: Any, argument: str, default: ArrayLike) -> Array:
    """One number for each velocity entry, (n,); see `ConfigurationSpace.velocity_values`."""
    others = _default(default, space.n)
    if isinstance(values, Mapping):
        return _velocity_from_names(space, values, argument, others)
    robots = [space]
    while robots[-1].full is not robots[-1]:
        robots.append(robots[-1].full)
    array = _numbers(values, argument, tuple(dict.fromkeys(robot.n for robot in robots)), one=False)
    given = next(robot for robot in robots if robot.n == array.size)
    return np.concatenate([array[given.v_slice(name)] for name in space.joint_names])


def _default(default: ArrayLike, size: int) -> Array:
    """The values of joints that a dict does not name, (size,)."""
    others = finite_array("default", default, () if _shape(default) == () else (size,))
    return np.broadcast_to(others, size)


def _numbers(values: Any, argument: str, sizes: tuple[int, ...], *, one: bool = True) -> Array:
    """As many numbers as one of the sizes, or, where that is accepted, one."""
    shape = _shape(values)
    accepted = f"{_accepted(sizes)}, {'one number for all of them, ' if one else ''}or a dict by joint name"
    if shape not in (None, *([()] if one else []), *((size,) for size in sizes)):
        raise ArgumentError(argument, repr(values) if shape == () else f"shape {shape}", accepted)
    try:
        return finite_array(argument, values, shape or ())
    except ArgumentError as error:
        raise ArgumentError(argument, error.given, accepted) from None


def _kept(space: ConfigurationSpace, values: Array) -> Array:
    """Of one number for each entry of q, or of q of a robot that this one was made from, those of this robot."""
    return values if values.size == space.nq else _kept(space.full, values)[space.kept_indices]


def _from_names(space: ConfigurationSpace, named: Mapping[str, Any], argument: str, default: Array) -> Array:
    """The numbers of a dict by joint name; joints that are not named have those of ``default``."""
    q = default.copy()
    for name in _own_names(space, named, argument):
        indices, value = space.q_slice(name), named[name]
        size = indices.stop - indices.start
        shape = () if size == 1 and _shape(value) == () else (size,)
        q[indices] = finite_array(f"{argument}[{name!r}]", value, shape)
    return q


def _velocity_from_names(space: ConfigurationSpace, named: Mapping[str, Any], argument: str, default: Array) -> Array:
    """The same for velocity entries; one number is that of all entries of a joint."""
    v = default.copy()
    for name in _own_names(space, named, argument):
        indices = space.v_slice(name)
        shape = () if _shape(named[name]) == () else (indices.stop - indices.start,)
        v[indices] = finite_array(f"{argument}[{name!r}]", named[name], shape)
    return v


def _own_names(space: ConfigurationSpace, named: Mapping[str, Any], argument: str) -> list[str]:
    """The names that are joints of ``space``; the others must be locked joints of the robots it was made from."""
    own, known = set(space.joint_names), _outermost(space).joint_names
    for name in named:
        if name not in known:
            raise UnknownNameError(f"joint in {argument}", name, known)
    return [name for name in named if name in own]


def _with_unit_quaternions(space: ConfigurationSpace, argument: str, q: Array) -> Array:
    """The configuration with its quaternions of norm 1, in place; one that has it up to rounding stays as it is."""
    for name, indices in space.quaternions.items():
        norm = math.hypot(*q[indices].tolist())
        if norm == 0:
            given = f"a zero quaternion for joint {name!r}"
            raise ArgumentError(argument, given, "quaternions (w, x, y, z) other than zero")
        if abs(norm - 1) > ROUNDING:
            largest = np.abs(q[indices]).max()  # a norm may be too large or too small for a number
            scaled = q[indices] / largest
            q[indices] = scaled / math.hypot(*scaled.tolist())
    return q


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
