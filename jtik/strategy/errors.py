"""The error for a strategy that cannot be used."""

from __future__ import annotations

import traceback
from collections.abc import Mapping

from jtik.errors import JtikError
from jtik.symbolic import Expression


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


class KnownState(dict[str, Expression]):
    """The state of a strategy by name. A name that ``initial_state`` did not return raises StrategyError."""

    def __init__(self, state: Mapping[str, Expression], strategy: object) -> None:
        super().__init__(state)
        self._strategy = shown(strategy)

    def __missing__(self, name: str) -> Expression:
        known = f"one of the states that initial_state returns: {sorted(self)}"
        raise StrategyError(self._strategy, "state", f"has no entry {name!r}", known)


def shown(value: object) -> str:
    """``repr`` of a value, or its class where that fails."""
    try:
        return repr(value)
    except Exception:  # whatever a repr may raise, the error to report is another one
        return f"<{type(value).__name__}>"


def described(value: object) -> str:
    """A value as an error message shows it."""
    return "None" if value is None else f"{type(value).__name__} {shown(value)}"[:120]


def raised(error: Exception) -> str:
    """What was raised, with the line outside jtik's and CasADi's own code in which it happened."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [
        frame for frame in frames if not any(part in frame.filename for part in ("casadi", "numpy", "jtik/symbolic"))
    ]
    line = (own or frames)[-1]
    reason = (str(error).strip() or "no message").splitlines()[0]
    return f"raised {type(error).__name__}: {reason} in `{line.line}` (line {line.lineno} of {line.filename})"
