"""What gives way in a step where not everything can be had: named amounts, expressions first, then numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from jtik.symbolic import Expression, mmax, vertcat
from jtik.types import Array

if TYPE_CHECKING:
    from jtik._step.symbolic_problem import SymbolicProblem
    from jtik._step.update import CheckedUpdate
    from jtik.qp.recorder import QPRecorder
    from jtik.strategy import FeasibilityRestoration


WORTH_TELLING = 1e-6
"""Amounts up to this are what solvers leave."""


class Relaxation(NamedTuple):
    """Something that was asked for and could not be had at the configuration of a Solution.

    Attributes: name, such as "task step" or "clearance: link4 to obstacle 1"; amount by which it falls short; unit.
    """

    name: str
    amount: float
    unit: str

    def __str__(self) -> str:
        if self.unit == "share":
            return f"{self.name} by {100 * self.amount:.0f} %"
        return f"{self.name} by {self.amount:.3g} {self.unit}".rstrip()


@dataclass(frozen=True)
class Yielding:
    """Names and units of what may give way in a step, and figures of it for its record, one a column ``relaxed``."""

    entries: tuple[tuple[str, str], ...] = ()
    figures: Mapping[str, Expression] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        update: CheckedUpdate,
        programs: QPRecorder | None,
        room: FeasibilityRestoration | None,
        problem: SymbolicProblem,
    ) -> Yielding:
        """What the law says of itself, clearances that stay too small, and the elastic rows of its programs."""
        entries, amounts, figures = [], list[Expression](), dict[str, Expression]()
        for (name, unit), amount in update.relaxed.items():
            entries.append((name, unit))
            amounts.append(amount)
        if room:
            entries += [(pair, "m") for pair in problem.pairs]
            amounts.append(room.missing)
            figures["too_near"] = mmax(room.clearance.lacking)
        slacks = []
        for program, solution in programs.solutions() if programs else ():
            for group in program.rows:
                if group.elastic:
                    entries += [(f"{program.name}: {group.name}, row {i}", "") for i in range(group.count)]
                    slacks.append(solution.slack(group.name))
        if slacks:
            figures["slack"] = mmax(vertcat(*slacks))
            amounts += slacks
        if entries:
            figures["relaxed"] = vertcat(*amounts)
        return cls(tuple(entries), figures)

    def told(self, amounts: Array) -> tuple[Relaxation, ...]:
        """The entries that did, from the numbers of a record."""
        named = zip(self.entries, amounts.tolist(), strict=True)
        return tuple(Relaxation(name, amount, unit) for (name, unit), amount in named if amount > WORTH_TELLING)
