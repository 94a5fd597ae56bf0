"""Solving and timing of work units.

A process builds each contender once and keeps it. In a unit, every contender first solves all cases once, recorded and
untimed. Timed rounds follow, with the contenders of each round in random order. Between two clock readings there is
exactly one call of a contender's `solve`.
"""

from __future__ import annotations

import gc
import math
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from jtik.problems import Case
from jtik.result.solution import Trace
from jtik.study.case_run import LONG, CaseRun, Failure, checked, reason
from jtik.study.contender import Answer, PreparedContender
from jtik.study.independent_check import IndependentCheck
from jtik.study.metrics import ConfigurationMetrics, measures_of
from jtik.study.rows import Row, measured
from jtik.study.work_units import StudyPlan, UnitResult, WorkUnit
from jtik.types import Array


class UnitRunner:
    """Runs the units of one study in one process, and keeps what it builds for them.

    Args:
        plan: the study.

    Attributes:
        plan: the study.
        robot: the reduced robot.
        tasks: the tasks on it.
        check: the independent check of the answers.
    """

    def __init__(self, plan: StudyPlan) -> None:
        self.plan = plan
        self.robot, self.tasks = plan.setting.reduced()
        self.check = IndependentCheck(self.robot, self.tasks)
        self._metrics: dict[str, ConfigurationMetrics] = {}
        self._prepared: dict[tuple[str, str], PreparedContender | Failure] = {}

    def metrics(self, label: str) -> ConfigurationMetrics:
        """The metrics for the criteria of a label; distances come from the other labels if it has none."""
        if label not in self._metrics:
            plan = self.plan
            measures = measures_of(plan.criteria[label], plan.setting.clearances)
            if not measures:
                everywhere = [each for criteria in plan.criteria.values() for each in measures_of(criteria, ())]
                measures = list({each.name: each for each in reversed(everywhere)}.values())
            self._metrics[label] = ConfigurationMetrics(self.robot, self.tasks, plan.criteria[label], measures)
        return self._metrics[label]

    def prepared(self, label: str, contender: str) -> PreparedContender | Failure:
        """A contender, built for the criteria of a label, or the reason why it cannot be built."""
        key = (label, contender)
        if key not in self._prepared:
            try:
                self._prepared[key] = self.plan.contenders[contender].prepare(self.plan.setting_with(label))
            except Exception as error:
                status = "not installed" if isinstance(error, ImportError) else "not built"
                self._prepared[key] = Failure(status, reason(error))
        return self._prepared[key]

    def run(self, unit: WorkUnit) -> UnitResult:
        """Solve, time and measure the cases of a unit."""
        plan, result = self.plan, UnitResult(unit)
        cases = plan.problems.cases[unit.start : unit.stop]
        runs = [ContenderRun(self, unit.criteria, contender, cases) for contender in plan.contenders]
        for run in runs:
            run.solve_recorded()
        generator = np.random.default_rng([plan.setting.seed, unit.start])
        for _ in range(plan.repeats):
            for number in generator.permutation(len(runs)):
                runs[number].solve_timed()
        for run in runs:
            run.add_rows(result)
        return result


class ContenderRun:
    """One contender in one unit."""

    def __init__(self, runner: UnitRunner, label: str, contender: str, cases: tuple[Case, ...]) -> None:
        self._runner, self._label, self._contender = runner, label, contender
        self._prepared = runner.prepared(label, contender)
        self._runs = [CaseRun(case) for case in cases]
        for run in self._runs:
            if isinstance(self._prepared, Failure):
                run.failure = self._prepared

    def solve_recorded(self) -> None:
        """Solve all cases once, recorded and untimed."""
        prepared = self._prepared
        if isinstance(prepared, Failure):
            return
        nq = self._runner.robot.nq

        def traced(target: Any, q0: Array) -> tuple[Answer, Trace | None]:
            answer, trace = prepared.traced(target, q0)
            return checked(answer, nq), trace

        for run in self._runs:
            try:
                run.targets = [prepared.convert(target) for target in run.case.targets]
                prepared.set(run.case.parameters)
                q = run.case.q0
                for target in run.targets:
                    answer, trace = traced(target, q)
                    run.traces.append(trace)
                    q = answer.q
            except Exception as error:
                run.failure = Failure("raised", reason(error))

    def solve_timed(self) -> None:
        """Solve all cases once, timed, after one solve to warm up."""
        prepared = self._prepared
        if isinstance(prepared, Failure):
            return
        timed = [run for run in self._runs if not run.failure and not (run.seconds and max(run.seconds) > LONG)]
        collecting = gc.isenabled()
        gc.disable()
        try:
            for first in timed[:1]:
                self._timed(first, first.targets[:1], prepared)
            for run in timed:
                seconds, answers = self._timed(run, run.targets, prepared)
                if run.failure is None:
                    run.seconds.append(seconds)
                    run.answers = run.answers or answers
        finally:
            if collecting:
                gc.enable()

    def _timed(self, run: CaseRun, targets: list[Any], prepared: PreparedContender) -> tuple[float, list[Answer]]:
        """Mean time for each target [s], and the answers."""
        total, answers, clock = 0.0, [], time.perf_counter
        solve: Callable[[Any, Array], Answer] = prepared.solve
        nq, q = self._runner.robot.nq, run.case.q0
        try:
            prepared.set(run.case.parameters)
            for target in targets:
                begin = clock()
                answer = solve(target, q)
                end = clock()
                total += end - begin
                answers.append(checked(answer, nq))
                q = answers[-1].q
        except Exception as error:
            run.failure = Failure("raised", reason(error))
        return total / len(targets), answers

    def add_rows(self, result: UnitResult) -> None:
        """Check the answers and add their rows to the result of the unit."""
        runner, plan = self._runner, self._runner.plan
        left_out = "" if isinstance(self._prepared, Failure) else self._prepared.note
        for run in self._runs:
            key = (self._contender, self._label, run.case.name)
            if run.failure:
                result.rows.append(Row.failed(key, run.case.kind, run.failure.status, run.failure.note))
                result.answers.append(np.full(runner.robot.nq, math.nan))
                continue
            postures = np.array([answer.q for answer in run.answers])
            row = measured(key, runner, run, postures)
            result.rows.append(replace(row, note="; ".join(filter(None, [row.note, left_out]))))
            result.answers.append(postures[-1])
            if run.case.name in plan.traced_cases:
                trace = run.traces[-1]
                if run.case.is_path:
                    result.paths[key] = postures
                elif trace is not None:
                    result.traces[key] = trace
