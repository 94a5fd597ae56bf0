"""The decorator ``@jtik.criterion``: a function of (q, robot) as a criterion."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable, Mapping
from typing import Any, Literal, overload

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
        return type(self)(self._function, self.name, {**self._defaults, **parameters})

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


@overload
def criterion(function: Callable[..., Any]) -> FunctionCriterion: ...
@overload
def criterion(*, residual: Literal[False] = ...) -> Callable[[Callable[..., Any]], FunctionCriterion]: ...
@overload
def criterion(*, residual: Literal[True]) -> Callable[[Callable[..., Any]], ResidualFunctionCriterion]: ...
def criterion(function: Any = None, *, residual: bool = False) -> Any:
    """Make ``def f(q, robot, *, parameter=first_value): ...`` a criterion to be minimised.

    The function is called once, with symbols. It may use the operators, CasADi, `jtik.symbolic`, other criteria
    (``other(q, robot)``) and the functions of NumPy that have a symbolic form, such as ``numpy.sin`` and
    ``numpy.linalg.norm``. The error for another function names its replacement.

    With ``@jtik.criterion(residual=True)`` the function returns a vector r, and H = 1/2 |r|^2. A strategy that takes
    second derivatives uses the Gauss-Newton Hessian of such an H; see `ResidualCriterion`.

    Args:
        function: a function of q, the symbolic configuration (nq, 1), and of the robot, whose ``robot.position(q,
            frame)``, ``robot.pose`` and ``robot.jacobian`` give expressions. It returns one scalar expression.
        residual: whether the function returns r, a vector or a list of expressions, instead of H.

    Raises:
        ArgumentError: when the signature is another, or a parameter has no first value.
    """
    if not isinstance(residual, bool):
        raise ArgumentError("residual", residual, "True or False: whether the function returns r of H = 1/2 |r|^2")
    made = ResidualFunctionCriterion if residual else FunctionCriterion
    if function is None:
        return lambda of: _made(of, made)
    return _made(function, made)


def _made(function: Any, made: type[FunctionCriterion]) -> FunctionCriterion:
    """The function as a criterion of that class. Raises ArgumentError for another signature."""
    accepted = "a function f(q, robot, *, parameter=first_value, ...)"
    name = getattr(function, "__name__", None)
    if not callable(function) or not isinstance(name, str):
        raise ArgumentError("function", function, accepted)
    positional, defaults = 0, {}
    for parameter in inspect.signature(function).parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and parameter.default is not parameter.empty:
            defaults[parameter.name] = parameter.default
        elif parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD):
            positional += 1
        else:
            raise ArgumentError(f"parameter {parameter.name!r} of {name}", parameter, accepted)
    if positional != 2:
        raise ArgumentError(name, f"{positional} positional arguments", accepted)
    if getattr(sys.modules.get(function.__module__), name, None) is not function:
        # a function is pickled by the name it is found under, and that name will be the criterion's
        function.__qualname__ += "._function"
    return made(function, name, defaults)
