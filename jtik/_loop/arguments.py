"""Configurations and targets that a solver is given, checked before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from jtik.arguments import several, shape_of
from jtik.constraints.limits import AT_LIMIT
from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.task import TaskStack
from jtik.types import Array

_FLOAT = np.dtype(np.float64)


class ConfigurationReader:
    """Reads configurations of one robot.

    Args:
        robot: the robot.
        lower: lower limits, (nq,), read where they are whenever a configuration is clamped.
        upper: upper limits, (nq,), likewise.

    Attributes:
        vector: whether q is a vector of joint positions, without quaternions.
    """

    def __init__(self, robot: Robot, lower: Array, upper: Array) -> None:
        self._robot, self._lower, self._upper = robot, lower, upper
        self._shape = (robot.nq,)
        self.vector = robot.nq == robot.n

    def read(self, argument: str, q: Any) -> Array:
        """The configuration given, (nq,).

        Raises:
            ArgumentError: for a wrong shape, NaN, infinity or a zero quaternion, naming ``argument``.
        """
        if self.vector and type(q) is np.ndarray and q.shape == self._shape and q.dtype == np.float64:
            usual: Array = q
            if math.isfinite(sum(usual.tolist())):
                return usual
        elif self.vector and type(q) is list and len(q) == self._shape[0] and {*map(type, q)} == {float}:
            numbers: Array = np.array(q)
            if math.isfinite(sum(q)):
                return numbers
        return self._robot.configuration(q, argument=argument)

    def start(self, q0: Any) -> Array:
        """Where a solve starts: the configuration ``q0``, or the robot's home for None, (nq,).

        Raises:
            ArgumentError: for a configuration that `read` refuses.
        """
        return self._robot.home if q0 is None else self._read_start("q0", q0)

    def unread(self, q0: Any) -> Array:
        """The same; an array of numbers is returned as it is, and need not be finite.

        Raises:
            ArgumentError: for anything else that `read` refuses.
        """
        start = self._robot.home if q0 is None else q0
        if self.vector and type(start) is np.ndarray and start.dtype is _FLOAT and start.shape == self._shape:
            usual: Array = start
            return usual
        return self.start(q0)

    def _read_start(self, argument: str, q0: Any) -> Array:
        """The configuration as `read` gives it; clamped to the limits where its sum is too large for a number."""
        q = self.read(argument, q0)
        return q if math.isfinite(sum(q.tolist())) else self.clamped(q)

    def starts(self, q0: Any, count: int) -> Array:
        """Where ``count`` solves start: one configuration for all, (1, nq), or one for each, (count, nq).

        Raises:
            ArgumentError: for another number of configurations, or one that `read` refuses.
        """
        if not _several(q0):
            return self.start(q0).reshape(1, -1)
        if len(q0) != count:
            accepted = f"one configuration of shape {self._shape} for all targets, or {count}, one for each"
            raise ArgumentError("q0", f"{len(q0)} configurations", accepted)
        if self.vector and type(q0) is np.ndarray and q0.dtype == np.float64 and q0.shape[1:] == self._shape:
            with np.errstate(over="ignore", invalid="ignore"):
                if np.isfinite(q0.sum(axis=1)).all():
                    table: Array = q0.copy(order="C")
                    return table
        return np.array([self._read_start(f"q0[{i}]", row) for i, row in enumerate(q0)]).reshape(count, *self._shape)

    def clamped(self, q: Array, lower: Array | None = None, upper: Array | None = None) -> Array:
        """A copy of the configuration, clamped to the limits, or to others."""
        scalar = self._robot.scalar_q
        lower, upper = self._lower if lower is None else lower, self._upper if upper is None else upper
        q = q.copy()
        q[scalar] = np.clip(q[scalar], lower[scalar], upper[scalar])
        return q

    def check_within_limits(self, q: Array, argument: str) -> None:
        """Raise ArgumentError unless the configuration is within the limits."""
        scalar = self._robot.scalar_q
        outside = (q[scalar] < self._lower[scalar] - AT_LIMIT) | (q[scalar] > self._upper[scalar] + AT_LIMIT)
        if outside.any():
            i = scalar[np.flatnonzero(outside)[0]]
            name = next(joint for joint in self._robot.joint_names if self._robot.q_slice(joint).start == i)
            accepted = f"a configuration within the limits, {self._lower[i]:g} to {self._upper[i]:g} for this joint"
            raise ArgumentError(argument, f"{q[i]:g} for joint {name!r}", f"{accepted}, where jump_limit is given")


def _several(q: Any) -> bool:
    """Whether these are several configurations rather than one."""
    if isinstance(q, (list, tuple)):
        return any(hasattr(row, "__len__") and not isinstance(row, str) for row in q)
    return not isinstance(q, Mapping) and len(shape_of(q) or ()) > 1


def read_targets(
    tasks: TaskStack, targets: Iterable[Any], read_matrices: Callable[[Array], Array | None] | None = None
) -> tuple[Sequence[Any] | Array, Array]:
    """The targets as they were given, and the numbers of each, (k, size); all are checked.

    Args:
        tasks: the tasks.
        targets: the targets.
        read_matrices: a faster way than that of the task, which is not always there.

    Raises:
        ArgumentError: naming the target, such as ``targets[3]``.
    """
    given: Any = targets
    if type(targets) is not np.ndarray or not targets.ndim:
        given = several("targets", targets, "a list of targets, or an array with one target a row")
    table = tasks.read_table(given, read_matrices)
    if table is not None:
        return given, table
    numbers = []
    for i, target in enumerate(given):
        try:
            numbers.append(tasks.read_target(target))
        except ArgumentError as error:
            inner = error.argument.removeprefix("target")
            raise ArgumentError(f"targets[{i}]{inner}", error.given, error.accepted) from None
    return given, np.array(numbers).reshape(len(given), tasks.target_size)
