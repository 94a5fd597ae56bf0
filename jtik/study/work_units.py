"""Work units of a study: the plan, its division into units, and the result of a unit. All of them can be pickled."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

from jtik.criterion.base import Criterion, CriterionSum
from jtik.problems import ProblemSet
from jtik.result.solution import Trace
from jtik.study.contender import Contender, Setting
from jtik.study.rows import Row
from jtik.types import Array

Key = tuple[str, str, str]
"""Names of contender, criteria and case."""


@dataclass(frozen=True)
class WorkUnit:
    """A block of consecutive cases with one set of criteria, solved by all contenders.

    Attributes:
        criteria: label of the criteria.
        start: index of the first case.
        stop: index after the last case.
    """

    criteria: str
    start: int
    stop: int


@dataclass(frozen=True)
class StudyPlan:
    """A complete study before anything is solved.

    Attributes:
        setting: the setting of all solves; its criteria are replaced by those of each label in turn.
        contenders: the contenders by label.
        criteria: the criteria by label.
        problems: the cases.
        repeats: number of timed rounds.
        traces: number of cases of each kind whose iterations are kept.
        block: number of cases of a unit.
    """

    setting: Setting
    contenders: Mapping[str, Contender]
    criteria: Mapping[str, Criterion | CriterionSum | None]
    problems: ProblemSet
    repeats: int
    traces: int
    block: int

    def units(self) -> list[WorkUnit]:
        """The study divided into units."""
        starts = range(0, len(self.problems), self.block)
        ends = [(start, min(start + self.block, len(self.problems))) for start in starts]
        return [WorkUnit(label, *end) for label in self.criteria for end in ends]

    def setting_with(self, label: str) -> Setting:
        """The setting with the criteria of a label."""
        return replace(self.setting, criteria=self.criteria[label])

    @cached_property
    def traced_cases(self) -> frozenset[str]:
        """Names of the cases whose iterations are kept: the first ones of each kind."""
        names: list[str] = []
        for kind in self.problems.kinds:
            names += [case.name for case in self.problems if case.kind == kind][: self.traces]
        return frozenset(names)


@dataclass
class UnitResult:
    """The result of a unit, with one row for each contender and case.

    Attributes:
        unit: the unit.
        rows: the rows.
        answers: final configuration of each row, (nq,), NaN if there is none.
        traces: iterations of solves, by contender, criteria and case.
        paths: configurations along paths, (k, nq), by the same key.
    """

    unit: WorkUnit
    rows: list[Row] = field(default_factory=list)
    answers: list[Array] = field(default_factory=list)
    traces: dict[Key, Trace] = field(default_factory=dict)
    paths: dict[Key, Array] = field(default_factory=dict)
