"""Solvers that are fixed once built: a copy shares their functions, a pickle has the arguments they were built from."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, Self, TypeVar

from jtik.criterion import Parameters
from jtik.errors import ImmutableError, JtikError
from jtik.types import Array

if TYPE_CHECKING:
    from jtik._loop.engine import Engine

S = TypeVar("S", bound="FixedSolver")

INSTEAD = {"parameters": "assign ik.parameters[name]", "tasks": "build a new InverseKinematics(..., task=...)"}
"""What to do instead of assigning an attribute; for an argument of the constructor it follows from its name."""


class FixedSolver:
    """Base of a solver: its attributes cannot be assigned.

    A copy shares the compiled functions and has memory of its own. A deep copy and a pickle are built from the
    arguments and parameters.

    Attributes:
        parameters: the live parameters.
    """

    parameters: Parameters
    _engine: Engine
    _arguments: Mapping[str, Any] | None = None

    def _fix(self, arguments: Mapping[str, Any]) -> None:
        """End the construction: from now on nothing can be assigned."""
        self._arguments = arguments

    @property
    def identity(self) -> tuple[Any, ...]:
        """What its numbers depend on: the class, the arguments and the parameters."""
        return type(self), self._arguments, dict(self.parameters)

    def __setattr__(self, attribute: str, value: object) -> None:
        if self._arguments is not None:
            instead = INSTEAD.get(attribute, "use a variable of your own")
            if attribute in self._arguments:
                instead = f"build a new InverseKinematics(..., {attribute}=...)"
            raise ImmutableError("this InverseKinematics", attribute, instead)
        super().__setattr__(attribute, value)

    def __delattr__(self, attribute: str) -> None:
        raise ImmutableError("this InverseKinematics", attribute, "build a new one")

    def __copy__(self) -> Self:
        copied = object.__new__(type(self))
        copied.__dict__.update({name: value for name, value in vars(self).items() if name != "_arguments"})
        copied._run_on(self._engine.copied())
        copied._fix(self._arguments or {})
        return copied

    def _run_on(self, engine: Engine) -> None:
        """Take an engine as one's own."""
        raise NotImplementedError

    def __deepcopy__(self, memo: dict[int, Any]) -> Self:
        return _rebuilt(type(self), copy.deepcopy(dict(self._arguments or {}), memo), self.parameters)

    def __reduce_ex__(self, protocol: Any) -> tuple[Any, ...]:
        arguments = dict(self._arguments or {})
        for name, value in arguments.items():
            try:
                pickle.dumps(value)
            except (pickle.PicklingError, AttributeError, TypeError) as error:
                raise JtikError(
                    f"this InverseKinematics cannot be pickled, because its {name} cannot: {error}; "
                    "define classes and functions at the top level of a module"
                ) from error
        return _rebuilt, (type(self), arguments, dict(self.parameters))


def _rebuilt(kind: type[S], arguments: Mapping[str, Any], parameters: Mapping[str, Array]) -> S:
    """A solver with these arguments and parameters."""
    solver = kind(**arguments)
    for name, value in parameters.items():
        solver.parameters[name] = value
    return solver
