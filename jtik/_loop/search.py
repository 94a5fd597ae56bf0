"""The search: attempts from one configuration or from several until one reaches the target.

An attempt calls the fused step until its code ends the attempt. With restarts, an attempt also ends as soon as it has
not reduced the error for a few calls, and the next one starts from another configuration. When none reaches the target,
the attempt with the smallest error and the first one are continued until they end (formulations/restarts.md).
"""

from __future__ import annotations

import math
from typing import NamedTuple

from jtik._loop.criterion_escape import Escapes
from jtik._loop.native_search import NativeSearch
from jtik._loop.restarts import RestartConfigurations
from jtik._loop.runner import Runner
from jtik._loop.trace_recorder import TraceRecorder
from jtik._step.inputs import Inputs, Settings
from jtik._step.stopping import OUTCOME, Code
from jtik.robot import Robot
from jtik.types import Array

MAX_ESCAPES = 20
"""Largest number of saddle escapes of an attempt."""

PATIENCE = 4.0
"""Calls without progress after which an attempt that a restart can replace ends."""


class SearchOptions(NamedTuple):
    """Options of a search.

    Attributes:
        limit: largest number of calls of an attempt.
        restarts: largest number of restarts.
        seed: seed of the restart configurations.
    """

    limit: int
    restarts: int
    seed: int


class SearchResult(NamedTuple):
    """Where a search ended.

    Attributes:
        q: configuration, (nq,).
        code: code of the last call.
        iterations: calls that tried a step.
        escapes: saddle escapes.
        restarts: restarts used.
        errors: norms of position [m] and orientation [rad] rows at q; None where the last call did not give them.
    """

    q: Array
    code: Code
    iterations: int
    escapes: int
    restarts: int
    errors: tuple[float, float] | None = None


class Search:
    """Attempts with a runner's memory; the inputs, such as the target, are read from the memory that the steps use.

    Attributes:
        native: the search in C, where the step runs as generated C.
    """

    def __init__(self, robot: Robot, escapes: Escapes, inputs: Inputs[Array]) -> None:
        self._escapes, self._inputs = escapes, inputs
        self._restarts = RestartConfigurations(robot)
        self.native: NativeSearch | None = None
        self._addressed: tuple[Array | None, int] = (None, 0)

    def find(
        self, runner: Runner, q0: Array, options: SearchOptions, recorder: TraceRecorder | None = None
    ) -> SearchResult:
        """Search from ``q0`` (nq,), then from the restart configurations."""
        limit, restarts, seed = options
        starts = self._restarts.table(seed, restarts, q0) if restarts else None
        if self.native and runner is self.native.runner and recorder is None:
            found = self._native_find(self.native, q0, starts, options)
            if found:
                return found
        if starts is None:
            code, calls, escapes = self._attempt(runner, q0, limit, recorder)
            return SearchResult(runner.q[runner.at].copy(), code, calls, escapes, 0, _errors_when_done(runner, code))
        return self._restarted(runner, q0, starts, limit, recorder)

    def _restarted(
        self, runner: Runner, q0: Array, starts: Array, limit: int, recorder: TraceRecorder | None
    ) -> SearchResult:
        """Attempts from q0 and from the rows of ``starts`` until one reaches the target; else the best of them."""
        restarts = len(starts)
        settings, view = Settings(*self._inputs.settings.tolist()), runner.view
        ends: list[tuple[float, Array]] = []
        iterations, escapes = 0, 0
        for number in range(restarts + 1):
            start = q0 if number == 0 else starts[number - 1]
            code, calls, made = self._attempt(runner, start, limit, recorder, PATIENCE)
            iterations, escapes = iterations + calls, escapes + made
            reached = (
                view[OUTCOME.position_error] <= settings.position_tolerance
                and view[OUTCOME.orientation_error] <= settings.orientation_tolerance
            )
            if code is Code.DONE or reached:
                q, errors = runner.q[runner.at].copy(), _errors_when_done(runner, code)
                return SearchResult(q, code, iterations, escapes, number, errors)
            ends.append((view[OUTCOME.V], runner.q[runner.at].copy()))
        finals: list[tuple[float, Array, Code]] = []
        best = min(range(len(ends)), key=lambda number: ends[number][0])
        for number in {best: None, 0: None}:  # the attempt from the caller's q0 too: it may still reach the target
            code, calls, made = self._attempt(runner, ends[number][1], limit, recorder)
            iterations, escapes = iterations + calls, escapes + made
            finals.append((view[OUTCOME.V], runner.q[runner.at].copy(), code))
            if code is Code.DONE:
                break
        _, q, code = min(finals, key=lambda final: final[0])
        return SearchResult(q, code, iterations, escapes, restarts)

    def prepare(self, options: SearchOptions) -> bool:
        """Set ``native.run_prepared()`` to search with these options; False where it cannot."""
        if self.native is None or self._restarts.depend_on_start or options.limit == 0:
            return False
        starts = self._restarts.table(options.seed, options.restarts, self.native.q0) if options.restarts else None
        self.native.prepare(starts, options.restarts, options.limit, PATIENCE)
        return True

    def find_all(
        self, targets: Array, q0: Array, options: SearchOptions
    ) -> list[tuple[SearchResult | None, float]] | None:
        """Searches for each row of ``targets`` in one call, with their times [s]; None without the search in C.

        A row without a result needs `find`.
        """
        if self.native is None or (len(q0) > 1 and self._restarts.depend_on_start):
            return None
        starts = self._restarts.table(options.seed, options.restarts, q0[0]) if options.restarts else None
        batch = self.native.batch(targets, q0, self._address(starts), options.restarts, options.limit, PATIENCE)
        found: list[tuple[SearchResult | None, float]] = []
        rows = zip(batch.q, batch.errors.tolist(), batch.seconds.tolist(), batch.tallies.tolist(), strict=True)
        for q, errors, seconds, (code, iterations, number) in rows:
            last = _CODES[code] if code >= 0 else Code.STALLED
            inputs = self._inputs._replace(target=targets[len(found)])
            if last is Code.DONE and self._escapes.criterion.needed(q, inputs):
                code = -1
            known = (errors[0], errors[1]) if last is Code.DONE else None
            found.append((None if code < 0 else SearchResult(q, last, iterations, 0, number, known), seconds))
        return found

    def _native_find(
        self, native: NativeSearch, q0: Array, starts: Array | None, options: SearchOptions
    ) -> SearchResult | None:
        """The search in C; None where the search in Python has to begin again."""
        code = native.find(q0, self._address(starts), options.restarts, options.limit, PATIENCE)
        if code < 0:
            return None
        iterations, number, at = native.tally.tolist()
        last, q = _CODES[code], native.runner.q[at].copy()
        if last is Code.DONE and self._escapes.criterion.needed(q, self._inputs):
            return None
        return SearchResult(q, last, iterations, 0, number, _errors_when_done(native.runner, last))

    def _address(self, starts: Array | None) -> int | None:
        """The address of a table of configurations."""
        if starts is None:
            return None
        if starts is not self._addressed[0]:
            self._addressed = starts, starts.ctypes.data
        return self._addressed[1]

    def _attempt(
        self, runner: Runner, q0: Array, limit: int, recorder: TraceRecorder | None, patience: float = math.inf
    ) -> tuple[Code, int, int]:
        """Call the step until its code ends the attempt, or ``patience`` calls have made no progress.

        Returns the last code, the number of calls that tried a step, and the number of saddle escapes.
        """
        runner.start(q0, patience)
        if recorder is not None:
            recorder.begin()
        calls, view = runner.calls, runner.view
        code, escapes, k, at = Code.CONTINUE, 0, 0, 0
        while k < limit:
            if recorder is not None:
                recorder.before(runner.q[at])
            calls[at]()
            at = 1 - at
            k += 1
            if recorder is not None:
                recorder.after()
            if view[0] == 0.0:
                continue
            code = _CODES[int(view[0])]
            if code is Code.DONE:
                patience = math.inf  # the attempt has reached the target: no restart replaces it
            replaceable = patience < math.inf  # an attempt that a restart can replace only escapes where it began
            may_escape = escapes < (1 if replaceable else MAX_ESCAPES) and (k == 1 or not replaceable)
            if may_escape and self._escapes.escape(code, runner.q[at], self._inputs):
                escapes += 1
                if recorder is not None:
                    recorder.escaped()
                runner.start(runner.q[at].copy(), patience)
                code, at = Code.CONTINUE, 0
                continue
            if not view[OUTCOME.tried]:  # the call stopped before it tried a step: not an iteration
                k -= 1
                if recorder is not None:
                    recorder.discard()
            break
        runner.at = at
        return code, k, escapes


def _errors_when_done(runner: Runner, code: Code) -> tuple[float, float] | None:
    """The errors that the last call returned, which belong to its q where the search is done."""
    view = runner.view
    return (view[OUTCOME.position_error], view[OUTCOME.orientation_error]) if code is Code.DONE else None


_CODES = tuple(Code)
