"""Functions of (q, robot) as criteria, as ``@jtik.criterion`` makes them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, overload

from numpy.typing import ArrayLike

from jtik.criterion.base import Criterion
from jtik.criterion.least_squares import ResidualCriterion
from jtik.criterion.short_repr import call_text
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot import Kinematics, Robot
from jtik.symbolic import Expression


class FunctionCriterion(Criterion):
    """A function as a criterion; made by ``@jtik.criterion``.

    Keyword-only arguments of the function are its live parameters, their defaults the first values.

    Args:
        function: the function f(q, robot, *, parameter=first_value).
        name: name of the criterion.
        defaults: first values of the parameters by name.
    """

    def __init__(self, function: Callable[..., Any], name: str, defaults: Mapping[str, ArrayLike]) -> None:
        self._function = function
        self._defaults = dict(defaults)
        self.name = name
        self.__doc__ = function.__doc__

    @overload
    def __call__(self, **parameters: Any) -> FunctionCriterion: ...
    @overload
    def __call__(self, q: Any, robot: Robot, **parameters: Any) -> Any: ...
    def __call__(self, q: Any = None, robot: Any = None, **parameters: Any) -> Any:
        """Without q: the same criterion with other first values. With ``(q, robot)``: its value.

        ``f(height=0.3)`` is a criterion whose height begins at 0.3. ``f(q, robot)`` is H as a float, and
        ``f(q, robot, height=0.3)`` is H with that height.

        Args:
            q: configuration (nq,), or an expression (nq, 1).
            robot: the robot.
            parameters: values of parameters by name.

        Raises:
            UnknownNameError: when the function has no parameter of that name.
            ArgumentError: when one of q and robot is missing, or a value cannot be used.
        """
        if q is not None or robot is not None:
            if q is None or robot is None:
                missing = "q" if q is None else "robot"
                accepted = f"{self.name}(q, robot) for the value, {self.name}(parameter=...) for other first values"
                raise ArgumentError(missing, "nothing", accepted)
            return super().__call__(q, robot, **parameters)
        unknown = sorted(set(parameters) - set(self._defaults))
        if unknown:
            raise UnknownNameError("parameter", unknown[0], self._defaults)
        return self.beginning_at({**self._defaults, **parameters})

    def beginning_at(self, defaults: Mapping[str, ArrayLike]) -> FunctionCriterion:
        """The same criterion with other first values of its parameters.

        Args:
            defaults: first values of the parameters by name.
        """
        return type(self)(self._function, self.name, defaults)

    def __repr__(self) -> str:
        return call_text(self.name, **self._defaults)

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """The keyword-only arguments."""
        return self._defaults

    def value(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The function at ``(q, robot)``."""
        return self._function(kinematics.q, kinematics.robot, **parameters)


class ResidualFunctionCriterion(ResidualCriterion, FunctionCriterion):
    """A function that returns the residual r of H = 1/2 |r|^2; made by ``@jtik.criterion(residual=True)``."""

    def residual(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> Expression:
        """The function at ``(q, robot)``."""
        return self._function(kinematics.q, kinematics.robot, **parameters)
