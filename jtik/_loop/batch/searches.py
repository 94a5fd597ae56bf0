"""The searches of a batch in this process: in C where the step runs there, and what is left by Python."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik._loop.batch.rows import BatchRows
from jtik._loop.inspection import Inspector
from jtik._loop.lanes.search import LaneSearch
from jtik._loop.native.compile_ahead import CompileAhead
from jtik._loop.native.search import NativeBatch
from jtik._loop.search.arrivals import SearchResult
from jtik._loop.search.search import Search, SearchOptions
from jtik._step.inputs import InputMemory
from jtik._step.stopping import Code
from jtik.result.status import Status, is_success
from jtik.types import Array


class BatchTargets(NamedTuple):
    """The targets of a batch, and where their solves begin.

    Attributes:
        given: the targets as they were given.
        numbers: the numbers of each, (k, size).
        starts: where each solve begins, one configuration for all, (1, nq), or one for each, (k, nq).
    """

    given: Sequence[Any] | Array
    numbers: Array
    starts: Array


class BatchSearches:
    """Solves for the targets of a batch.

    Args:
        search: finds the configuration for a target.
        memory: the inputs of the search.
        inspector: inspects where it ended.
        ahead: the steps that are being compiled.
        has_criterion: whether there is a criterion.
        find: the search in Python for the target that is in memory.
    """

    def __init__(
        self,
        search: Search,
        memory: InputMemory,
        inspector: Inspector,
        ahead: CompileAhead,
        *,
        has_criterion: bool,
        find: Callable[[Array, SearchOptions], SearchResult],
    ) -> None:
        self._search, self._memory, self._inspector = search, memory, inspector
        self._ahead, self._has_criterion, self._find = ahead, has_criterion, find

    def rows(
        self,
        chosen: NDArray[np.int64],
        targets: BatchTargets,
        options: tuple[Any, ...],
        search_options: SearchOptions,
        threads: int,
        lanes: LaneSearch | None = None,
    ) -> Iterator[BatchRows]:
        """The rows of the targets with these numbers, as they are done.

        Args:
            chosen: the numbers.
            targets: all targets.
            options: the options of the solves.
            search_options: those of their searches.
            threads: number of threads.
            lanes: the search in lanes; None for one target at a time in each thread.
        """
        starts, at = targets.starts, 0

        def row(i: int, found: SearchResult | None, seconds: float) -> BatchRows:
            begin = time.perf_counter()
            self._memory.inputs.target[:] = targets.numbers[i]
            if found is None:
                found = self._find(starts[i if len(starts) > 1 else 0], search_options)
            return self._row(i, found, targets.given[i], options, seconds - begin)

        while at < len(chosen):
            left: Any = slice(None) if len(chosen) - at == len(targets.numbers) else chosen[at:]
            own = starts if len(starts) == 1 else starts[left]
            blocks = self._search.find_all(targets.numbers[left], own, search_options, threads, lanes)
            if blocks is None:
                yield row(int(chosen[at]), None, 0.0)
                at += 1
                if self._ahead.waiting:
                    self._ahead.adopt()
                continue
            for first, batch, until in blocks:
                numbers, usual = chosen[at + first :][: len(batch.q)], self._usual(batch, options)
                edges = [0, *(np.flatnonzero(usual[1:] != usual[:-1]) + 1).tolist(), len(usual)]
                for begin, end in pairwise(edges):
                    if usual[begin]:
                        yield BatchRows.converged_rows(numbers[begin:end], batch, begin, end)
                    else:
                        for k in range(begin, end):
                            i = int(numbers[k])
                            if time.perf_counter() > until:
                                break
                            found = self._search.found(batch, k, targets.numbers[i])
                            if found is None and until < math.inf:  # Ctrl-C was pressed: no search begins
                                continue
                            yield row(i, found, float(batch.seconds[k]))
            return

    def _usual(self, batch: NativeBatch, options: tuple[Any, ...]) -> NDArray[np.bool_]:
        """Which rows have converged, so that nothing is left to do."""
        if self._has_criterion:
            return np.zeros(len(batch.q), dtype=bool)
        position, orientation = batch.errors.T
        within = (position <= options[5]) & (orientation <= options[6])
        return np.asarray(within & (batch.tallies[:, 0] == Code.DONE))

    def _row(self, i: int, found: SearchResult, given: Any, options: tuple[Any, ...], seconds: float) -> BatchRows:
        """The row of target number ``i``, which is in memory; its time is ``seconds`` after the clock."""
        errors = found.errors or self._inspector.errors(found.q, self._memory.inputs)
        diagnose: Callable[[], Status]
        if found._replace(errors=errors).misses(*options[5:7]):
            converged = False
            diagnose = partial(self._inspector.snapshot(found.q, given).status, found.code)
        else:
            status = self._inspector.current(found.q).status(found.code)
            converged, diagnose = is_success(status, options[-1]), partial(Status, status)
        return BatchRows(
            np.array([i]),
            found.q.reshape(1, -1),
            np.array([converged]),
            np.array([errors]),
            np.array([[found.iterations, found.escapes, found.restarts]]),
            np.array([time.perf_counter() + seconds]),
            {i: diagnose},
        )
