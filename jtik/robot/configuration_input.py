"""Configurations as callers give them: numbers, a dict by joint name, or q of the robot before `Robot.subset`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

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
        return _from_names(space, q, argument)
    if space.full is not space:
        shape = _shape(q)
        sizes = _sizes(space)
        if shape is not None and shape != sizes[:1]:
            if shape not in [(size,) for size in sizes]:
                raise ArgumentError(argument, f"shape {shape}", _accepted(sizes))
            return space.reduced(space.full.configuration(q, argument=argument))
    array = finite_array(argument, q, (space.nq,))
    _check_quaternions(space, argument, array)
    return array


def _from_names(space: ConfigurationSpace, named: Mapping[str, Any], argument: str) -> Array:
    """The configuration of a dict by joint name; joints that are not named are at `neutral`."""
    q, own = space.neutral.copy(), set(space.joint_names)
    known = _outermost(space).joint_names
    for name, value in named.items():
        if name not in known:
            raise UnknownNameError(f"joint in {argument}", name, known)
        if name in own:
            indices = space.q_slice(name)
            size = indices.stop - indices.start
            shape = () if size == 1 and np.ndim(value) == 0 else (size,)
            q[indices] = finite_array(f"{argument}[{name!r}]", value, shape)
    _check_quaternions(space, argument, q)
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
    return f"{own} number{'s' if own > 1 else ''} for ik.robot{more}, or a dict by joint name"


def _shape(q: Any) -> tuple[int, ...] | None:
    """The shape of an array-like; None for a ragged one."""
    try:
        shape: tuple[int, ...] = np.shape(q)
    except ValueError:
        return None
    return shape
