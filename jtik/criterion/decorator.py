"""The decorator ``@jtik.criterion``: a function as a criterion."""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from typing import Any, Literal, overload

from jtik.arguments import flag, positive_number
from jtik.criterion.function_criterion import FunctionCriterion, ResidualFunctionCriterion
from jtik.criterion.numeric import DIFFERENCE_STEP, NumericCriterion
from jtik.errors import ArgumentError

__all__ = ["FunctionCriterion", "criterion"]


@overload
def criterion(function: Callable[..., Any]) -> FunctionCriterion: ...
@overload
def criterion(
    *, residual: Literal[False] = ..., numeric: Literal[False] = ...
) -> Callable[[Callable[..., Any]], FunctionCriterion]: ...
@overload
def criterion(*, residual: Literal[True]) -> Callable[[Callable[..., Any]], ResidualFunctionCriterion]: ...
@overload
def criterion(
    *, numeric: Literal[True], gradient: Callable[..., Any] | None = ..., step: float = ...
) -> Callable[[Callable[..., Any]], NumericCriterion]: ...
def criterion(
    function: Any = None,
    *,
    residual: bool = False,
    numeric: bool = False,
    gradient: Callable[..., Any] | None = None,
    step: float = DIFFERENCE_STEP,
) -> Any:
    """Make ``def f(q, robot, *, parameter=first_value): ...`` a criterion to be minimised.

    The function is called once, with symbols. It may use the operators, CasADi, `jtik.symbolic`, other criteria
    (``other(q, robot)``) and the functions of NumPy that have a symbolic form, such as ``numpy.sin`` and
    ``numpy.linalg.norm``. The error for another function names its replacement.

    With ``@jtik.criterion(residual=True)`` the function returns a vector r, and H = 1/2 |r|^2. A strategy that takes
    second derivatives uses the Gauss-Newton Hessian of such an H; see `ResidualCriterion`.

    With ``@jtik.criterion(numeric=True)`` it is ``f(q, *, parameter=first_value) -> float``, called with numbers in
    every step: whatever can be computed from q, by any library. See `NumericCriterion` for what that costs.

    Args:
        function: a function of q, the symbolic configuration (nq, 1), and of the robot, whose ``robot.position(q,
            frame)``, ``robot.pose`` and ``robot.jacobian`` give expressions. It returns one scalar expression. None
            for a decorator with the options.
        residual: whether the function returns r, a vector or a list of expressions, instead of H.
        numeric: whether the function takes q as numbers (nq,) and returns a number.
        gradient: of a numeric function, a function with the same arguments that returns dH/dv, (n,); None for central
            differences, which call the function 2 n times.
        step: step of these differences [rad] or [m]; larger for a function that is not exact to rounding.

    Raises:
        ArgumentError: when the signature is another, a parameter has no first value, or options exclude each other.

    Example:
        >>> @jtik.criterion
        ... def elbow_height(q, robot, *, height=1.0):
        ...     return (robot.position(q, "link2")[1] - height) ** 2
        >>> ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask("tip"), criteria=elbow_height)
        >>> ik.parameters["elbow_height.height"] = 0.5
    """
    flag("residual", residual, "whether the function returns r of H = 1/2 |r|^2")
    flag("numeric", numeric, "whether the function takes and returns numbers")
    if residual and numeric:
        raise ArgumentError("residual", residual, "False with numeric=True: a numeric function returns H")
    if not numeric and gradient is not None:
        raise ArgumentError("gradient", gradient, "None, or a function with numeric=True")
    if gradient is not None and (not callable(gradient) or isinstance(gradient, type)):
        raise ArgumentError("gradient", gradient, "a function with the arguments of the numeric function, or None")
    width = positive_number("step", step)

    def make(of: Any) -> FunctionCriterion:
        if numeric:
            return NumericCriterion(*_read(of, 1, "a function f(q, *, parameter=first_value, ...)"), gradient, width)
        made = ResidualFunctionCriterion if residual else FunctionCriterion
        return made(*_read(of, 2, "a function f(q, robot, *, parameter=first_value, ...)"))

    return make if function is None else make(function)


def _read(function: Any, arguments: int, accepted: str) -> tuple[Any, str, dict[str, Any]]:
    """The function, its name and its defaults. Raises ArgumentError for another signature than ``accepted``."""
    name = getattr(function, "__name__", None)
    if not callable(function) or not isinstance(name, str) or isinstance(function, type):
        raise ArgumentError("function", function, accepted)
    try:
        signature = inspect.signature(function)
    except ValueError:  # a function written in C
        raise ArgumentError("function", function, accepted) from None
    positional, defaults = 0, {}
    for parameter in signature.parameters.values():
        if parameter.kind is parameter.KEYWORD_ONLY and parameter.default is not parameter.empty:
            defaults[parameter.name] = parameter.default
        elif parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD):
            positional += 1
        else:
            raise ArgumentError(f"parameter {parameter.name!r} of {name}", parameter, accepted)
    if positional != arguments:
        raise ArgumentError(name, f"{positional} positional arguments", accepted)
    if getattr(sys.modules.get(function.__module__), name, None) is not function:
        # a function is pickled by the name it is found under, and that name will be the criterion's
        function.__qualname__ += "._function"
    return function, name, defaults
