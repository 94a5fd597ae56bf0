"""The loop: from one start or from several to a configuration where there is nothing left to do.

An attempt calls the fused step until its code says otherwise. With restarts an attempt is given up as soon as it has
not lowered the error for a few calls, the next starts elsewhere, and when none arrives the best and the first are
carried to their ends.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from jtik._loop.native import NativeSearch
from jtik._loop.recording import TraceRecorder
from jtik._loop.runner import Runner
from jtik._loop.saddle_escape import SaddleEscape
from jtik._step.inputs import Inputs, Settings
from jtik._step.stopping import OUTCOME, Code
from jtik.robot import Robot
from jtik.types import Array

MOST_ESCAPES = 20
"""Second-order steps an attempt may take out of singular stalls."""

PATIENCE = 4.0
"""Calls without progress (``jtik._step.fused.FALL``) after which an attempt that others can replace is given up."""


class Request(NamedTuple):
    """What a search may spend: calls of an attempt, other starts, and the seed they are drawn with."""

    limit: int
    restarts: int
    seed: int


class Found(NamedTuple):
    """Where a search ended: configuration (nq,), the last code, calls that tried a step, escapes and restarts used.

    ``errors`` are the norms of position [m] and orientation [rad] rows there, where the last call has told them.
    """

    q: Array
    code: Code
    iterations: int
    escapes: int
    restarts: int
    errors: tuple[float, float] | None = None


class Starts:
    """Where restarts begin: uniform within the limits, the same for the same seed.

    A length without limits, such as the place of a free base, is drawn within 1 m of where the search began.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        scalar = [joint for joint in robot.independent_joints if joint.type.is_scalar]
        place = np.zeros(robot.nq, dtype=bool)
        for joint in robot.independent_joints:
            where = robot.q_slice(joint.name)
            if joint in scalar:
                unbounded = not (math.isfinite(joint.lower) and math.isfinite(joint.upper))
                place[where] = unbounded and not joint.type.rotational[0]
            else:
                place[where.start : where.start + joint.type.nq - 4] = True
        self._anywhere = place if place.any() else None
        self._drawn: dict[int, Array] = {}

    @property
    def wander(self) -> bool:
        """Whether they depend on where a search began."""
        return self._anywhere is not None

    def table(self, seed: int, count: int, about: Array) -> Array:
        """The first ``count`` restarts of a search that began at ``about`` (nq,); (count, nq), contiguous."""
        drawn = self._drawn.get(seed)
        if drawn is None or len(drawn) < count:
            generator = np.random.default_rng(seed)
            rows = [self._robot.random_configuration(generator) for _ in range(count)]
            drawn = self._drawn[seed] = np.array(rows).reshape(count, self._robot.nq)
        if self._anywhere is None:
            return drawn if len(drawn) == count else drawn[:count]
        return np.where(self._anywhere, drawn[:count] + about, drawn[:count])


class Search:
    """Attempts on the memory of a solver: its inputs, target among them, are read where they are."""

    def __init__(self, robot: Robot, rescue: SaddleEscape, inputs: Inputs[Array]) -> None:
        self._rescue, self._inputs = rescue, inputs
        self._starts = Starts(robot)
        self.native: NativeSearch | None = None
        self._addressed: tuple[Array | None, int] = (None, 0)

    def find(self, runner: Runner, q0: Array, request: Request, recorder: TraceRecorder | None = None) -> Found:
        """From ``q0`` (nq,), then from other starts."""
        limit, restarts, seed = request
        starts = self._starts.table(seed, restarts, q0) if restarts else None
        if self.native and runner is self.native.runner and recorder is None:
            found = self._native_find(self.native, q0, starts, request)
            if found:
                return found
        if starts is None:
            code, calls, escapes = self._attempt(runner, q0, limit, recorder)
            return Found(runner.q[runner.at].copy(), code, calls, escapes, 0, _told(runner, code))
        return self._restarted(runner, q0, starts, limit, recorder)

    def _restarted(self, runner: Runner, q0: Array, starts: Array, limit: int, recorder: TraceRecorder | None) -> Found:
        """Attempts from q0 and from the rows of ``starts`` until one reaches the target; else the best of them."""
        restarts = len(starts)
        settings, view = Settings(*self._inputs.settings.tolist()), runner.view
        ends: list[tuple[float, Array]] = []
        iterations, escapes = 0, 0
        for number in range(restarts + 1):
            start = q0 if number == 0 else starts[number - 1]
            code, calls, left = self._attempt(runner, start, limit, recorder, PATIENCE)
            iterations, escapes = iterations + calls, escapes + left
            reached = (
                view[OUTCOME.position_error] <= settings.position_tolerance
                and view[OUTCOME.orientation_error] <= settings.orientation_tolerance
            )
            if code is Code.DONE or reached:
                return Found(runner.q[runner.at].copy(), code, iterations, escapes, number, _told(runner, code))
            ends.append((view[OUTCOME.V], runner.q[runner.at].copy()))
        finals: list[tuple[float, Array, Code]] = []
        nearest = min(range(len(ends)), key=lambda number: ends[number][0])
        for number in {nearest: None, 0: None}:  # the caller's own start, too: alone it might have arrived
            code, calls, left = self._attempt(runner, ends[number][1], limit, recorder)
            iterations, escapes = iterations + calls, escapes + left
            finals.append((view[OUTCOME.V], runner.q[runner.at].copy(), code))
            if code is Code.DONE:
                break
        _, q, code = min(finals, key=lambda final: final[0])
        return Found(q, code, iterations, escapes, restarts)

    def prepare(self, request: Request) -> bool:
        """Make ``native.again()`` the search for this request; False where it cannot be."""
        if self.native is None or self._starts.wander or request.limit == 0:
            return False
        starts = self._starts.table(request.seed, request.restarts, self.native.q0) if request.restarts else None
        self.native.prepare(starts, request.restarts, request.limit, PATIENCE)
        return True

    def find_all(self, targets: Array, q0: Array, request: Request) -> list[tuple[Found | None, float]] | None:
        """Searches for each row of ``targets`` in one call, with their times [s]; None without the search in C.

        Where one is None something unusual is left to do: `find` does it.
        """
        if self.native is None or (len(q0) > 1 and self._starts.wander):
            return None
        starts = self._starts.table(request.seed, request.restarts, q0[0]) if request.restarts else None
        batch = self.native.batch(targets, q0, self._address(starts), request.restarts, request.limit, PATIENCE)
        found: list[tuple[Found | None, float]] = []
        rows = zip(batch.q, batch.errors.tolist(), batch.seconds.tolist(), batch.tallies.tolist(), strict=True)
        for q, errors, seconds, (code, iterations, number) in rows:
            last = _CODES[code] if code >= 0 else Code.STALLED
            told = (errors[0], errors[1]) if last is Code.DONE else None
            found.append((None if code < 0 else Found(q, last, iterations, 0, number, told), seconds))
        return found

    def _native_find(self, native: NativeSearch, q0: Array, starts: Array | None, request: Request) -> Found | None:
        """The same in C; None where something unusual is left to do."""
        code = native.find(q0, self._address(starts), request.restarts, request.limit, PATIENCE)
        if code < 0:
            return None
        iterations, number, at = native.tally.tolist()
        last = _CODES[code]
        return Found(native.runner.q[at].copy(), last, iterations, 0, number, _told(native.runner, last))

    def _address(self, starts: Array | None) -> int | None:
        """Where the configurations of a table are in memory."""
        if starts is None:
            return None
        if starts is not self._addressed[0]:
            self._addressed = starts, starts.ctypes.data
        return self._addressed[1]

    def _attempt(
        self, runner: Runner, q0: Array, limit: int, recorder: TraceRecorder | None, patience: float = math.inf
    ) -> tuple[Code, int, int]:
        """Call until the code says otherwise, or ``patience`` calls bring no progress.

        Returns the last code, the number of calls that tried a step, and the number of escapes.
        """
        runner.start(q0, patience)
        if recorder is not None:
            recorder.begin()
        calls, view = runner.calls, runner.view
        hurried = patience < math.inf  # an attempt that others can replace leaves only the pose it began in
        code, escapes, k, at = Code.GO_ON, 0, 0, 0
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
            stuck = code is Code.STALLED and escapes < (1 if hurried else MOST_ESCAPES) and (k == 1 or not hurried)
            if stuck and self._rescue.escape(runner.q[at], self._inputs):
                escapes += 1
                if recorder is not None:
                    recorder.escaped()
                runner.start(runner.q[at].copy(), patience)
                code, at = Code.GO_ON, 0
                continue
            if not view[OUTCOME.tried]:  # it stopped before it tried anything: no iteration
                k -= 1
                if recorder is not None:
                    recorder.forget()
            break
        runner.at = at
        return code, k, escapes


def _told(runner: Runner, code: Code) -> tuple[float, float] | None:
    view = runner.view
    return (view[OUTCOME.position_error], view[OUTCOME.orientation_error]) if code is Code.DONE else None


_CODES = tuple(Code)
