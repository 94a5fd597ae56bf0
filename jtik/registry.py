"""Names to plugins: the strategies and criteria that come with jtik, and those of third parties.

Built-ins register by decorator when their package is first needed; third parties name theirs in the entry-point groups
``jtik.strategies`` and ``jtik.criteria`` of their own distribution.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, TypeVar

from jtik.criterion.base import Criterion
from jtik.errors import ArgumentError, JtikError, UnknownNameError
from jtik.strategy import SecondaryTerm, Strategy

_BUILT_IN = "jtik_formulations"

T = TypeVar("T")


class PluginError(JtikError):
    """A plugin that could not be loaded. Attributes: plugin, distribution, reason."""

    def __init__(self, plugin: str, distribution: str, reason: str) -> None:
        super().__init__(plugin, distribution, reason)
        self.plugin = plugin
        self.distribution = distribution
        self.reason = reason

    def __str__(self) -> str:
        return f"plugin {self.plugin!r} of distribution {self.distribution!r} could not be loaded: {self.reason}"


class Registry(Mapping[str, type[T]], Generic[T]):
    """A mapping from name to class. Plugins load when it is first read."""

    def __init__(self, kind: str, base: type, group: str) -> None:
        self._kind = kind
        self._base: type[Any] = base
        self._group = group
        self._classes: dict[str, type[T]] = {}
        self._loaded = False

    def add(self, name: str, plugin: type[T]) -> None:
        """Register a class. Raises ArgumentError for a duplicate name or a class of another kind."""
        if not (isinstance(plugin, type) and issubclass(plugin, self._base)):
            raise ArgumentError(name, plugin, f"a subclass of {self._base.__name__}")
        if name in self._classes and self._classes[name] is not plugin:
            known = self._classes[name]
            raise ArgumentError(
                f"{self._kind} name", name, f"a name not yet taken by {known.__module__}.{known.__qualname__}"
            )
        self._classes[name] = plugin
        if not vars(plugin).get("name"):
            plugin.name = name  # type: ignore[attr-defined]

    def _load(self) -> None:
        if self._loaded:
            return
        importlib.import_module(_BUILT_IN)
        for entry in entry_points(group=self._group):
            self._add_entry(entry)
        self._loaded = True

    def _add_entry(self, entry: EntryPoint) -> None:
        """Load and add a third party's class; whatever goes wrong is told with the distribution it came from."""
        try:
            self.add(entry.name, entry.load())
        except Exception as error:
            distribution = entry.dist.name if entry.dist else "unknown"
            raise PluginError(entry.name, distribution, f"{type(error).__name__}: {error}") from error

    def __getitem__(self, name: str) -> type[T]:
        self._load()
        if name not in self._classes:
            raise UnknownNameError(self._kind, name, self._classes)
        return self._classes[name]

    def __iter__(self) -> Iterator[str]:
        self._load()
        return iter(sorted(self._classes))

    def __len__(self) -> int:
        self._load()
        return len(self._classes)


strategies: Registry[Strategy] = Registry("strategy", Strategy, "jtik.strategies")
"""All registered strategies by name."""

criteria: Registry[Criterion] = Registry("criterion", Criterion, "jtik.criteria")
"""All registered criteria by name."""

secondaries: Registry[SecondaryTerm] = Registry("secondary term", SecondaryTerm, "jtik.secondaries")
"""All registered null-space terms by name; ``strategy="newton+qp"`` pairs one with a strategy."""

S = TypeVar("S", bound=type[Strategy])
N = TypeVar("N", bound=type[SecondaryTerm])
C = TypeVar("C", bound=type[Criterion])


def register_strategy(name: str) -> Callable[[S], S]:
    """Class decorator: make a Strategy available as ``strategy="name"``."""

    def register(plugin: S) -> S:
        strategies.add(name, plugin)
        return plugin

    return register


def register_secondary(name: str) -> Callable[[N], N]:
    """Class decorator: make a SecondaryTerm available as ``strategy="newton+name"``."""

    def register(plugin: N) -> N:
        secondaries.add(name, plugin)
        return plugin

    return register


def register_criterion(name: str) -> Callable[[C], C]:
    """Class decorator: make a Criterion known by name, for the command line and for studies."""

    def register(plugin: C) -> C:
        criteria.add(name, plugin)
        return plugin

    return register


def strategy_of(given: str | Strategy) -> Strategy:
    """The strategy object a name stands for. Raises UnknownNameError or ArgumentError."""
    if isinstance(given, Strategy):
        return given
    if isinstance(given, str):
        name, plus, secondary = given.partition("+")
        law = strategies[name]
        if not plus:
            return law()
        term = secondaries[secondary]()
        if "secondary" not in {field.name for field in fields(law) if field.init}:  # type: ignore[arg-type]
            raise ArgumentError("strategy", given, f"a strategy with a secondary term before '+', not {name!r}")
        return law(secondary=term)  # type: ignore[call-arg]
    names = f"one of the names {sorted(strategies)}, perhaps with + and one of {sorted(secondaries)}"
    raise ArgumentError("strategy", given, f"a jtik.Strategy or {names}")


def supporting_clearances() -> str:
    """Which registered strategies take clearances, as what an error would have accepted."""
    terms = {name: term() for name, term in secondaries.items() if term().supports_clearances()}
    alone = [repr(name) for name, law in strategies.items() if law().supports_clearances()]
    pairs = [f"'{name}+{term}'" for term in terms for name in strategies if _pairs(name, terms[term])]
    return f"a strategy whose programs have rows for them: {', '.join([*alone, *pairs])}"


def _pairs(name: str, term: SecondaryTerm) -> bool:
    """Whether the pair takes clearances where the strategy alone does not."""
    law = strategies[name]
    if "secondary" not in {field.name for field in fields(law) if field.init}:  # type: ignore[arg-type]
        return False
    if law().supports_clearances():
        return False
    try:
        return law(secondary=term).supports_clearances()  # type: ignore[call-arg]
    except JtikError:
        return False
