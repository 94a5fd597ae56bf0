"""Units of work: a block of cases, all contenders on it, one set of criteria. They pickle, there and back.

Contenders are built once a process and kept. In a unit everybody first solves the block off the clock, recorded; then
come the timed rounds, the contenders of each in an order drawn anew. Between two readings of the clock there is one
call of a contender's `solve` and nothing of the study's own.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from jtik.criterion.base import Criterion, CriterionSum
from jtik.problems import Case, ProblemSet
from jtik.result.solution import Trace
from jtik.study.contender import Answer, Contender, Ready, Setting
from jtik.study.judge import Judge
from jtik.study.rows import Row, measured
from jtik.study.ruler import Ruler, measures_of
from jtik.types import Array

Key = tuple[str, str, str]
"""Contender, criteria and case, by their names."""

LONG = 0.05
"""A case that never took less [s], the rehearsal counted, is not timed again: repeating would correct little."""


@dataclass(frozen=True)
class Unit:
    """A block of cases with one set of criteria."""

    criteria: str
    start: int
    stop: int


@dataclass(frozen=True)
class Plan:
    """A whole study, before anything of it is solved.

    Attributes:
        setting: what is asked for; its criteria stand for those of each label in turn.
        contenders: who takes part, by label.
        criteria: the criteria by label.
        problems: the cases.
        repeats: how many rounds are timed.
        traces: how many cases of each kind keep their iterations.
        block: how many cases a unit has.
    """

    setting: Setting
    contenders: Mapping[str, Contender]
    criteria: Mapping[str, Criterion | CriterionSum | None]
    problems: ProblemSet
    repeats: int
    traces: int
    block: int

    def units(self) -> list[Unit]:
        """All of it, in pieces."""
        starts = range(0, len(self.problems), self.block)
        ends = [(start, min(start + self.block, len(self.problems))) for start in starts]
        return [Unit(label, *end) for label in self.criteria for end in ends]

    def setting_with(self, label: str) -> Setting:
        """The setting with the criteria of that label."""
        return replace(self.setting, criteria=self.criteria[label])

    @cached_property
    def remembered(self) -> frozenset[str]:
        """Names of the cases whose iterations are kept: the first few of each kind."""
        kept: list[str] = []
        for kind in self.problems.kinds:
            kept += [case.name for case in self.problems if case.kind == kind][: self.traces]
        return frozenset(kept)


@dataclass
class Block:
    """What a unit found: a row a contender and case, the answers, and what is kept of the way to them.

    Attributes:
        unit: which it was.
        rows: the figures.
        answers: the configuration each contender ends at, (nq,), NaN where there is none, in the order of rows.
        traces: iterations of solves.
        paths: postures along paths, (k, nq).
    """

    unit: Unit
    rows: list[Row] = field(default_factory=list)
    answers: list[Array] = field(default_factory=list)
    traces: dict[Key, Trace] = field(default_factory=dict)
    paths: dict[Key, Array] = field(default_factory=dict)


class Bench:
    """Everything that one process builds for a study, and keeps."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.robot, self.tasks = plan.setting.reduced()
        self.judge = Judge(self.robot, self.tasks)
        self._rulers: dict[str, Ruler] = {}
        self._ready: dict[tuple[str, str], Ready | Failure] = {}

    def ruler(self, label: str) -> Ruler:
        """What measures the answers with criteria of that label; distances of other labels where it has none."""
        if label not in self._rulers:
            plan = self.plan
            measures = measures_of(plan.criteria[label], plan.setting.clearances)
            if not measures:
                everywhere = [each for criteria in plan.criteria.values() for each in measures_of(criteria, ())]
                measures = list({each.name: each for each in reversed(everywhere)}.values())
            self._rulers[label] = Ruler(self.robot, self.tasks, plan.criteria[label], measures)
        return self._rulers[label]

    def ready(self, label: str, contender: str) -> Ready | Failure:
        """The contender of that label, built; or why it cannot be."""
        key = (label, contender)
        if key not in self._ready:
            try:
                self._ready[key] = self.plan.contenders[contender].prepare(self.plan.setting_with(label))
            except Exception as error:
                status = "not installed" if isinstance(error, ImportError) else "not built"
                self._ready[key] = Failure(status, reason(error))
        return self._ready[key]

    def run(self, unit: Unit) -> Block:
        """Solve, time and judge."""
        plan, block = self.plan, Block(unit)
        cases = plan.problems.cases[unit.start : unit.stop]
        entries = [Entry(self, unit.criteria, contender, cases) for contender in plan.contenders]
        for entry in entries:
            entry.rehearse()
        generator = np.random.default_rng([plan.setting.seed, unit.start])
        for _ in range(plan.repeats):
            for number in generator.permutation(len(entries)):
                entries[number].race()
        for entry in entries:
            entry.report(block)
        return block


@dataclass(frozen=True)
class Failure:
    """Why something has no figures: the status of its rows, and the note beside it."""

    status: str
    note: str


@dataclass
class Attempt:
    """One case of one contender.

    Attributes:
        case: the case.
        targets: its targets in the contender's own form.
        rehearsed: time of the rehearsal [s].
        seconds: mean time of a target, one entry a round [s].
        answers: those of the first round, one a target.
        traces: the recorded iterations, one a target.
        failure: what went wrong.
    """

    case: Case
    targets: list[Any] = field(default_factory=list)
    rehearsed: float = 0.0
    seconds: list[float] = field(default_factory=list)
    answers: list[Answer] = field(default_factory=list)
    traces: list[Trace | None] = field(default_factory=list)
    failure: Failure | None = None

    @property
    def long(self) -> bool:
        """Whether it has been timed and takes so long that once is enough."""
        whole = [len(self.targets) * each for each in self.seconds]
        return bool(whole) and min(self.rehearsed, *whole) > LONG


class Entry:
    """One contender in one unit."""

    def __init__(self, bench: Bench, label: str, contender: str, cases: tuple[Case, ...]) -> None:
        self._bench, self._label, self._contender = bench, label, contender
        self._ready = bench.ready(label, contender)
        self._attempts = [Attempt(case) for case in cases]
        for attempt in self._attempts:
            if isinstance(self._ready, Failure):
                attempt.failure = self._ready

    def rehearse(self) -> None:
        """Solve everything once, recorded and off the clock."""
        ready = self._ready
        if isinstance(ready, Failure):
            return
        nq = self._bench.robot.nq

        def traced(target: Any, q0: Array) -> tuple[Answer, Trace | None]:
            answer, trace = ready.traced(target, q0)
            return checked(answer, nq), trace

        for attempt in self._attempts:
            begin = time.perf_counter()
            try:
                attempt.targets = [ready.convert(target) for target in attempt.case.targets]
                ready.set(attempt.case.parameters)
                q = attempt.case.q0
                for target in attempt.targets:
                    answer, trace = traced(target, q)
                    attempt.traces.append(trace)
                    q = answer.q
            except Exception as error:
                attempt.failure = Failure("raised", reason(error))
            attempt.rehearsed = time.perf_counter() - begin

    def race(self) -> None:
        """Solve everything once, timed, after one solve to warm up."""
        ready = self._ready
        if isinstance(ready, Failure):
            return
        going = [
            each for each in self._attempts if not each.failure and not (each.seconds and max(each.seconds) > LONG)
        ]
        collecting = gc.isenabled()
        gc.disable()
        try:
            for first in going[:1]:
                self._timed(first, first.targets[:1], ready)
            for attempt in going:
                seconds, answers = self._timed(attempt, attempt.targets, ready)
                if attempt.failure is None:
                    attempt.seconds.append(seconds)
                    attempt.answers = attempt.answers or answers
        finally:
            if collecting:
                gc.enable()

    def _timed(self, attempt: Attempt, targets: list[Any], ready: Ready) -> tuple[float, list[Answer]]:
        """Mean time of a target [s], and the answers."""
        total, answers, clock = 0.0, [], time.perf_counter
        solve: Callable[[Any, Array], Answer] = ready.solve
        nq, q = self._bench.robot.nq, attempt.case.q0
        try:
            ready.set(attempt.case.parameters)
            for target in targets:
                begin = clock()
                answer = solve(target, q)
                end = clock()
                total += end - begin
                answers.append(checked(answer, nq))
                q = answers[-1].q
        except Exception as error:
            attempt.failure = Failure("raised", reason(error))
        return total / len(targets), answers

    def report(self, block: Block) -> None:
        """Judge the answers and write the rows."""
        bench, plan = self._bench, self._bench.plan
        left_out = "" if isinstance(self._ready, Failure) else self._ready.note
        for attempt in self._attempts:
            key = (self._contender, self._label, attempt.case.name)
            if attempt.failure:
                row = Row.failed(key, attempt.case.kind, attempt.failure.status, attempt.failure.note)
                block.rows.append(row)
                block.answers.append(np.full(bench.robot.nq, math.nan))
                continue
            postures = np.array([answer.q for answer in attempt.answers])
            row = measured(key, bench, attempt, postures)
            block.rows.append(replace(row, note="; ".join(filter(None, [row.note, left_out]))))
            block.answers.append(postures[-1])
            if attempt.case.name in plan.remembered:
                trace = attempt.traces[-1]
                if attempt.case.is_path:
                    block.paths[key] = postures
                elif trace is not None:
                    block.traces[key] = trace


def checked(answer: Answer, nq: int) -> Answer:
    """The answer with a q that is one. Raises ValueError for another shape."""
    q = np.array(answer.q, dtype=np.float64)
    if q.shape != (nq,):
        raise ValueError(f"its answer has shape {q.shape}, not ({nq},)")
    return answer._replace(q=q)


def reason(error: BaseException) -> str:
    """What an error says, in one line."""
    text = " ".join(str(error).split()) or "no message"
    known = type(error).__module__.startswith("jtik.")
    return text if known or isinstance(error, ImportError) else f"{type(error).__name__}: {text}"
