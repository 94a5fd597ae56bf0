"""The Solutions of where searches ended."""

from __future__ import annotations

import time
from functools import partial
from typing import Any

import numpy as np

from jtik._loop.inspection import Inspector
from jtik._loop.search.arrivals import SearchResult
from jtik._loop.search.jump import Jump
from jtik._step.inputs import InputMemory
from jtik.criterion import CriterionTerms
from jtik.result.report import Report
from jtik.result.solution import Solution
from jtik.result.status import Status, is_success
from jtik.types import Array


class Solutions:
    """Makes the Solutions of a solver.

    Args:
        terms: its criteria, which count the evaluations of those that are computed in Python.
        memory: the inputs of a search.
        inspector: inspects where it ended.
    """

    def __init__(self, terms: CriterionTerms, memory: InputMemory, inspector: Inspector) -> None:
        self._terms, self._memory, self._inspector = terms, memory, inspector
        self._evaluations_before = 0

    @property
    def numbers(self) -> Array:
        """The inputs, one after the other, where they are."""
        return self._memory.numbers

    def report(self, given: tuple[bytes, Any]) -> Report:
        """The report of a Solution that is made in C.

        Args:
            given: numbers of q and of the inputs, and the target as it was given.
        """
        numbers, target = np.frombuffer(given[0]).copy(), given[1]
        nq = len(numbers) - len(self._memory.numbers)
        return self._inspector.report(numbers[:nq], numbers[nq:], target)

    def begin(self) -> None:
        """Count the evaluations of the search that begins."""
        self._evaluations_before = self._terms.evaluations()

    def of(
        self, found: SearchResult, target: Any, options: tuple[Any, ...], begin: float, jump: Jump | None = None
    ) -> Solution:
        """The end of a search for the target in memory.

        Args:
            found: where it ended.
            target: the target as it was given.
            options: the options of the solve.
            begin: the time when it began.
            jump: the jump limit, where there is one.
        """
        inspection = self._inspector.snapshot(found.q, target, jump.box if jump else None)

        def diagnose() -> Status:
            status = inspection.status(found.code)
            return jump.status(status, inspection.q, inspection) if jump else status

        fields: dict[str, Any] = {"converged": False, "diagnose": diagnose}
        if not found.misses(*options[5:7]):
            status = diagnose()
            fields = {"status": status, "converged": is_success(status, options[-1])}
        return Solution.of(
            q=found.q,
            **fields,
            iterations=found.iterations,
            escapes=found.escapes,
            restarts=found.restarts,
            seconds=time.perf_counter() - begin,
            inspect=inspection,
            trace=None,
            alternatives=(),
            evaluations=self._terms.evaluations() - self._evaluations_before,
        )

    def converged(self, q: Array, iterations: int, restarts: int, target: Any, begin: float) -> Solution:
        """The end of a search in C that has converged, without a criterion."""
        return Solution.of(
            q=q,
            status=Status.CONVERGED,
            converged=True,
            iterations=iterations,
            escapes=0,
            restarts=restarts,
            seconds=time.perf_counter() - begin,
            inspect=partial(self._inspector.report, q.copy(), self._memory.numbers.copy(), target),
            trace=None,
        )
