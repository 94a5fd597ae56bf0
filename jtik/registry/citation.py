"""The sources of what a solver or a study uses, as BibTeX."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

from jtik.criterion import Criterion, CriterionSum
from jtik.errors import ArgumentError, UnknownNameError
from jtik.registry.decorators import criteria, secondaries, strategies
from jtik.registry.strategy_argument import strategy_of
from jtik.strategy import Composition, Programmed, SecondaryTerm, Strategy

_KEY = re.compile(r"^@\w+\{([^,\s]+),", re.MULTILINE)


class Citations(str):
    """BibTeX entries as text, which a notebook or a prompt shows as it is."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def citations(of: Any) -> Citations:
    """The BibTeX entries of the sources of what is used, each once: strategy, secondary term, criteria.

    The secondary term counts where there is a criterion or a clearance: without one it does nothing. What has a source
    and no BibTeX entry, or neither, is a comment.

    Args:
        of: a `jtik.InverseKinematics`, a Strategy, a SecondaryTerm, a Criterion or a weighted sum; or a registered
            name, such as "hybrid", "hybrid+qp", "second_order" or "joint_centering".

    Raises:
        ArgumentError: for anything else.
        UnknownNameError: when nothing is registered under the name.

    Example:
        >>> print(jtik.citations("hybrid").splitlines()[0])
        @inproceedings{das1988,
    """
    return Citations("\n\n".join(_entries(_used(of))))


def entries_of(solvers: Iterable[Any], criteria_of_each: Iterable[CriterionSum], *, clearances: bool) -> list[str]:
    """The entries of what a study uses.

    Args:
        solvers: strategies, and what is not jtik's with a ``bibtex`` or without one.
        criteria_of_each: the sets of criteria.
        clearances: whether there are clearances.
    """
    used = [criterion for each in criteria_of_each for _, criterion in each.terms]
    secondary, parts = bool(used) or clearances, list[Any]()
    for each in solvers:
        parts += _parts(each, secondary=secondary) if isinstance(each, Strategy) else [each]
    return _entries([*parts, *used])


def _used(of: Any) -> list[Any]:
    """The objects whose sources are cited."""
    if isinstance(of, str):
        return _named(of)
    if isinstance(of, Strategy):
        return _parts(of, secondary=True)
    if isinstance(of, SecondaryTerm | Criterion):
        return [of]
    if isinstance(of, CriterionSum):
        return [criterion for _, criterion in of.terms]
    engine = getattr(of, "_engine", None)
    if engine is None:
        accepted = "a jtik.InverseKinematics, a strategy, a secondary term, a criterion, a sum, or a registered name"
        raise ArgumentError("of", of, accepted)
    problem = engine.problem
    secondary = problem.has_criterion or bool(problem.clearances)
    return [*_parts(of.strategy, secondary=secondary), *[criterion for _, _, criterion in problem.terms.named]]


def _named(name: str) -> list[Any]:
    """What is registered under a name; a strategy with its secondary term only where the name has a ``+``."""
    if "+" in name:
        return _parts(strategy_of(name), secondary=True)
    for registry in (strategies, secondaries, criteria):
        if name in registry.names():
            return [registry[name]]
    known = [*strategies.names(), *secondaries.names(), *criteria.names()]
    raise UnknownNameError("strategy, secondary term or criterion", name, known)


def _parts(strategy: Strategy, *, secondary: bool) -> list[Any]:
    """A strategy and, where it is used, its secondary term."""
    term = strategy.secondary_term() if isinstance(strategy, Composition | Programmed) else None
    return [strategy, term] if secondary and term is not None else [strategy]


def _entries(used: Iterable[Any]) -> list[str]:
    """The entries of these objects or classes, each key once; a comment for what has none."""
    found: dict[str, str] = {}
    for each in used:
        kind = each if isinstance(each, type) else type(each)
        name = getattr(each, "name", "") or getattr(each, "label", "") or kind.__name__
        text = str(getattr(each, "bibtex", "")).strip()
        entries = [entry.strip() for entry in re.split(r"\n(?=@)", text)] if text else []
        if not entries:
            source = getattr(each, "source", "")
            found.setdefault(f"% {name}", f"% {name}: {source or 'no source'}")
        for entry in entries:
            key = _KEY.match(entry)
            found.setdefault(key.group(1) if key else entry, entry)
    return list(found.values())
