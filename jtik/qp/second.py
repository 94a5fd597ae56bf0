"""A step whose solver found no answer, taken again with another one that may."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.qp.backend import CalledBackend, Numbers, Solver
from jtik.qp.staged import Staged

Array = NDArray[np.float64]

UNTOUCHED = -1.0
"""No code of a step."""


class Nobody(CalledBackend):
    """Has no answer to anything: a step then says so, and stays where it is."""

    name = "nobody"
    accuracy = 0.0

    def solver(self, n: int, rows: int) -> Solver:
        """One that answers None."""
        return _Silent()


class _Silent(Solver):
    def solve(self, program: Numbers) -> Sequence[Array] | None:
        """None."""
        return None


def with_second(
    step: Callable[[], None], parts: Staged, unsolved: int, arguments: list[Array], results: list[Array]
) -> Callable[[], None]:
    """``step`` on this memory; where it ends ``unsolved``, or its solver fails, the same by the back end's second.

    Args:
        step: the parts joined by a fused back end, bound to ``arguments`` and ``results``.
        parts: what to bind again, the first time that it is needed.
        unsolved: the first number of ``results[2]`` after a step whose program has no answer.
        arguments, results: as in `Staged.bind`.
    """
    code: Any = memoryview(results[2].data)  # of doubles
    second = parts.backend.second
    bound: list[Callable[[], None]] = []

    def again() -> None:
        if not bound:
            bound.append(replace(parts, backend=second or Nobody()).bind(arguments, results))
        bound[0]()

    def guarded() -> None:
        code[0] = UNTOUCHED  # some plugins fail by leaving all results as they were
        try:
            step()
        except RuntimeError:  # how CasADi reports whatever goes wrong in a plugin, bounds that cross among it
            again()
        else:
            if code[0] == UNTOUCHED or (second and code[0] == unsolved):
                again()

    return guarded
