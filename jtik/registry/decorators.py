"""The three registries, and the decorators that add a class to one."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from jtik.criterion.base import Criterion
from jtik.registry.mapping import Registry
from jtik.strategy import SecondaryTerm, Strategy

strategies: Registry[Strategy] = Registry("strategy", Strategy, "jtik.strategies", ("strategies.{}",))
"""All registered strategies by name."""

criteria: Registry[Criterion] = Registry("criterion", Criterion, "jtik.criteria", ("criteria.{}",))
"""All registered criteria by name."""

secondaries: Registry[SecondaryTerm] = Registry(
    "secondary term", SecondaryTerm, "jtik.secondaries", ("strategies.{}", "strategies.{}_secondary")
)
"""All registered null-space terms by name; ``strategy="newton+qp"`` pairs one with a strategy."""

S = TypeVar("S", bound=type[Strategy])
N = TypeVar("N", bound=type[SecondaryTerm])
C = TypeVar("C", bound=type[Criterion])


def register_strategy(name: str) -> Callable[[S], S]:
    """Class decorator: make a Strategy available as ``strategy="name"``.

    The same class again (a notebook cell that is run twice) replaces the former one.

    Args:
        name: the name; ``+`` is for pairs with a secondary term and cannot be part of it.

    Raises:
        ArgumentError: when another class has the name, or what is decorated is no Strategy.
    """
    return strategies.register(name)


def register_secondary(name: str) -> Callable[[N], N]:
    """Class decorator: make a SecondaryTerm available as ``strategy="newton+name"``.

    The same class again (a notebook cell that is run twice) replaces the former one.

    Args:
        name: the name.

    Raises:
        ArgumentError: when another class has the name, or what is decorated is no SecondaryTerm.
    """
    return secondaries.register(name)


def register_criterion(name: str) -> Callable[[C], C]:
    """Class decorator: make a Criterion known by name, for the command line and for studies.

    The same class again (a notebook cell that is run twice) replaces the former one.

    Args:
        name: the name.

    Raises:
        ArgumentError: when another class has the name, or what is decorated is no Criterion.
    """
    return criteria.register(name)
