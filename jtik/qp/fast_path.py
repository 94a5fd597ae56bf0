"""One step on bound memory: by the fast path (no QP needed), the QP path, or the QP path with a fallback solver."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from enum import Enum
from typing import Any

import numpy as np

from jtik.qp.backend import CalledBackend, NumericQP, QPSolver
from jtik.qp.call import in_turn, output_memory
from jtik.qp.staged import Staged
from jtik.symbolic import Function
from jtik.symbolic.compile import bind
from jtik.types import Array

NOT_WRITTEN = -1.0
"""A value that is no code of a step: it shows that a step has not written its results."""


class NoBackend(CalledBackend):
    """A back end that solves no QP: the step then reports an unsolved QP and does not change q."""

    name = "none"
    accuracy = 0.0

    def solver(self, n: int, rows: int) -> QPSolver:
        """A solver that returns None."""
        return _NoSolver()


class _NoSolver(QPSolver):
    """A solver that never finds a solution."""

    def solve(self, qp: NumericQP) -> Sequence[Array] | None:
        """Return None: there is no solution."""
        return None


def fast_or_qp_path(
    joined: Function,
    parts: Staged,
    unsolved: int,
    arguments: list[Array],
    results: list[Array],
    expected: list[StepPath],
) -> Callable[[], None]:
    """The step as a call on this memory.

    It uses the fast path where no QP has to be solved, else the QP path with the back end; if that finds no solution,
    the QP path with the back end's fallback. A step begins with the path that the step before it has needed: the paths
    agree up to rounding.

    Args:
        joined: the parts joined by a fused back end.
        parts: the parts of the step.
        unsolved: value of ``results[2][0]`` after a step whose QP was not solved.
        arguments: memory of the step's inputs, as in `Staged.bind`.
        results: memory of the step's outputs, as in `Staged.bind`.
        expected: the path that the next step begins with, one entry; shared by the calls that follow one another.
    """
    fallback = _Fallback(parts, arguments, results)
    if parts.fast_path is None:
        return _with_fallback(bind(joined, arguments, results), fallback, unsolved, results)
    valid, *between = output_memory(parts.fast_path)[len(results) :]
    no_qp_needed: Any = memoryview(valid.data)
    fast_path = bind(parts.fast_path, arguments, [*results, valid, *between])
    local = between[: parts.local.n_out()]
    begin, rest, known = parts.bound_stages(arguments, results, local, between[len(local) :])
    known_results: Any = known
    qp_path = _with_fallback(in_turn(rest), fallback, unsolved, results)
    unneeded = np.zeros(1)
    direct_was_unneeded: Any = memoryview(unneeded.data)
    direct_path = fast_path
    if parts.direct_path is not None:
        direct_path = bind(parts.direct_path, arguments, [*results, valid, *between, unneeded])

    def path_needed() -> StepPath:
        """The path that this step has needed."""
        needed = StepPath.FAST
        for is_known, direct_taken in known_results:
            if not is_known[0]:
                if direct_taken is None or not direct_taken[0]:
                    return StepPath.QP
                needed = StepPath.DIRECT
        return needed

    def step() -> None:
        if expected[0] is StepPath.FAST:
            fast_path()
            if not no_qp_needed[0]:
                qp_path()
                expected[0] = path_needed()
        elif expected[0] is StepPath.DIRECT:
            direct_path()
            if not no_qp_needed[0]:
                qp_path()
                expected[0] = path_needed()
            elif direct_was_unneeded[0]:
                expected[0] = StepPath.FAST
        else:  # the end of the step is evaluated once, not by the fast path as well
            for call in begin:
                call()
            qp_path()
            expected[0] = path_needed()

    return step


class StepPath(Enum):
    """What a step begins with: the fast path, the direct path, or the stages of the QP path."""

    FAST = 0
    DIRECT = 1
    QP = 2


class _Fallback:
    """The step with the back end's fallback."""

    def __init__(self, parts: Staged, arguments: list[Array], results: list[Array]) -> None:
        backend = parts.backend.fallback
        self.solves = backend is not None
        self.step = replace(parts, backend=backend or NoBackend()).bind(arguments, results)


def _with_fallback(
    step: Callable[[], None], fallback: _Fallback, unsolved: int, results: list[Array]
) -> Callable[[], None]:
    """``step``, repeated with the fallback if it ends ``unsolved`` or its solver fails."""
    code: Any = memoryview(results[2].data)  # of doubles

    def guarded() -> None:
        code[0] = NOT_WRITTEN  # some plugins fail by leaving all results as they were
        try:
            step()
        except RuntimeError:  # how CasADi reports any failure of a plugin, such as crossed bounds
            fallback.step()
        else:
            if code[0] == NOT_WRITTEN or (fallback.solves and code[0] == unsolved):
                fallback.step()

    return guarded
