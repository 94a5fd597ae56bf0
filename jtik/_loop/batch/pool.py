"""Solving for many targets in other processes: each rebuilds the solver once and keeps it."""

from __future__ import annotations

import hashlib
import pickle
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future, as_completed
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jtik._loop.pickling import PICKLABLE, pickler
from jtik.errors import ArgumentError, JtikError
from jtik.types import Array

if TYPE_CHECKING:
    from jtik._loop.batch.rows import BatchRows
    from jtik._loop.copying import FixedSolver

_solvers: dict[str, FixedSolver] = {}
"""The last solver of this process, by the hash of its pickle."""

_busy = threading.Lock()
"""Allows one block at a time, because an executor may be one of threads: a solver belongs to one thread."""


class BatchPool:
    """The blocks of one batch, solved by an executor.

    Args:
        executor: the executor.
        solver: the solver.
        block: number of targets that are sent at once.
        numbers: the numbers of all targets, (k, size).
        starts: where each solve begins; one configuration for all, (1, nq), or one for each, (k, nq).
        options: the options of the solves.
        lanes: whether several targets are solved side by side.

    Raises:
        ArgumentError: when the solver cannot be pickled.
    """

    def __init__(
        self,
        executor: Executor,
        solver: FixedSolver,
        block: int,
        *,
        numbers: Array,
        starts: Array,
        options: Any,
        lanes: bool = False,
    ) -> None:
        self._executor, self._block = executor, block
        self._numbers, self._starts, self._options, self._lanes = numbers, starts, options, lanes
        try:
            self._data = pickler().dumps(solver, protocol=pickle.HIGHEST_PROTOCOL)
        except Exception as error:  # what is pickled may raise anything
            raise ArgumentError("executor", f"a solver that cannot be pickled: {error}", PICKLABLE) from error
        self._name = hashlib.sha256(self._data).hexdigest()
        self._futures: dict[Future[BatchRows], NDArray[np.int64]] = {}

    def solving(self, missing: NDArray[np.int64]) -> Iterator[BatchRows]:
        """Solve for the targets with these numbers; the rows come as they are done."""
        for first in range(0, len(missing), self._block):
            own = missing[first : first + self._block]
            starts = self._starts if len(self._starts) == 1 else self._starts[own]
            block = self._numbers[own], starts, self._options, self._lanes
            future = self._executor.submit(solve_block, self._name, self._data, *block)
            self._futures[future] = own
        for future in as_completed(self._futures):
            yield self._rows(future)

    def cancel(self) -> None:
        """Cancel the blocks that have not begun."""
        for future in self._futures:
            future.cancel()

    def finished(self) -> list[BatchRows]:
        """The rows of all blocks that are done; no other block begins."""
        self.cancel()
        done = [each for each in self._futures if each.done() and not each.cancelled() and each.exception() is None]
        return [self._rows(future) for future in done]

    def _rows(self, future: Future[BatchRows]) -> BatchRows:
        """The rows of a block, with the numbers of their targets in the whole batch."""
        own, rows = self._futures[future], future.result()
        numbers = own.tolist()
        return rows._replace(numbers=own, diagnose={numbers[k]: each for k, each in rows.diagnose.items()})


def solve_block(name: str, data: bytes, numbers: Array, starts: Array, options: Any, lanes: bool = False) -> BatchRows:
    """Solve for targets in the process that calls this, with the solver of a pickle.

    Raises:
        JtikError: when the solver cannot be rebuilt in this process.
    """
    with _busy:
        if name not in _solvers:
            try:
                solver = pickle.loads(data)
            except Exception as error:  # what is imported may raise anything
                raise JtikError(
                    f"executor: a process cannot rebuild the solver ({error}); accepted: {PICKLABLE}"
                ) from error
            _solvers.clear()
            _solvers[name] = solver
        return _solvers[name]._engine.solving.solve_numbers(numbers, starts, options, lanes)
