"""An attempt of a search in Python: the calls of the fused step from one configuration until their code ends it."""

from __future__ import annotations

import math
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik._loop.escapes.criterion import Escapes
from jtik._loop.escapes.level_newton import LevelNewton
from jtik._loop.runner import Runner
from jtik._loop.search.continuum import Continuum
from jtik._loop.search.full_turns import FullTurns
from jtik._loop.trace_recorder import TraceRecorder
from jtik._step.inputs import Inputs, Settings
from jtik._step.solve_progress import STUCK
from jtik._step.stopping import OUTCOME, Code
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.result.length import length
from jtik.symbolic import function
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

PAUSE = 2.0 * STUCK
"""Calls without progress after which an attempt with levels of priority is interrupted first."""

NEAR = 0.02
"""Largest fall of the highest level's V, relative to |J| |r|, for which a solve has nearly arrived [rad]."""

ROUNDING = 1e-9
"""Relative error of such an error."""

MAX_ESCAPES = 20
"""Largest number of escapes of an attempt."""


class Ended(NamedTuple):
    """How an attempt ended.

    Attributes:
        code: code of the last call.
        calls: calls that tried a step.
        escapes: escapes from saddle points.
    """

    code: Code
    calls: int
    escapes: int


class Attempts:
    """Runs attempts on the memory of a runner.

    Args:
        problem: the problem.
        escapes: from saddle points of the error and of the criterion.
        turns: the joints that can turn all the way round.
        inputs: the inputs of a search, in which the limits of these joints are infinite.

    Attributes:
        continuum: the continua of singular poses on target.
        levels: leads levels of priority to rest where the highest is out of reach.
    """

    def __init__(self, problem: SymbolicProblem, escapes: Escapes, turns: FullTurns, inputs: Inputs[Array]) -> None:
        self._problem, self._escapes, self._turns, self._inputs = problem, escapes, turns, inputs
        self._linear = np.array(problem.linear, dtype=bool)
        self.continuum = Continuum(problem, turns)
        self.levels = LevelNewton(problem)

    @cached_property
    def _criterion(self) -> CompiledFunction:
        return CompiledFunction(self._problem.criterion)

    def criterion(self, q: Array) -> float:
        """H at q."""
        return float(self._criterion(q, self._inputs.parameters)[0][0, 0])

    @cached_property
    def _error(self) -> CompiledFunction:
        problem = self._problem
        q, target, _ = problem.symbols()
        both = [problem.error(q, target), problem.residual(q, target)]
        return CompiledFunction(function("errors", [q, target], both))

    def on_target(self, q: Array) -> bool:
        """Whether q is on the target, within the tolerances."""
        return within_tolerances(self._error(q, self._inputs.target)[0][:, 0], self._linear, self._inputs)

    def level_errors(self, q: Array) -> tuple[float, ...]:
        """Norm of the residual of each level of priority at q, the highest first; 0 of a level on its target."""
        error, residual = (each[:, 0] for each in self._error(q, self._inputs.target))
        return tuple(
            0.0 if within_tolerances(error[rows], self._linear[rows], self._inputs) else length(residual[rows])
            for rows in map(list, self._problem.levels)
        )

    def run(
        self, runner: Runner, q0: Array, limit: int, recorder: TraceRecorder | None, patience: float = math.inf
    ) -> Ended:
        """An attempt from ``q0``.

        Args:
            runner: the runner, which then holds where the attempt ended.
            q0: where it begins, (nq,).
            limit: largest number of calls.
            recorder: records the calls; None for none.
            patience: calls without progress after which it ends.
        """
        runner.start(q0, patience_of(runner, patience))
        if recorder is not None:
            recorder.begin()
        return self.go_on(runner, limit, recorder, patience)

    def go_on(
        self,
        runner: Runner,
        limit: int,
        recorder: TraceRecorder | None = None,
        patience: float = math.inf,
        *,
        code: Code = Code.CONTINUE,
        calls: int = 0,
    ) -> Ended:
        """The rest of an attempt, whose last call was number ``calls`` and returned ``code``.

        Where the error has stopped falling and the strategy explores, the exploring step goes on from the same state.
        """
        step, view, k, at, escapes = runner.calls, runner.view, calls, runner.at, 0
        while True:
            if code is Code.CONTINUE:
                if k >= limit:
                    break
                if recorder is not None:
                    recorder.before(runner.q[at])
                step[at]()
                at = 1 - at
                k += 1
                if recorder is not None:
                    recorder.after()
                if view[0] == 0.0:
                    continue
                code = _CODES[int(view[0])]
            if code is Code.SLOW and runner.explorer is not None and patience == math.inf:
                runner.at, explorer = at, runner.explorer()
                explorer.take_over(runner)
                ended = self.go_on(explorer, limit, recorder, calls=k - 1)
                explorer.hand_back(runner)
                return ended._replace(escapes=escapes + ended.escapes)
            if code is Code.SLOW and runner.pauses and patience == math.inf:
                runner.at, k = at, k - 1
                if recorder is not None:
                    recorder.discard()
                if self._rests(runner):
                    return Ended(Code.STALLED, k, escapes)
                at = runner.at = 1 - at  # the call is repeated, from the same configuration with the same state
                runner.wait()
                code = Code.CONTINUE
                continue
            if code is Code.DONE:
                patience = math.inf  # the attempt has reached the target: no restart replaces it
            replaceable = patience < math.inf  # an attempt that a restart can replace only escapes where it began
            may_escape = escapes < (1 if replaceable else MAX_ESCAPES) and (k == 1 or not replaceable)
            if may_escape and self._escapes.escape(code, runner.q[at], runner.inputs):
                escapes += 1
                if recorder is not None:
                    recorder.escaped()
                runner.start(runner.q[at].copy(), patience_of(runner, patience))
                code, at = Code.CONTINUE, 0
                continue
            if not view[OUTCOME.tried]:  # the call stopped before it tried a step: not an iteration
                k -= 1
                if recorder is not None:
                    recorder.discard()
            break
        runner.at = at
        return Ended(code, k, escapes)

    def _rests(self, runner: Runner) -> bool:
        """Lead a runner's q to where all levels of priority rest, if the highest is about as near as it can be."""
        q = runner.q[runner.at]
        before = self.level_errors(q)[0]
        if before == 0.0:
            return False
        rest = q.copy()
        if not self.levels.reach(rest, runner.inputs):
            return False
        after = self.level_errors(rest)[0]
        fall = (before - after) * (before + after) / 2
        near = -ROUNDING * before**2 <= fall <= NEAR * self.levels.scale(q, runner.inputs)
        if near:
            q[:] = rest
            error, residual = (each[:, 0] for each in self._error(q, self._inputs.target))
            errors = length(error[self._linear]), length(error[~self._linear])
            runner.outcome[[OUTCOME.position_error, OUTCOME.orientation_error, OUTCOME.V]] = (
                *errors,
                residual @ residual / 2,
            )
        return near

    def can_go_on(self, q: Array, target: Array | None = None) -> bool:
        """Whether q, on target and stationary, is a saddle point or a maximum of the criterion.

        Args:
            q: where an attempt has ended, (nq,).
            target: its target, as numbers; that in memory by default.
        """
        inputs = self._inputs if target is None else self._inputs._replace(target=target)
        return self._escapes.criterion.needed(q, inputs) is not None

    def bring_back(
        self, runner: Runner, ended: Ended, reference: Array, limit: int, recorder: TraceRecorder | None
    ) -> Ended:
        """Bring the joints that moved without limits to the turn nearest to ``reference``, within their limits.

        Where no turn lies within the limits, or where another turn changes the criterion, the attempt goes on from
        there with all limits in force, as far as ``limit`` calls in all allow.
        """
        turns, q = self._turns, runner.q[runner.at]
        turned, fits = turns.nearest(q, reference)
        moved = bool((turned[turns.indices] != q[turns.indices]).any())
        if fits and moved and self._problem.has_criterion:
            if not self.criterion(turned) <= self.criterion(q):
                turned, _ = turns.nearest(q, q)  # only as far as the limits require
                moved = bool((turned[turns.indices] != q[turns.indices]).any())
            fits = not moved
        q[:] = turned
        if fits or ended.code is Code.NOT_FINITE:
            return ended
        lower, upper, where = self._inputs.lower, self._inputs.upper, turns.indices
        lower[where], upper[where] = turns.lower, turns.upper
        try:
            again = self.run(runner, turned, max(limit - ended.calls, 0), recorder)
        finally:
            lower[where], upper[where] = -np.inf, np.inf
        return Ended(again.code, ended.calls + again.calls, ended.escapes + again.escapes)


def within_tolerances(error: Array, linear: NDArray[np.bool_], inputs: Inputs[Array]) -> bool:
    """Whether the rows of an error, in [m] where ``linear`` and else in [rad], are within the tolerances."""
    settings = Settings(*inputs.settings.tolist())
    on_position = length(error[linear]) <= settings.position_tolerance
    return bool(on_position and length(error[~linear]) <= settings.orientation_tolerance)


def patience_of(runner: Runner, patience: float) -> float:
    """Calls without progress after which the step ends an attempt: also where it is interrupted."""
    if patience == math.inf and runner.pauses:
        return PAUSE
    return STUCK if patience == math.inf and runner.explorer is not None else patience


_CODES = tuple(Code)
