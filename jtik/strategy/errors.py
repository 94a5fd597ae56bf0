"""The error for a strategy that cannot be used, and the checks of what its methods return."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Mapping
from typing import Any, TypeVar

from jtik.errors import JtikError
from jtik.symbolic import SX, Expression, is_symbolic, no_silent_float

T = TypeVar("T")


class StrategyError(JtikError):
    """A strategy that cannot be used: a method returns what the engine cannot work with, or raises.

    Attributes:
        strategy: the strategy, as text.
        method: the method at fault, such as "DampedStep.propose".
        returned: what it returned, or what it raised and where.
        expected: what would have been accepted.
    """

    def __init__(self, strategy: str, method: str, returned: str, expected: str) -> None:
        super().__init__(strategy, method, returned, expected)
        self.strategy = strategy
        self.method = method
        self.returned = returned
        self.expected = expected

    def __str__(self) -> str:
        return f"strategy {self.strategy}: {self.method} {self.returned}; accepted: {self.expected}"


class CheckedCall:
    """One method of a strategy or of a part of it, called and checked.

    Args:
        strategy: the strategy that is built.
        method: the bound method.
    """

    def __init__(self, strategy: object, method: Callable[..., Any]) -> None:
        self.strategy, self._method = repr(strategy), method
        self.name = f"{type(getattr(method, '__self__', strategy)).__name__}.{method.__name__}"

    def __call__(self, expected: type[T], *arguments: Any) -> T:
        """What the method returns for these arguments.

        Raises:
            StrategyError: when it raises, or returns something else than ``expected``.
        """
        try:
            with no_silent_float():
                returned = self._method(*arguments)
        except JtikError:
            raise
        except Exception as error:
            raise StrategyError(self.strategy, self.name, _raised(error), _TRACEABLE) from error
        if not isinstance(returned, expected):
            raise self.error(f"returned {_what(returned)}", _article(expected.__name__))
        return returned

    def error(self, returned: str, expected: str) -> StrategyError:
        """The error to raise for what was returned."""
        return StrategyError(self.strategy, self.name, returned, expected)

    def column(self, what: str, value: Any, rows: int) -> Expression:
        """``value`` as an expression of shape (rows, 1).

        Raises:
            StrategyError: when it is no expression and no number, or has another shape.
        """
        expected = f"{what} as a scalar expression" if rows == 1 else f"{what} as an expression of shape ({rows}, 1)"
        if not is_symbolic(value):
            try:
                value = SX(value)
            except (NotImplementedError, TypeError, ValueError):
                raise self.error(f"returned {what} = {_what(value)}", expected) from None
        if value.shape != (rows, 1):
            raise self.error(f"returned {what} of shape {value.shape}", expected)
        return value


_TRACEABLE = "CasADi operations on the expressions that the method is given, such as those of jtik.symbolic"


class KnownState(dict[str, Expression]):
    """The state of a strategy by name. A name that ``initial_state`` did not return raises StrategyError."""

    def __init__(self, state: Mapping[str, Expression], strategy: object) -> None:
        super().__init__(state)
        self._strategy = repr(strategy)

    def __missing__(self, name: str) -> Expression:
        known = f"one of the states that initial_state returns: {sorted(self)}"
        raise StrategyError(self._strategy, "state", f"has no entry {name!r}", known)


def _what(value: object) -> str:
    """A value as an error message shows it."""
    return "None" if value is None else f"{type(value).__name__} {value!r}"[:120]


def _raised(error: Exception) -> str:
    """What was raised, with the line outside jtik's and CasADi's own code in which it happened."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [
        frame for frame in frames if not any(part in frame.filename for part in ("casadi", "numpy", "jtik/symbolic"))
    ]
    line = (own or frames)[-1]
    reason = (str(error).strip() or "no message").splitlines()[0]
    return f"raised {type(error).__name__}: {reason} in `{line.line}` (line {line.lineno} of {line.filename})"


def _article(name: str) -> str:
    """The name of a class with its article."""
    return f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
