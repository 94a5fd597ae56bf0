"""Evaluation of a criterion and its gradient at one configuration, as numbers or as expressions."""

from __future__ import annotations

import weakref
from collections.abc import Mapping
from functools import partial
from typing import Any, ClassVar, Protocol

import numpy as np

from jtik.criterion.parameters import Parameters, Parametric, checks_of, first_values
from jtik.criterion.tracing import traced
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression, Function, function, gradient, is_symbolic, symbol, vec, vertcat


class Evaluable(Parametric, Protocol):
    """A criterion as the evaluation uses it."""

    joint_parameters: ClassVar[tuple[str, ...]]
    non_negative_parameters: ClassVar[tuple[str, ...]]

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """H as an expression."""


def value(criterion: Evaluable, q: Any, robot: Robot, given: Mapping[str, Any]) -> Any:
    """H at q: a float, or an expression where q or a parameter is one.

    Args:
        criterion: the criterion.
        q: configuration (nq,), or an expression (nq, 1).
        robot: the robot.
        given: values of parameters by name; the others have their first values.

    Raises:
        ArgumentError: when q, the robot or the value of a parameter cannot be used.
        UnknownNameError: when the criterion has no parameter of that name.
        CriterionError: when the criterion cannot be traced.
    """
    parameters, column = _column(criterion, checked_robot(robot), given)
    result = _compiled(criterion, robot, parameters).value(checked_configuration(q, robot), column)
    return result if is_symbolic(result) else float(result)


def derivative(criterion: Evaluable, q: Any, robot: Robot, given: Mapping[str, Any]) -> Any:
    """dH/dv at q, the gradient with respect to the velocity: an array (n,), or an expression (n, 1).

    Arguments and errors are those of `value`.
    """
    parameters, column = _column(criterion, checked_robot(robot), given)
    result = _compiled(criterion, robot, parameters).gradient(robot)(checked_configuration(q, robot), column)
    return result if is_symbolic(result) else np.array(result.full())[:, 0]


def checked_robot(robot: Robot) -> Robot:
    """The robot. Raises ArgumentError for anything else."""
    if not isinstance(robot, Robot):
        raise ArgumentError("robot", robot, "a jtik.Robot, as in criterion(q, robot)")
    return robot


def checked_configuration(q: Any, robot: Robot) -> Any:
    """q as an array (nq,) or an expression (nq, 1). Raises ArgumentError for anything else."""
    if not is_symbolic(q):
        return robot.configuration(q)
    if q.shape != (robot.nq, 1):
        raise ArgumentError("q", f"an expression of shape {q.shape}", f"shape ({robot.nq}, 1)")
    return q


class _CompiledCriterion:
    """H and its gradient as functions of (q, parameters). Refers neither to the criterion nor to the robot."""

    def __init__(self, criterion: Evaluable, robot: Robot, parameters: Parameters) -> None:
        self.shapes = parameters.shapes
        self._q, self._column = symbol("q", robot.nq), parameters.symbols()
        own = {name: parameters.take(self._column, name) for name in parameters}
        kinematics = robot.at(self._q)
        self._H = traced(criterion.name, lambda: criterion.value(kinematics, own), (self._q, self._column))
        self.value: Function = function("value", [self._q, self._column], [self._H])
        self._gradient: Function | None = None

    def gradient(self, robot: Robot) -> Function:
        """The gradient, built when it is first used."""
        if self._gradient is None:
            along = robot.tangent(self._q).T @ gradient(self._H, self._q)
            self._gradient = function("gradient", [self._q, self._column], [along])
        return self._gradient


_Entry = tuple["weakref.ref[Evaluable]", _CompiledCriterion]

_cache: weakref.WeakKeyDictionary[Robot, dict[int, _Entry]] = weakref.WeakKeyDictionary()
"""Compiled criteria by robot and by the identity of the criterion; an entry ends with either of the two."""


def _compiled(criterion: Evaluable, robot: Robot, parameters: Parameters) -> _CompiledCriterion:
    """The compiled criterion, from the cache where its parameters have the same shapes."""
    entries = _cache.setdefault(robot, {})
    found = entries.get(id(criterion))
    if found is not None and found[1].shapes == parameters.shapes:
        return found[1]
    made = _CompiledCriterion(criterion, robot, parameters)
    entries[id(criterion)] = (weakref.ref(criterion, partial(_forget, entries, id(criterion))), made)
    return made


def _forget(entries: dict[int, _Entry], key: int, reference: weakref.ref[Evaluable]) -> None:
    """Remove the entry of a criterion that is gone, unless a new criterion already has its identity."""
    if key in entries and entries[key][0] is reference:
        del entries[key]


def _column(criterion: Evaluable, robot: Robot, given: Mapping[str, Any]) -> tuple[Parameters, Any]:
    """The parameters with their shapes, and all values in one column."""
    first = first_values(criterion, robot)
    checks = checks_of(criterion, first)
    parameters = Parameters(first, robot, criterion.joint_parameters, criterion.non_negative_parameters, checks)
    symbolic = {name: each for name, each in given.items() if is_symbolic(each)}
    for name, each in given.items():
        if name not in parameters:
            raise UnknownNameError("parameter", name, parameters)
        if name not in symbolic:
            parameters[name] = each
    if not symbolic:
        return parameters, parameters.memory
    parts = []
    for name in parameters:
        if name not in symbolic:
            parts.append(parameters[name].ravel(order="F"))
            continue
        expected = (*parameters.shapes[name], 1, 1)[:2]
        if symbolic[name].shape not in ((1, 1), expected):
            raise ArgumentError(name, f"an expression of shape {symbolic[name].shape}", f"shape {expected}")
        parts.append(vec(symbolic[name] * np.ones(expected)))
    return parameters, vertcat(*parts)
