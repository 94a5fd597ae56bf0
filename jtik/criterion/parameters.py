"""Live parameters of criteria: values by name in the memory that the compiled step reads."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, MutableMapping
from functools import partial
from typing import Any, ClassVar, Protocol

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import numeric_array
from jtik.criterion.tracing import CriterionError
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot import Robot
from jtik.symbolic import Expression, reshape, symbol
from jtik.types import Array


class Parametric(Protocol):
    """An object with a name and live parameters.

    Attributes:
        name: the first part of the names of its parameters.
    """

    name: str

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Names and first values of the live parameters on this robot.

        Args:
            robot: the robot.
        """


class JointParametric(Parametric, Protocol):
    """An object some of whose live parameters have one number for each entry of q, or are not negative."""

    joint_parameters: ClassVar[tuple[str, ...]]
    non_negative_parameters: ClassVar[tuple[str, ...]]


Check = Callable[[Array], str | None]
"""Of a value of a live parameter: None, or what would be accepted instead."""


def checks_of(criterion: Any, names: Iterable[str], prefix: str = "") -> dict[str, Check]:
    """The check of each live parameter of a criterion or a clearance, by its name after a prefix."""
    judge = getattr(criterion, "accepted_instead", None)
    return {f"{prefix}{name}": partial(judge, name) for name in names} if callable(judge) else {}


def first_values(criterion: JointParametric, robot: Robot) -> Mapping[str, ArrayLike]:
    """The first values of a criterion's live parameters by name.

    Raises:
        CriterionError: when ``parameters`` returns no mapping, or ``joint_parameters`` are not names in it.
    """
    values, of_joints = criterion.parameters(robot), criterion.joint_parameters
    if not isinstance(values, Mapping):
        raise CriterionError(
            criterion.name, f"parameters returned {values!r}; expected a dict from name to first value"
        )
    if not isinstance(of_joints, list | tuple | set | frozenset) or not all(name in list(values) for name in of_joints):
        raise CriterionError(
            criterion.name, f"joint_parameters is {of_joints!r}; expected a tuple of names in {list(values)}"
        )
    return values


class Parameters(MutableMapping[str, Array]):
    """Live parameters by name. Assigning one changes the compiled step at once; nothing is compiled again.

    A value that is read is a read-only copy: ``parameters["a.b"][0] = 1`` raises ValueError. To change one entry
    assign all entries at once::

        radii = parameters["obstacle_avoidance.radii"].copy()
        radii[0] = 0.2
        parameters["obstacle_avoidance.radii"] = radii

    A scalar is accepted for every parameter and fills all entries: ``parameters["joint_centering.stiffness"] = 2``.
    A parameter of the joints also takes numbers of the full robot, and a dict by joint name, which leaves the joints
    that it does not name as they are: ``parameters["joint_centering.preferred"] = {"elbow": 0.5}``.

    Args:
        values: first values by name: finite scalars, vectors or matrices.
        robot: the robot whose joints the parameters of the joints belong to.
        of_joints: names of the parameters with one number for each entry of q.
        non_negative: names of the parameters that no negative number can be assigned to.
        checks: for some parameters, by name, a function of an assigned value that returns None, or what would be
            accepted instead.

    Attributes:
        memory: all values in one vector, matrices columns first; the compiled functions read it.

    Raises:
        ArgumentError: when a value is not finite, not numeric, or has more than two axes; when the first value of a
            parameter of the joints has another shape than (nq,).
        UnknownNameError: when a name is read or assigned that does not exist.
    """

    __slots__ = ("_checks", "_non_negative", "_of_joints", "_robot", "_shapes", "_slices", "memory")
    # an attribute with another name is a misspelt name of a parameter

    def __init__(
        self,
        values: Mapping[str, ArrayLike],
        robot: Robot,
        of_joints: Collection[str] = (),
        non_negative: Collection[str] = (),
        checks: Mapping[str, Check] | None = None,
    ) -> None:
        self._checks = dict(checks or {})
        self._robot, self._of_joints, self._non_negative = robot, frozenset(of_joints), frozenset(non_negative)
        self._shapes: dict[str, tuple[int, ...]] = {}
        self._slices: dict[str, slice] = {}
        flat: list[Array] = []
        start = 0
        for name, value in values.items():
            array = _finite(value)
            if array is None or array.ndim > 2:
                raise ArgumentError(name, value, "a finite scalar, vector or matrix")
            if name in self._of_joints and array.shape != (robot.nq,):
                accepted = f"shape ({robot.nq},), one number for each entry of q, as joint_parameters says"
                raise ArgumentError(name, f"shape {array.shape}", accepted)
            self._shapes[name] = array.shape
            self._slices[name] = slice(start, start + array.size)
            flat.append(array.ravel(order="F"))
            start += array.size
        self.memory: Array = np.concatenate([*flat, np.zeros(0)])

    def __getitem__(self, name: str) -> Array:
        self._check(name)
        value = self.memory[self._slices[name]].reshape(self._shapes[name], order="F").copy()
        value.flags.writeable = False
        return value

    def __setitem__(self, name: str, value: ArrayLike | Mapping[str, ArrayLike]) -> None:
        self._check(name)
        shape = self._shapes[name]
        if name in self._of_joints:
            value = self._robot.joint_values(value, default=self[name], argument=name)
        array = _finite(value)
        if array is None or array.shape not in ((), shape):
            accepted = f"finite numbers of shape {shape}, or one finite number for all of them" if shape else ""
            raise ArgumentError(name, value, accepted or "one finite number, shape ()")
        if name in self._non_negative and (array < 0).any():
            raise ArgumentError(name, value, "non-negative numbers")
        instead = self._checks[name](np.broadcast_to(array, shape)) if name in self._checks else None
        if instead is not None:
            raise ArgumentError(name, value, instead)
        self.memory[self._slices[name]] = array.ravel(order="F")

    def __delitem__(self, name: str) -> None:
        raise TypeError("parameters can be changed, not removed")

    def __iter__(self) -> Iterator[str]:
        return iter(self._slices)

    def __len__(self) -> int:
        return len(self._slices)

    def __repr__(self) -> str:
        return "\n".join(f"{name} = {self[name].tolist()}" for name in self) or "no parameters"

    @property
    def shapes(self) -> Mapping[str, tuple[int, ...]]:
        """The shape of each parameter by name."""
        return dict(self._shapes)

    def symbols(self) -> Expression:
        """One column of symbols for all parameters."""
        return symbol("parameters", self.memory.size)

    def take(self, column: Expression, name: str) -> Expression:
        """The expression of one parameter within that column, in its own shape.

        Args:
            column: all parameters, as `symbols` returns them.
            name: name of the parameter.
        """
        shape = (*self._shapes[name], 1, 1)[:2]
        return reshape(column[self._slices[name]], *shape)

    def _check(self, name: str) -> None:
        if name not in self._slices:
            raise UnknownNameError("parameter", name, self._slices)


def _finite(value: Any) -> Array | None:
    """The numbers given as an array of float64; None where they are not numeric or not finite."""
    array = numeric_array(value)
    return array if array is not None and np.isfinite(array).all() else None
