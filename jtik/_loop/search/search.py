"""The search: attempts from one configuration or from several until enough of them reach the target.

An attempt calls the fused step until its code ends the attempt. With restarts, an attempt also ends as soon as it has
not reduced the error for a few calls, and the next one starts from another configuration, the closest to the target
first. When none reaches the target, the attempt with the smallest error and the first one are continued until they end
(formulations/restarts.md). Joints that can turn all the way round move without limits and are brought back at the end
(formulations/full_turns.md).
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from typing import NamedTuple

import numpy as np

from jtik._loop.lanes.search import BLOCKS, MOST_ROWS, LaneSearch
from jtik._loop.native.search import NativeBatch, NativeSearch
from jtik._loop.native.threads import MOST_THREADS, SMALLEST, in_threads
from jtik._loop.runner import Runner
from jtik._loop.search.arrivals import Arrivals, SearchResult
from jtik._loop.search.attempts import Attempts, Ended, patience_of
from jtik._loop.search.ends import Ends, smaller
from jtik._loop.search.full_turns import FullTurns
from jtik._loop.search.jump import Jump
from jtik._loop.search.start_bank import StartBanks
from jtik._loop.search.starts import SearchStarts, Starts
from jtik._loop.trace_recorder import TraceRecorder
from jtik._step.inputs import Inputs, Settings
from jtik._step.stopping import OUTCOME, Code
from jtik.robot import Robot
from jtik.types import Array

PATIENCE, IN_LANES = 4.0, 3.0
"""Calls without progress after which an attempt that a restart can replace ends, and one of lanes with own steps."""

MANY = 1000
"""Number of targets of a batch for which more than the first restarts are drawn beforehand, and the most of these."""


class SearchOptions(NamedTuple):
    """Options of a search.

    Attributes:
        limit: largest number of calls of an attempt.
        restarts: largest number of restarts.
        seed: seed of the restart configurations.
        best_of: number of distinct arrivals at the target after which the search ends.
        jump_limit: largest change of a joint from where the search began [rad] or [m].
    """

    limit: int
    restarts: int
    seed: int
    best_of: int = 1
    jump_limit: float = math.inf


class Search:
    """Attempts with a runner's memory; the inputs, such as the target, are read from the memory that the steps use.

    Args:
        robot: the robot.
        attempts: runs attempts.
        turns: the joints that can turn all the way round.
        inputs: the inputs of the search, in which the limits of these joints are infinite.
        banks: the restarts by their distance from the target; None where they depend on where a search begins.
        has_criterion: whether there is a criterion.
        by_level: whether failed attempts are compared by their levels of priority.

    Attributes:
        native: the search in C, where the step runs as generated C.
    """

    def __init__(
        self,
        robot: Robot,
        attempts: Attempts,
        turns: FullTurns,
        inputs: Inputs[Array],
        *,
        banks: StartBanks | None,
        has_criterion: bool,
        by_level: bool = False,
    ) -> None:
        self._robot, self._attempts, self._turns, self._inputs = robot, attempts, turns, inputs
        self._has_criterion, self._by_level = has_criterion, by_level
        self._restarts, self._continuum = SearchStarts(robot, banks), attempts.continuum
        self._waiting: SearchOptions | None = None
        self.native: NativeSearch | None = None
        self._beside: list[NativeSearch | LaneSearch] = []
        self._beside_of: NativeSearch | LaneSearch | None = None

    def find(
        self,
        runner: Runner,
        q0: Array,
        options: SearchOptions,
        recorder: TraceRecorder | None = None,
        *,
        begun: int | None = None,
        jump: Jump | None = None,
    ) -> SearchResult:
        """Search from ``q0`` (nq,), then from the restart configurations.

        Args:
            runner: the runner; the limits of the joints that can turn hold where it has inputs other than a search's.
            q0: where to begin, (nq,).
            options: the options.
            recorder: records the calls; None for none.
            begun: what ``native.run_prepared()`` returned, where it has run the first attempts with these options.
            jump: the jump limit, where there is one.
        """
        if runner.inputs.lower is not self._inputs.lower:
            ended = self._attempts.run(runner, q0, options.limit, recorder)
            return _result(runner, ended, ended.calls, ended.escapes, 0)
        if jump is None:
            return self._find(runner, q0, options, recorder, begun)
        with self._within(jump.box):
            return self._find(runner, q0, options, recorder, begun, jump)

    def jump(self, q0: Array, limit: float) -> Jump:
        """The jump limit of a search from ``q0`` (nq,) [rad] or [m]."""
        lower, upper = self._inputs.lower.copy(), self._inputs.upper.copy()
        lower[self._turns.indices], upper[self._turns.indices] = self._turns.lower, self._turns.upper
        return Jump(self._robot, q0, limit, lower, upper)

    def _find(
        self,
        runner: Runner,
        q0: Array,
        options: SearchOptions,
        recorder: TraceRecorder | None,
        begun: int | None,
        jump: Jump | None = None,
    ) -> SearchResult:
        """`find` for a runner of the search; the limits of ``jump`` replace those of the robot."""
        limit, restarts = options.limit, options.restarts
        patience = PATIENCE if restarts else math.inf
        native = self.native if self.native and runner is self.native.runner and recorder is None else None
        ends, arrivals = Ends(), self._arrivals(q0)
        iterations, escapes, number = 0, 0, 0
        starts: Starts | None = None
        while number <= restarts:
            starts = self._starts(number, options, q0, jump, starts)
            finished = False  # whether the search in C has brought the joints back
            if native:
                last = number if self._by_level or starts is None else min(starts.last, restarts)
                of_these = Ends() if self._by_level else ends
                if begun is None:
                    own = patience_of(runner, patience)
                    begun = native.find(q0, starts, (number, last), of_these, limit, own)
                end, begun = native.end(begun, of_these), None
                iterations, number = iterations + end.iterations, end.number
                if end.code is None:
                    if self._by_level:
                        ends.add(number, self._errors(runner), runner.q[runner.at])
                    number += 1  # where its time was over, further ones of this block are left
                    continue
                finished, ended = end.finished, Ended(end.code, end.calls, 0)
                if finished and end.code is Code.DONE and self._attempts.can_go_on(runner.q[runner.at]):
                    finished, untried = False, int(not runner.view[OUTCOME.tried])
                    ended = Ended(end.code, end.calls + untried, 0)
                if not finished:
                    ended = self._attempts.go_on(runner, limit, None, patience, code=ended.code, calls=ended.calls)
            else:
                start = q0 if starts is None or number == 0 else starts.of(number, self._inputs.target)
                ended = self._attempts.run(runner, start, limit, recorder, patience)
            reached = self._reached(runner, ended)
            if (reached or not restarts) and not finished:
                ended = self._bring_back(runner, ended, q0, limit, recorder, jump)
                reached = self._reached(runner, ended)
            if jump is not None and reached:
                reached = jump.holds(runner.q[runner.at])
            iterations, escapes = iterations + ended.calls, escapes + ended.escapes
            if reached or not restarts:
                arrivals.add(_result(runner, ended, iterations, escapes, number))
                if len(arrivals.found) >= options.best_of or not restarts:
                    break
            else:
                ends.add(number, self._errors(runner), runner.q[runner.at])
            number += 1
        if arrivals.found:
            return arrivals.best(iterations, escapes, min(number, restarts))
        final: tuple[tuple[float, ...], SearchResult] | None = None
        for q in ends.to_continue():  # the attempt from the caller's q0 too: it may still reach the target
            ended = self._attempts.run(runner, q, limit, recorder)
            ended = self._bring_back(runner, ended, q0, limit, recorder, jump)
            iterations, escapes = iterations + ended.calls, escapes + ended.escapes
            errors = self._errors(runner)
            if final is None or smaller(errors, final[0]):
                final = errors, _result(runner, ended, iterations, escapes, restarts)
            if ended.code is Code.DONE:
                break
        assert final is not None
        return final[1]._replace(iterations=iterations, escapes=escapes)

    def _arrivals(self, q0: Array) -> Arrivals:
        """The arrivals of a search from ``q0``, none yet."""
        attempts, robot = self._attempts, self._robot

        def distance(q: Array) -> float:
            return float(np.linalg.norm(robot.difference(q0, q)))

        cost = attempts.criterion if self._has_criterion else distance
        return Arrivals(robot, self._continuum, self._inputs.target, cost=cost, on_target=attempts.on_target)

    def _starts(
        self, number: int, options: SearchOptions, q0: Array, jump: Jump | None, latest: Starts | None = None
    ) -> Starts | None:
        """The restarts around attempt ``number``, the ``latest`` ones where it is among them; None without restarts."""
        if not options.restarts or (latest is not None and latest.first <= number <= latest.last):
            return latest
        starts = self._restarts.around(number, options.seed, q0, jump)
        if number and options == self._waiting:
            self.prepare(options)
        return starts

    def _bring_back(
        self,
        runner: Runner,
        ended: Ended,
        q0: Array,
        limit: int,
        recorder: TraceRecorder | None,
        jump: Jump | None,
    ) -> Ended:
        """The end of an attempt with every joint within its limits."""
        if jump is not None or not self._turns.indices.size:
            return ended
        return self._attempts.bring_back(runner, ended, q0, limit, recorder)

    def _reached(self, runner: Runner, ended: Ended) -> bool:
        """Whether the attempt has reached the target, according to its last call."""
        settings, view = Settings(*self._inputs.settings.tolist()), runner.view
        on_target = (
            view[OUTCOME.position_error] <= settings.position_tolerance
            and view[OUTCOME.orientation_error] <= settings.orientation_tolerance
        )
        return ended.code is Code.DONE or (ended.calls > 0 and on_target)

    def _errors(self, runner: Runner) -> tuple[float, ...]:
        """The error where an attempt has ended, as `Ends` compares it."""
        if self._by_level:
            return self._attempts.level_errors(runner.q[runner.at])
        return (runner.view[OUTCOME.V],)

    @contextmanager
    def _within(self, box: tuple[Array, Array]) -> Iterator[None]:
        """Other limits, in force for all joints while a search runs."""
        lower, upper = self._inputs.lower, self._inputs.upper
        free = lower.copy(), upper.copy()
        lower[:], upper[:] = box
        if self.native:
            self.native.turning = False
        try:
            yield
        finally:
            lower[:], upper[:] = free
            if self.native:
                self.native.turning = True

    def prepare(self, options: SearchOptions) -> bool:
        """Set ``native.run_prepared()`` to search with these options; False where it cannot."""
        plain = options.best_of == 1 and options.jump_limit == math.inf and not (self._by_level and options.restarts)
        if self.native is None or not plain or self._restarts.depend_on_start or options.limit == 0:
            return False
        starts = self._starts(0, options, self.native.q0, None)
        last = 0 if starts is None else min(starts.last, options.restarts)
        patience = PATIENCE if options.restarts else patience_of(self.native.runner, math.inf)
        self.native.prepare(starts, last, options.limit, patience)
        self._waiting = options if starts is not None and not last else None  # until a search needs a restart
        return True

    def find_all(
        self, targets: Array, q0: Array, options: SearchOptions, threads: int = 1, lanes: LaneSearch | None = None
    ) -> Iterator[tuple[int, NativeBatch, float]] | None:
        """Searches for each row of ``targets`` in C, in the blocks of `in_threads`; None without C.

        A row whose code is negative needs `find`. Ctrl-C is obeyed after a tenth of a second.

        Args:
            targets: the numbers of the targets, (k, size).
            q0: where to begin, one configuration for all, (1, nq), or one for each, (k, nq).
            options: the options.
            threads: number of threads that search at the same time; with several the blocks come as they are done.
            lanes: the search in lanes; None for one target at a time.
        """
        native = lanes or self.native
        if native is None or (len(q0) > 1 and self._restarts.depend_on_start):
            return None
        starts, last, count = None, 0, min(options.restarts, MANY) if len(targets) >= MANY else 0
        if options.restarts:
            starts = self._restarts.of_batch(options.seed, q0[0], 0 if lanes and lanes.banks else count)
            last = min(starts.last, options.restarts)
        replaceable = IN_LANES if lanes and not self._has_criterion else PATIENCE
        patience = replaceable if options.restarts else patience_of(native.runner, math.inf)

        def solve(search: NativeSearch | LaneSearch, begin: int, end: int) -> NativeBatch:
            own = q0[begin:] if len(q0) > 1 else q0
            return search.batch(targets[begin:end], own, starts, last, options.limit, patience)

        threads = min(threads, MOST_THREADS, max(len(targets) // SMALLEST, 1))
        if threads == 1:
            return in_threads([partial(solve, native)], len(targets))
        if self._beside_of is not native:
            self._beside_of, self._beside = native, []
        self._beside += [native.beside() for _ in range(len(self._beside), threads)]  # Python goes on with its own
        in_lanes = {"blocks": BLOCKS, "most": MOST_ROWS} if lanes else {}
        return in_threads([partial(solve, search) for search in self._beside[:threads]], len(targets), **in_lanes)

    def found(self, batch: NativeBatch, row: int, target: Array) -> SearchResult | None:
        """A row of `find_all`, whose ``target`` is given as numbers; None where it needs `find`."""
        code, iterations, restarts = batch.tallies[row].tolist()
        if code < 0 or (code == Code.DONE and self._attempts.can_go_on(batch.q[row], target)):
            return None
        errors = tuple(batch.errors[row].tolist()) if code == Code.DONE else None
        return SearchResult(batch.q[row].copy(), _CODES[code], iterations, 0, restarts, errors)


def _result(runner: Runner, ended: Ended, iterations: int, escapes: int, restarts: int) -> SearchResult:
    """The end of the last attempt, whose q the runner's memory holds."""
    errors = None
    if ended.code is Code.DONE or (runner.evaluated and ended.calls > 0 and not ended.escapes):
        errors = runner.view[OUTCOME.position_error], runner.view[OUTCOME.orientation_error]
    return SearchResult(runner.q[runner.at].copy(), ended.code, iterations, escapes, restarts, errors)


_CODES = tuple(Code)
