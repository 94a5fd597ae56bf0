"""A step taken without a solver where that will do, with one where not, and with another where that has no answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any

from jtik.qp.backend import CalledBackend, Numbers, Solver
from jtik.qp.call import outputs_of
from jtik.qp.staged import Staged
from jtik.symbolic import Function
from jtik.symbolic.compile import bind
from jtik.types import Array

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


def near_or_far(
    whole: Function, parts: Staged, unsolved: int, arguments: list[Array], results: list[Array]
) -> Callable[[], None]:
    """The step on this memory: without a solver, else by the back end's, else, if that has no answer, by its second.

    Args:
        whole: the parts joined by a fused back end.
        parts: what to bind in its place.
        unsolved: the first number of ``results[2]`` after a step whose program has no answer.
        arguments, results: as in `Staged.bind`.
    """
    again = _Again(parts, arguments, results)
    if parts.near is None:
        return _guarded(bind(whole, arguments, results), again, unsolved)
    holding, *between = outputs_of(parts.near)[len(results) :]
    holds: Any = memoryview(holding.data)
    near = bind(parts.near, arguments, [*results, holding, *between])
    far = _guarded(bind(parts.far(), [*arguments, *between], results), again, unsolved)

    def step() -> None:
        near()
        if not holds[0]:
            far()

    return step


class _Again:
    """The step by the back end's second, bound the first time that it is needed."""

    def __init__(self, parts: Staged, arguments: list[Array], results: list[Array]) -> None:
        self._parts, self._arguments, self.results = parts, arguments, results
        self.second = parts.backend.second

    @cached_property
    def step(self) -> Callable[[], None]:
        """The call."""
        return replace(self._parts, backend=self.second or Nobody()).bind(self._arguments, self.results)


def _guarded(step: Callable[[], None], again: _Again, unsolved: int) -> Callable[[], None]:
    """``step``; where it ends ``unsolved``, or its solver fails, again."""
    code: Any = memoryview(again.results[2].data)  # of doubles
    second = again.second is not None

    def guarded() -> None:
        code[0] = UNTOUCHED  # some plugins fail by leaving all results as they were
        try:
            step()
        except RuntimeError:  # how CasADi reports whatever goes wrong in a plugin, bounds that cross among it
            again.step()
        else:
            if code[0] == UNTOUCHED or (second and code[0] == unsolved):
                again.step()

    return guarded
