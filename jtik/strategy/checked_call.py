"""A method of a strategy, called and checked: what it returns, or a StrategyError that says what to change."""

from __future__ import annotations

import math
import traceback
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from jtik import arguments
from jtik.errors import ArgumentError, JtikError, UnknownNameError
from jtik.strategy.errors import StrategyError, described, raised, shown
from jtik.symbolic import MX, SX, Expression, is_symbolic, no_silent_float, numbers, symvar, vec, vertcat

T = TypeVar("T")

_TRACEABLE = "CasADi operations on the expressions that the method is given, such as those of jtik.symbolic"

_ENGINE = [str(Path(__file__).parents[1] / room) for room in ("qp", "robot", "strategy", "symbolic")]
"""Folders whose errors are about what the strategy gave to them, not about what the user gave to the strategy."""


class CheckedCall:
    """One method of a strategy or of a part of it, called and checked.

    The checks of values return numbers as they are, and everything else as an expression.

    Args:
        strategy: the strategy that is built.
        owner: the object that has the method: the strategy, or a part of it.
        method: name of the method.
    """

    def __init__(self, strategy: object, owner: object, method: str) -> None:
        self.strategy, self._owner, self._method = shown(strategy), owner, method
        self.name = f"{type(owner).__name__}.{method}"

    def __call__(self, expected: type[T], *arguments: Any) -> T:
        """What the method returns for these arguments.

        Raises:
            StrategyError: when it raises, or returns something else than ``expected``.
        """
        return self.instance("", self._returned(*arguments), expected)

    def flag(self, *arguments: Any) -> bool:
        """What the method returns, True or False. Raises StrategyError when it raises or returns something else."""
        returned = self._returned(*arguments)
        if type(returned).__name__ not in ("bool", "bool_"):  # Python's and NumPy's
            raise self.error(f"returned {described(returned)}", "True or False")
        return bool(returned)

    def choice(self, choices: tuple[str, ...]) -> str:
        """What the method returns, one of ``choices``. Raises StrategyError when it raises or returns another."""
        returned = self._returned()
        if not isinstance(returned, str) or returned not in choices:
            raise self.error(f"returned {described(returned)}", " or ".join(map(repr, choices)))
        return returned

    def optional_part(self, kinds: tuple[type, ...]) -> Any:
        """What the method returns, None or an object of one of ``kinds``. Raises StrategyError otherwise."""
        returned = self._returned()
        if returned is not None and not isinstance(returned, kinds):
            raise self.error(
                f"returned {described(returned)}", f"{' or '.join(kind.__name__ for kind in kinds)}, or None"
            )
        return returned

    def states(self, before: Mapping[str, Expression], *arguments: Any) -> dict[str, Expression]:
        """What the method returns, entries of the state. Raises StrategyError as `state`."""
        return self.state("", self._returned(*arguments), before)

    def error(self, returned: str, expected: str) -> StrategyError:
        """The error to raise for what was returned."""
        return StrategyError(self.strategy, self.name, returned, expected)

    def instance(self, what: str, value: Any, expected: type[T]) -> T:
        """The value. Raises StrategyError unless it is an ``expected``; ``what`` names a part of what was returned."""
        if not isinstance(value, expected):
            name = expected.__name__
            accepted = f"{'an' if name[0] in 'AEIOU' else 'a'} {name}"
            raise self.error(f"returned {f'{what} = ' if what else ''}{described(value)}", accepted)
        return value

    def displacement(self, what: str, value: Any, n: int) -> Expression:
        """The value as an expression of shape (n, 1). Raises StrategyError as `column`, and for a NaN or infinity."""
        column = self.column(what, value, n)
        for i in range(n):
            entry = numbers(column[i])
            if entry is not None and not math.isfinite(entry[0, 0]):
                raise self.error(f"returned {what} with entry {i} = {entry[0, 0]}", "finite entries")
        return column

    def column(self, what: str, value: Any, rows: int) -> Expression:
        """The value as an expression of shape (rows, 1), or a number if one is enough.

        Raises:
            StrategyError: when it is no expression of SX and no number, or has another shape.
        """
        if rows == 1 and isinstance(value, (int, float)):
            return value
        expected = f"{what} as a scalar expression" if rows == 1 else f"{what} as an expression of shape ({rows}, 1)"
        if isinstance(value, MX):
            raise self.error(f"returned {what} of type MX", f"{expected}, of CasADi's type SX")
        if not is_symbolic(value):
            try:
                value = SX(value)
            except (NotImplementedError, TypeError, ValueError):
                raise self.error(f"returned {what} = {described(value)}", expected) from None
        if value.shape != (rows, 1):
            raise self.error(f"returned {what} of shape {value.shape}", expected)
        return value

    def optional(self, what: str, value: Any, rows: int = 1) -> Expression:
        """None, or the value as `column`."""
        return None if value is None else self.column(what, value, rows)

    def figures(self, what: str, given: Any) -> dict[str, Expression]:
        """Scalars by name. Raises StrategyError for anything else."""
        for name in self.instance(what, given, Mapping):  # type: ignore[type-abstract]
            if not isinstance(name, str) or not name:
                raise self.error(f"returned {what} with the name {described(name)}", "names that are texts")
        return {name: self.column(f"figure {name!r}", value, 1) for name, value in given.items()}

    def relaxed(self, what: str, given: Any) -> dict[tuple[str, str], Expression]:
        """Scalars by name and unit. Raises StrategyError for anything else."""
        for key in self.instance(what, given, Mapping):  # type: ignore[type-abstract]
            if not (isinstance(key, tuple) and len(key) == 2 and all(isinstance(part, str) for part in key)):
                raise self.error(f"returned {what} with the key {described(key)}", "keys (name, unit), two texts each")
        return {
            (name, unit): self.column(f"{what}[{name!r}, {unit!r}]", value, 1) for (name, unit), value in given.items()
        }

    def state(self, what: str, given: Any, before: Mapping[str, Expression]) -> dict[str, Expression]:
        """Some entries of the state, with the sizes that they had. Raises StrategyError for anything else."""
        for name in self.instance(what, given, Mapping):  # type: ignore[type-abstract]
            if name not in before:
                known = f"states that initial_state returns: {sorted(before)}"
                raise self.error(f"returned a state with the name {described(name)}", known)
        return {name: self.column(f"state {name!r}", value, before[name].shape[0]) for name, value in given.items()}

    def own_symbols(self, values: Mapping[str, Expression], known: list[Expression]) -> None:
        """Raise StrategyError where a value depends on symbols that are not among ``known``."""
        own = _symbols(known)
        if not _symbols(values.values()) - own:
            return
        for what, value in values.items():
            foreign = [str(symbol) for symbol in symvar(SX(value)) if symbol.element_hash() not in own]
            if foreign:
                given = f"returned {what} that depends on symbols of something else: {', '.join(foreign)}"
                raise self.error(given, "expressions of the model and the state that the method is given")

    def _returned(self, *arguments: Any) -> Any:
        """What the method returns, whatever it is."""
        try:
            method = getattr(self._owner, self._method)
            with no_silent_float():
                return method(*arguments)
        except (ArgumentError, UnknownNameError) as error:
            if _about_strategy(error):
                raise StrategyError(self.strategy, self.name, raised(error), _TRACEABLE) from error
            raise
        except JtikError as error:
            if type(error) is JtikError:
                raise StrategyError(self.strategy, self.name, raised(error), _TRACEABLE) from error
            raise
        except Exception as error:
            raise StrategyError(self.strategy, self.name, raised(error), _TRACEABLE) from error


def _symbols(values: Iterable[Expression]) -> set[int]:
    """Identities of the symbols that the values depend on."""
    return {symbol.element_hash() for symbol in symvar(vertcat(*[vec(SX(value)) for value in values]))}


def _about_strategy(error: Exception) -> bool:
    """Whether an error is about what a strategy gave to the engine."""
    files = [frame.filename for frame in traceback.extract_tb(error.__traceback__)]
    file = next((each for each in reversed(files) if each != arguments.__file__), "")  # which uses the readers
    return file.startswith(tuple(_ENGINE)) and not file.endswith("options.py")
