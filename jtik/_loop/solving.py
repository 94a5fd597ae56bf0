"""Solving: what `InverseKinematics.solve`, ``solve_batch`` and ``track`` run."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from numpy.typing import NDArray

from jtik._loop.arguments import ConfigurationReader, read_targets
from jtik._loop.batch.rows import BatchRows, collect, solved
from jtik._loop.batch.searches import BatchSearches, BatchTargets
from jtik._loop.checked_options import CheckedOptions, Options
from jtik._loop.exclusive_use import ExclusiveUse, in_use
from jtik._loop.inspection import Inspector
from jtik._loop.lanes.attempts import LaneAttempts
from jtik._loop.lanes.lanes import Lanes
from jtik._loop.native.compile_ahead import CompileAhead
from jtik._loop.native.search_source import UNREADABLE
from jtik._loop.native.solves import NativeSolves
from jtik._loop.options import check_lanes, read_lanes
from jtik._loop.runner import Runner
from jtik._loop.runners import EXPLORING, SOLVE, TIMED, Runners
from jtik._loop.search.arrivals import SearchResult
from jtik._loop.search.jump import Jump
from jtik._loop.search.search import Search, SearchOptions
from jtik._loop.solutions import Solutions
from jtik._loop.target_memory import TargetMemory
from jtik._loop.trace_recorder import TraceRecorder
from jtik._loop.tracking import follow
from jtik._step.inputs import SETTING
from jtik._step.stopping import Code
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.arguments import flag, positive_number
from jtik.errors import ArgumentError
from jtik.progress import Progress, read_progress, watched
from jtik.result.batch import SolutionBatch
from jtik.result.report import Report
from jtik.result.solution import Solution
from jtik.result.trajectory import Trajectory
from jtik.types import Array

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from jtik._loop.copying import FixedSolver

_UNREAD = (UNREADABLE, Code.NOT_FINITE)
"""What the native search returns, too, for a q0 that was copied unread and is not finite, or too large."""


class Solving:
    """Runs searches and returns their ends as Solutions.

    Attributes:
        natives: the solves in C, which leave what is not usual to `solve`.
    """

    def __init__(
        self,
        problem: SymbolicProblem,
        runners: Runners,
        search: Search,
        targets: TargetMemory,
        configurations: ConfigurationReader,
        lanes: Lanes,
        *,
        inspector: Inspector,
        exclusive: ExclusiveUse,
        ahead: CompileAhead,
    ) -> None:
        self._robot, self._tasks, self._has_criterion = problem.robot, problem.tasks, problem.has_criterion
        self._terms = problem.terms
        self._runners, self._search, self._inspector = runners, search, inspector
        self._configurations, self._exclusive, self._lanes = configurations, exclusive, lanes
        self._memory, self._targets, self._ahead = runners.memory, targets, ahead
        self._target = self._memory.inputs.target
        self._solutions = Solutions(problem.terms, self._memory, inspector)
        in_c = runners.has_native_step
        self.natives = NativeSolves(problem.robot.home, self._solutions, exclusive, self.solve, possible=in_c)
        settings, has_criterion = self._memory.inputs.settings, self._has_criterion
        self._checked = CheckedOptions(search, self.natives, settings, has_criterion=has_criterion)
        self._batch = BatchSearches(
            search,
            self._memory,
            inspector,
            ahead,
            has_criterion=self._has_criterion,
            find=lambda start, search_options: self._search_in_memory(start, search_options, runners.solve),
        )
        self.adopted()

    def adopted(self) -> None:
        """Solve in C what the search in C can solve, from now on."""
        self.natives.by_search(self._search.native, self._go_on)

    def solve(self, target: Any, q0: Any, lanes: bool, nearest: bool, trace: bool, *given: Any) -> Solution:
        """Iterate to the target, as `InverseKinematics.solve` describes it, with `Options`."""
        begin, options = time.perf_counter(), cast(Options, given)
        if lanes is not False or nearest is not False:
            lanes, nearest = read_lanes(lanes, nearest, trace)
            if lanes:
                return self._solve_in_lanes(target, q0, options, nearest)
        if trace is not False:
            trace = flag("trace", trace, "whether every iteration is kept in solution.trace")
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            if self._ahead.waiting:
                self._ahead.adopt()
            native = self._checked.is_prepared(options) and not trace
            begun = self._solve_native(target, q0, begin) if native else None
            return begun if isinstance(begun, Solution) else self._solve(target, q0, options, trace, begin, begun)
        finally:
            exclusive.busy = False

    def _go_on(self, target: Any, q0: Any, *given: Any) -> Solution:
        """`solve` from where the native solve, whose guard holds, has ended."""
        returned, elapsed = self.natives.ended
        self._ahead.adopt()
        begun = None if returned in _UNREAD else returned
        return self._solve(target, q0, cast(Options, given[3:]), False, time.perf_counter() - elapsed, begun)

    def _solve(self, target: Any, q0: Any, options: Options, trace: bool, begin: float, begun: int | None) -> Solution:
        """`solve`, after what the native search has returned; None where it has not begun."""
        self._targets.read(target)
        start = self._configurations.start(q0)
        search_options = self._read_options(options)
        jump = None
        if search_options.jump_limit < math.inf:
            self._configurations.check_within_limits(start, "q0")
            jump = self._search.jump(start, search_options.jump_limit)
        recorder = None
        if trace:
            recorder = TraceRecorder(self._runners.traced_limited_solve if jump else self._runners.traced_solve)
        runner = recorder.runner if recorder else self._runners.limited_solve if jump else self._runners.solve
        found = self._search_in_memory(start, search_options, runner, recorder, begun, jump)
        solution = self._solutions.of(found, target, options, begin, jump)
        if recorder:
            solution.__dict__["trace"] = recorder.trace(found.q, self._error)
        others = [self._solutions.of(other, target, options, begin, jump) for other in found.alternatives]
        solution.__dict__["alternatives"] = tuple(others)
        return solution

    def _solve_in_lanes(self, target: Any, q0: Any, options: Options, nearest: bool) -> Solution:
        """The same from several starts, side by side."""
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            if self._ahead.waiting:
                self._ahead.adopt()
            search_options = self._read_options(options)
            check_lanes(search_options)
            attempts = self._prepared_attempts(search_options, nearest, options)
            begin = time.perf_counter()  # what is compiled or drawn once takes none of its time
            self._targets.copy(target)  # if it is not finite, the search does not end in DONE; q0 is read there
            start, found = self._configurations.unread(q0), attempts.found
            if attempts.run(start) == Code.DONE and not self._has_criterion:
                _, iterations, restarts = found.tallies[0].tolist()
                return self._solutions.converged(found.q[0].copy(), iterations, restarts, target, begin)
            return self._after_lanes(target, q0, options, begin)
        finally:
            exclusive.busy = False

    def _prepared_attempts(self, search_options: SearchOptions, nearest: bool, options: Options) -> LaneAttempts:
        """The attempts in lanes; solves with these options run in C from now on, where that is possible."""
        attempts, natives = self._lanes.attempts, self.natives
        usual = not (attempts.depend_on_start or self._has_criterion)
        if usual:
            natives.by_lanes(attempts, self._go_on_in_lanes)
            natives.forget_lanes()
        attempts.prepare(search_options, nearest=nearest)
        if usual:
            natives.know_lanes(options, nearest)
        return attempts

    def _go_on_in_lanes(self, target: Any, q0: Any, *given: Any) -> Solution:
        """`solve_in_lanes` from where the native solve, whose guard holds, has ended."""
        self._ahead.adopt()
        return self._after_lanes(target, q0, cast(Options, given[3:]), time.perf_counter() - self.natives.ended[1])

    def _after_lanes(self, target: Any, q0: Any, options: Options, begin: float) -> Solution:
        """The Solution after attempts in lanes whose end is not usual."""
        self._targets.read(target)
        result = self._search.found(self._lanes.attempts.found, 0, self._target)
        if result is None:
            given = self._configurations.start(q0), self._read_options(options)
            result = self._search_in_memory(*given, self._runners.solve)
        return self._solutions.of(result, target, options, begin)

    def solve_batch(
        self,
        targets: Iterable[Any],
        q0: Any,
        options: Options,
        progress: Progress,
        *,
        solver: FixedSolver,
        executor: Executor | None,
        block: int,
        threads: int,
        lanes: bool,
        save: str | Path | None,
    ) -> SolutionBatch:
        """Solve for each target by itself, as `InverseKinematics.solve_batch` describes it."""
        from jtik._loop.batch.file import BatchFile
        from jtik._loop.batch.pool import BatchPool

        given, numbers = read_targets(self._tasks, targets, self._lanes.read_matrices if lanes else None)
        progress = read_progress(progress)
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            starts = self._configurations.starts(q0, len(numbers))
            search_options = self._read_options(options)
            in_lanes = self._lanes.search(restarts=search_options.restarts > 0) if lanes else None
            identity = None if save is None else (solver.identity, list(numbers), list(starts), options)
            file = BatchFile(save, identity, len(numbers), self._robot.nq)
            pool = None
            if executor is not None:
                shared: dict[str, Any] = {"numbers": numbers, "starts": starts, "options": options, "lanes": lanes}
                pool = BatchPool(executor, solver, block, **shared)

            def solve(missing: NDArray[np.int64]) -> Iterator[BatchRows]:
                all_targets = BatchTargets(given, numbers, starts)
                return self._batch.rows(missing, all_targets, options, search_options, threads, in_lanes)

            rows = solved(len(numbers), self._robot.nq, solve, pool=pool, file=file, progress=progress)
            memory = self._memory.numbers.copy()

            def inspect(i: int, q: Array) -> Report:
                inputs = memory.copy()
                self._memory.views(inputs).target[:] = numbers[i]
                return self._inspector.report(q, inputs, given[i])

            return collect(rows, targets=numbers, inspect=inspect)
        finally:
            exclusive.busy = False

    def solve_numbers(self, numbers: Array, starts: Array, options: Options, lanes: bool) -> BatchRows:
        """The rows of targets that are numbers, as another process can read them."""
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            search_options, targets = self._read_options(options), BatchTargets(numbers, numbers, starts)
            in_lanes = self._lanes.search(restarts=search_options.restarts > 0) if lanes else None
            chosen = np.arange(len(numbers))
            parts = list(self._batch.rows(chosen, targets, options, search_options, 1, in_lanes))
            return BatchRows.joined(parts, self._robot.nq).settled()
        finally:
            exclusive.busy = False

    def track(self, targets: Iterable[Any], q0: Any, dt: float, options: Options, progress: Progress) -> Trajectory:
        """Follow a path of targets, as `InverseKinematics.track` describes it."""
        given, _ = read_targets(self._tasks, targets)
        if not len(given):
            raise ArgumentError("targets", "none", "at least one target")
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            start, dt = self._configurations.start(q0), positive_number("dt", dt)
            search_options, stationary = self._read_options(options), options[-1] != "reached"
            self._memory.inputs.settings[SETTING.null_space_again] = float(stationary)
            self._ahead.adopt()
            box, runner = self._runners.tracking_box(stationary=stationary), self._runners.track

            def solve(target: Any, q: Array) -> Solution:
                begin = time.perf_counter()
                self._targets.read(target)
                found = self._search_in_memory(q, search_options, runner)
                return self._solutions.of(found, target, options, begin)

            try:
                path = watched(given, progress, "targets")
                return follow(self._robot, path, start, dt, box, solve, self._at_another_q)
            finally:
                self._checked.forget()
        finally:
            exclusive.busy = False

    def _read_options(self, options: Options) -> SearchOptions:
        return self._checked.read(options)

    def _solve_native(self, target: Any, q0: Any, begin: float) -> Solution | int | None:
        """Solve by the native search alone, with as little work in Python as possible.

        Returns:
            The Solution where the search has converged, else what it returned, for `Search.find` to go on; None where
            there is no native search.
        """
        native = self._search.native
        if native is None:
            return None
        if q0 is None or (type(q0) is np.ndarray and q0.shape == native.q0.shape):
            self._targets.copy(target)  # if it is not finite, the search does not end in DONE
        else:
            self._targets.read(target)
        native.q0[:] = self._configurations.unread(q0)
        returned = native.run_prepared()
        if returned != Code.DONE:
            return returned if returned not in _UNREAD else None
        iterations, restarts, at = native.counts.tolist()
        q = native.runner.q[at].copy()
        return self._solutions.converged(q, iterations, restarts, target, begin)

    def _search_in_memory(
        self,
        start: Array,
        search_options: SearchOptions,
        runner: Runner,
        recorder: TraceRecorder | None = None,
        begun: int | None = None,
        jump: Jump | None = None,
    ) -> SearchResult:
        """Search for the target that is in memory."""
        begin = time.perf_counter()
        self._solutions.begin()
        if recorder or search_options.limit == 0:  # otherwise the first step clamps it
            start = self._configurations.clamped(start, runner.inputs.lower, runner.inputs.upper)
        found = self._search.find(runner, start, search_options, recorder, begun=begun, jump=jump)
        self._terms.raise_interruption()
        seconds = time.perf_counter() - begin
        self._ahead.spend(TIMED if runner.inputs is self._memory.inputs else SOLVE, seconds)
        if self._runners.explores:
            self._ahead.spend(EXPLORING, seconds)
        return found

    def _error(self, q: Array) -> Array:
        """The task error at q for the target that is in memory, (m,)."""
        return self._inspector.error(q, self._memory.inputs)

    def _at_another_q(self, solution: Solution, q: Array) -> Solution:
        """The solution with another configuration for the same target."""
        inspection = self._inspector.snapshot(q, None)
        return replace(solution, q=q, inspect=inspection, status=inspection.status(Code.CONTINUE))
