"""Constraints that a step may relax: their names and units, and the amounts as expressions of the step."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from jtik.result.relaxation import Relaxation
from jtik.symbolic import Expression, mmax, vertcat
from jtik.types import Array

if TYPE_CHECKING:
    from jtik._step.checked_update import CheckedUpdate
    from jtik._step.symbolic_problem import SymbolicProblem
    from jtik.qp.recorder import QPRecorder
    from jtik.strategy import FeasibilityRestoration

NEGLIGIBLE = 1e-6
"""Amounts up to this are within the tolerance of a QP solver and do not count as relaxed."""


@dataclass(frozen=True)
class RelaxationTerms:
    """Constraints of a step that may be relaxed.

    Attributes:
        entries: name and unit of each.
        figures: columns for the record of the step: the amounts as "relaxed", and figures of the trace.
    """

    entries: tuple[tuple[str, str], ...] = ()
    figures: Mapping[str, Expression] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        update: CheckedUpdate,
        qps: QPRecorder | None,
        restoration: FeasibilityRestoration | None,
        problem: SymbolicProblem,
    ) -> RelaxationTerms:
        """Constraints that the strategy names, clearances that stay too small, and elastic rows of its QPs."""
        entries, amounts, figures = [], list[Expression](), dict[str, Expression]()
        for (name, unit), amount in update.relaxed.items():
            entries.append((name, unit))
            amounts.append(amount)
        if restoration:
            entries += [(pair, "m") for pair in problem.measured.pairs]
            amounts.append(restoration.missing)
            figures["too_near"] = mmax(restoration.clearance.lacking)
        slacks = []
        for qp, solution in qps.solutions() if qps else ():
            for group in qp.rows:
                if group.elastic:
                    entries += [(f"{qp.name}: {group.name}, row {i}", "") for i in range(group.count)]
                    slacks.append(solution.slack(group.name))
        if slacks:
            figures["slack"] = mmax(vertcat(*slacks))
            amounts += slacks
        if entries:
            figures["relaxed"] = vertcat(*amounts)
        return cls(tuple(entries), figures)

    def relaxed(self, amounts: Array) -> tuple[Relaxation, ...]:
        """The constraints that were relaxed, from the numbers of a record."""
        named = zip(self.entries, amounts.tolist(), strict=True)
        return tuple(Relaxation(name, amount, unit) for (name, unit), amount in named if amount > NEGLIGIBLE)
