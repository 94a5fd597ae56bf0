"""Values that a function of scalar operations needs only where a condition holds, in generated C behind that condition.

CasADi evaluates both sides of every condition: ``a9=(a7?a8:0);`` comes after all that ``a8`` is computed from. Where
that is much, such as a test that only the end of a solve needs, and nothing else needs it, it becomes a branch here.
What is computed stays the same, and so do all bits.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import NamedTuple

FEWEST = 64
"""Statements behind a condition from which on they are a branch: a branch that is predicted wrongly takes as long."""

_SELECTED = re.compile(r"^  a\d+=\(a\d+\?a\d+:0\);$")
_VARIABLE = re.compile(r"\ba\d+\b")
_ORDERED = re.compile(r"\b(?:w|arg|res)\d*\[|\bcasadi_f\d+\(")
"""What has its place among the calls of other functions."""


class Statement(NamedTuple):
    """A statement of scalar operations. A value has the number of the statement that assigns it.

    Attributes:
        text: the text.
        assigns: whether it assigns a variable.
        used: the values that it needs, in the order of its text.
    """

    text: str
    assigns: bool
    used: Sequence[int]


class Branch(NamedTuple):
    """Statements that only the selection of a value needs.

    Attributes:
        selection: number of the statement that selects.
        inside: numbers of the statements.
    """

    selection: int
    inside: frozenset[int]


def with_branches(statements: Sequence[Statement], fewest: int = FEWEST) -> str | None:
    """The text of a function with branches, each value a constant of its own; None where there is no branch.

    Args:
        statements: the statements.
        fewest: fewest statements of a branch.
    """
    branches = _branches(statements, fewest)
    if not branches:
        return None
    of_selection = {branch.selection: sorted(branch.inside) for branch in branches}
    moved, written = frozenset[int]().union(*(branch.inside for branch in branches)), list[str]()
    for at, statement in enumerate(statements):
        if at in of_selection:
            condition, value = statement.used
            written.append(f"  casadi_real v{at}=0;\n  if (v{condition}) {{")
            written += [_renamed(statements[k], k) for k in of_selection[at]]
            written.append(f"  v{at}=v{value};\n  }}")
        elif at not in moved:
            written.append(_renamed(statement, at))
    return "\n".join(written)


def _renamed(statement: Statement, at: int) -> str:
    """A statement in which each value has a name of its own."""
    assigned = [f"const casadi_real v{at}"] if statement.assigns else []
    names = iter([*assigned, *(f"v{each}" for each in statement.used)])
    return _VARIABLE.sub(lambda match: next(names), statement.text)


def _branches(statements: Sequence[Statement], fewest: int) -> list[Branch]:
    """Branches that have no statement in common, the largest first."""
    users = list[list[int]]([] for _ in statements)
    for at, statement in enumerate(statements):
        for value in statement.used:
            users[value].append(at)
    selections = [at for at, each in enumerate(statements) if _SELECTED.match(each.text)]
    found = [Branch(at, _only_for(at, statements, users)) for at in selections]
    chosen, taken = list[Branch](), set[int]()
    for branch in sorted(found, key=lambda each: len(each.inside), reverse=True):
        if len(branch.inside) < fewest:
            break
        if not taken & {branch.selection, *branch.inside}:
            chosen.append(branch)
            taken |= {branch.selection, *branch.inside}
    return chosen


def _only_for(selection: int, statements: Sequence[Statement], users: Sequence[Sequence[int]]) -> frozenset[int]:
    """The statements that only the value which a statement selects is computed from."""
    condition, value = statements[selection].used
    inside, waiting = set[int](), {value} - {condition}
    while waiting:
        at = max(waiting)  # whoever uses it comes later, and is known to be inside or not
        waiting.discard(at)
        if _ORDERED.search(statements[at].text) or not all(user == selection or user in inside for user in users[at]):
            continue
        inside.add(at)
        waiting |= set(statements[at].used) - inside - {condition}
    return frozenset(inside)
