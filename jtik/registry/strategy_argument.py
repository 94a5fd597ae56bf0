"""The strategy for a user's argument ``strategy=``: an object, a name, or a pair of names such as "newton+qp"."""

from __future__ import annotations

import inspect
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

from jtik.criterion.criteria_argument import required_arguments
from jtik.errors import ArgumentError
from jtik.registry.decorators import secondaries, strategies
from jtik.strategy import SecondaryTerm, Strategy

T = TypeVar("T")


def strategy_of(given: str | Strategy) -> Strategy:
    """The strategy object for the argument ``given``.

    Args:
        given: a Strategy; a registered name, for that strategy with its defaults; or ``"name+term"``, for that strategy
            with a registered secondary term.

    Raises:
        UnknownNameError: when no strategy or no secondary term has the name.
        PluginError: when the name is a third party's and its plugin cannot be loaded.
        ArgumentError: when ``given`` is something else, or the strategy takes no secondary term.
    """
    if isinstance(given, Strategy):
        return given
    if isinstance(given, str):
        name, plus, secondary = given.partition("+")
        strategy = strategies[name]
        if not plus:
            return _with_defaults("strategy", f"strategies[{name!r}]", strategy)
        term = secondary_of("strategy", secondary)
        if not _takes_secondary(strategy):
            raise ArgumentError("strategy", given, f"a strategy with a secondary term before '+', not {name!r}")
        return strategy(secondary=term)  # type: ignore[call-arg]
    names = f"a jtik.Strategy or one of the names {strategies.names()}, perhaps with + and one of {secondaries.names()}"
    if isinstance(given, type) and issubclass(given, Strategy):
        raise ArgumentError(
            "strategy", f"the class {given.__name__}", f"an object of it, {given.__name__}(); or {names}"
        )
    raise ArgumentError("strategy", given, names)


def secondary_of(argument: str, name: str) -> SecondaryTerm:
    """The registered secondary term ``name`` with its defaults.

    Args:
        argument: name of the argument, for errors.
        name: registered name of the term.

    Raises:
        UnknownNameError: when no secondary term has the name.
        PluginError: when the name is a third party's and its plugin cannot be loaded.
        ArgumentError: when its class needs arguments, naming ``argument``.
    """
    return _with_defaults(argument, f"secondaries[{name!r}]", secondaries[name])


def supporting_clearances() -> str:
    """The registered strategies that support clearances, as a text for the error of one that does not.

    Plugins that have not been looked up by name are not loaded, and not listed.
    """
    loaded = strategies.loaded()
    terms = {name: term() for name, term in secondaries.loaded().items() if _supports(term)}
    alone = [repr(name) for name, strategy in loaded.items() if _supports(strategy)]
    pairs = [f"'{name}+{term}'" for term in terms for name in loaded if _pairs(loaded[name], terms[term])]
    return f"a strategy whose quadratic programs have rows for them: {', '.join([*alone, *pairs])}"


def _takes_secondary(strategy: type[Strategy]) -> bool:
    """Whether the strategy has an argument for its secondary term."""
    return is_dataclass(strategy) and any(field.name == "secondary" and field.init for field in fields(strategy))


def _pairs(strategy: type[Strategy], term: SecondaryTerm) -> bool:
    """Whether the pair takes clearances where the strategy alone does not."""
    return _takes_secondary(strategy) and not _supports(strategy) and _supports(strategy, secondary=term)


def _supports(plugin: type[Strategy] | type[SecondaryTerm], **options: Any) -> bool:
    """Whether an object of the class supports clearances; False if none can be constructed."""
    try:
        return bool(plugin(**options).supports_clearances())
    except Exception:  # a class of a third party may raise anything
        return False


def _with_defaults(argument: str, name: str, plugin: type[T]) -> T:
    """An object of the registered class ``name``. Raises ArgumentError if it needs arguments."""
    if inspect.isabstract(plugin):
        methods = " and ".join(sorted(plugin.__abstractmethods__))  # type: ignore[attr-defined]
        raise ArgumentError(argument, f"{plugin.__name__}, which is abstract", f"a class that defines {methods}")
    missing = required_arguments(plugin)
    if missing:
        call = f"({', '.join(f'{argument}=...' for argument in missing)})"
        accepted = f"an object: jtik.{name}{call}, that is {plugin.__name__}{call}"
        raise ArgumentError(argument, f"{plugin.__name__}, which needs {' and '.join(missing)}", accepted)
    return plugin()
