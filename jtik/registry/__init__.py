"""Registered strategies, criteria and secondary terms, by name: built in, of third parties, and your own.

``jtik.strategies``, ``jtik.criteria`` and ``jtik.secondaries`` are mappings from name to class. Each shows itself as a
table of name, summary and source.

- ``jtik.strategies``: ``strategy="hybrid"`` stands for ``jtik.strategies["hybrid"]()``.
- ``jtik.criteria``: names for the command line, for problem files and for studies.
- ``jtik.secondaries``: null-space terms; ``strategy="newton+qp"`` pairs the strategy "newton" with the term "qp".

Register a class of your own with `register_strategy`, `register_criterion` or `register_secondary`. A distribution
names its classes in the entry-point groups ``jtik.strategies``, ``jtik.criteria`` and ``jtik.secondaries``.
"""

from jtik.registry.citation import citations
from jtik.registry.decorators import (
    criteria,
    register_criterion,
    register_secondary,
    register_strategy,
    secondaries,
    strategies,
)
from jtik.registry.mapping import Registry
from jtik.registry.plugins import PluginError
from jtik.registry.strategy_argument import secondary_of, strategy_of, supporting_clearances

__all__ = [
    "PluginError",
    "Registry",
    "citations",
    "criteria",
    "register_criterion",
    "register_secondary",
    "register_strategy",
    "secondaries",
    "secondary_of",
    "strategies",
    "strategy_of",
    "supporting_clearances",
]
