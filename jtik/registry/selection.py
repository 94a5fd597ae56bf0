"""The strategy that a user's ``strategy=`` stands for: an object, a name, or a pair of names such as "newton+qp"."""

from __future__ import annotations

from dataclasses import fields, is_dataclass

from jtik.errors import ArgumentError, JtikError
from jtik.registry.decorators import secondaries, strategies
from jtik.strategy import SecondaryTerm, Strategy


def strategy_of(given: str | Strategy) -> Strategy:
    """The strategy object that ``given`` stands for.

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
            return strategy()
        term = secondaries[secondary]()
        if not _takes_secondary(strategy):
            raise ArgumentError("strategy", given, f"a strategy with a secondary term before '+', not {name!r}")
        return strategy(secondary=term)  # type: ignore[call-arg]
    if isinstance(given, type) and issubclass(given, Strategy):
        raise ArgumentError("strategy", f"the class {given.__name__}", f"an object of it, such as {given.__name__}()")
    names = f"one of the names {strategies.names()}, perhaps with + and one of {secondaries.names()}"
    raise ArgumentError("strategy", given, f"a jtik.Strategy or {names}")


def supporting_clearances() -> str:
    """Which registered strategies take clearances, as what an error would have accepted.

    Plugins that nobody asked for by name are not loaded for it, and not named.
    """
    loaded = strategies.loaded()
    terms = {name: term() for name, term in secondaries.loaded().items() if term().supports_clearances()}
    alone = [repr(name) for name, strategy in loaded.items() if strategy().supports_clearances()]
    pairs = [f"'{name}+{term}'" for term in terms for name in loaded if _pairs(loaded[name], terms[term])]
    return f"a strategy whose quadratic programs have rows for them: {', '.join([*alone, *pairs])}"


def _takes_secondary(strategy: type[Strategy]) -> bool:
    """Whether the strategy has an argument for its secondary term."""
    return is_dataclass(strategy) and any(field.name == "secondary" and field.init for field in fields(strategy))


def _pairs(strategy: type[Strategy], term: SecondaryTerm) -> bool:
    """Whether the pair takes clearances where the strategy alone does not."""
    if not _takes_secondary(strategy) or strategy().supports_clearances():
        return False
    try:
        return strategy(secondary=term).supports_clearances()  # type: ignore[call-arg]
    except JtikError:
        return False
