"""The loop: from one start or from several to a configuration where there is nothing left to do.

An attempt calls the fused step until its code says otherwise. With restarts an attempt is given up as soon as it has
not lowered the error for a few calls, the next starts elsewhere, and when none arrives the best and the first are
carried to their ends.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik.fused import OUTCOME, Code
from jtik.recorder import Recorder
from jtik.rescue import Rescue
from jtik.robot import Robot
from jtik.runner import Runner

Array = NDArray[np.float64]

MOST_ESCAPES = 20
"""Second-order steps an attempt may take out of singular stalls."""

PATIENCE = 4.0
"""Calls without progress (``jtik.fused.FALL``) after which an attempt that others can replace is given up."""


class Request(NamedTuple):
    """What a search may spend: calls of an attempt, other starts, and the seed they are drawn with."""

    limit: int
    restarts: int
    seed: int


class Found(NamedTuple):
    """Where a search ended: configuration (nq,), the last code, calls that tried a step, escapes and restarts used."""

    q: Array
    code: Code
    iterations: int
    escapes: int
    restarts: int


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
        self._drawn: dict[int, list[Array]] = {}
        self._generators: dict[int, np.random.Generator] = {}

    def start(self, seed: int, number: int, about: Array) -> Array:
        """Restart ``number`` (from 0) of a search that began at ``about`` (nq,)."""
        drawn = self._drawn.setdefault(seed, [])
        while len(drawn) <= number:
            generator = self._generators.setdefault(seed, np.random.default_rng(seed))
            drawn.append(self._robot.random_configuration(generator))
        q = drawn[number]
        return q if self._anywhere is None else np.where(self._anywhere, q + about, q)


class Search:
    """Attempts on the memory of a solver: its inputs, target among them, are read where they are."""

    def __init__(self, robot: Robot, rescue: Rescue, inputs: Sequence[Array]) -> None:
        self._rescue, self._inputs = rescue, inputs
        self._starts = Starts(robot)
        self._settings = inputs[-1]

    def find(self, runner: Runner, q0: Array, request: Request, recorder: Recorder | None = None) -> Found:
        """From ``q0`` (nq,), then from other starts."""
        limit, restarts, seed = request
        if not restarts:
            code, calls, escapes = self._attempt(runner, q0, limit, recorder)
            return Found(runner.q[runner.at].copy(), code, calls, escapes, 0)
        settings, view = self._settings, runner.view
        ends: list[tuple[float, Array]] = []
        iterations, escapes = 0, 0
        for number in range(restarts + 1):
            settings[4] = PATIENCE
            start = q0 if number == 0 else self._starts.start(seed, number - 1, q0)
            code, calls, left = self._attempt(runner, start, limit, recorder)
            iterations, escapes = iterations + calls, escapes + left
            reached = view[OUTCOME.position_error] <= settings[0] and view[OUTCOME.orientation_error] <= settings[1]
            if code is Code.DONE or reached:
                return Found(runner.q[runner.at].copy(), code, iterations, escapes, number)
            ends.append((view[OUTCOME.V], runner.q[runner.at].copy()))
        settings[4] = math.inf
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

    def _attempt(self, runner: Runner, q0: Array, limit: int, recorder: Recorder | None) -> tuple[Code, int, int]:
        """Call until the code says otherwise; the last code, calls that tried a step, escapes."""
        runner.start(q0)
        calls, view = runner.calls, runner.view
        hurried = self._settings[4] < math.inf  # an attempt that others can replace leaves only the pose it began in
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
                runner.start(runner.q[at].copy())
                code, at = Code.GO_ON, 0
                continue
            if not view[OUTCOME.tried]:  # it stopped before it tried anything: no iteration
                k -= 1
                if recorder is not None:
                    recorder.forget()
            break
        runner.at = at
        return code, k, escapes


_CODES = tuple(Code)
