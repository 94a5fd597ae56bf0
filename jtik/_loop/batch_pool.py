"""Solving for many targets in other processes: each rebuilds the solver once and keeps it."""

from __future__ import annotations

import hashlib
import pickle
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future, as_completed
from typing import TYPE_CHECKING, Any

from jtik._loop.pickling import PICKLABLE, pickler
from jtik.errors import ArgumentError, JtikError
from jtik.types import Array

if TYPE_CHECKING:
    from jtik._loop.batch import BatchEntry
    from jtik._loop.copying import FixedSolver

Rows = list[tuple[int, "BatchEntry"]]

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
        numbers: the numbers of all targets.
        starts: where each solve begins; one configuration for all, or one for each.
        options: the options of the solves.

    Raises:
        ArgumentError: when the solver cannot be pickled.
    """

    def __init__(
        self,
        executor: Executor,
        solver: FixedSolver,
        block: int,
        *,
        numbers: list[Array],
        starts: list[Array],
        options: Any,
    ) -> None:
        self._executor, self._block = executor, block
        self._numbers, self._starts, self._options = numbers, starts, options
        try:
            self._data = pickler().dumps(solver, protocol=pickle.HIGHEST_PROTOCOL)
        except Exception as error:  # what is pickled may raise anything
            raise ArgumentError("executor", f"a solver that cannot be pickled: {error}", PICKLABLE) from error
        self._name = hashlib.sha256(self._data).hexdigest()
        self._futures: dict[Future[list[BatchEntry]], list[int]] = {}
        self._yielded: set[int] = set()

    def solving(self, missing: list[int]) -> Iterator[tuple[int, BatchEntry]]:
        """Solve for the targets with these numbers; the entries come as they are done."""
        for first in range(0, len(missing), self._block):
            own = missing[first : first + self._block]
            starts = self._starts if len(self._starts) == 1 else [self._starts[i] for i in own]
            numbers = [self._numbers[i] for i in own]
            future = self._executor.submit(solve_block, self._name, self._data, numbers, starts, self._options)
            self._futures[future] = own
        for future in as_completed(self._futures):
            for i, entry in zip(self._futures[future], future.result(), strict=True):
                self._yielded.add(i)
                yield i, entry

    def cancel(self) -> None:
        """Cancel the blocks that have not begun."""
        for future in self._futures:
            future.cancel()

    def leftover(self) -> Rows:
        """Entries that are done and that were not yielded."""
        self.cancel()
        rows: Rows = []
        for future, own in self._futures.items():
            if future.done() and not future.cancelled() and future.exception() is None:
                rows += [row for row in zip(own, future.result(), strict=True) if row[0] not in self._yielded]
        return rows


def solve_block(name: str, data: bytes, numbers: list[Array], starts: list[Array], options: Any) -> list[BatchEntry]:
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
        return _solvers[name]._engine.solving.solve_numbers(numbers, starts, options)
