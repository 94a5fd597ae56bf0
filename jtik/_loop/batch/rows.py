"""Solving for many targets: the rows of a batch as arrays, as they come from this process, its threads or others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik._loop.native.search import NativeBatch
from jtik.progress import Progress, watched
from jtik.result.batch import SolutionBatch
from jtik.result.report import Report
from jtik.result.status import Status
from jtik.types import Array

if TYPE_CHECKING:
    from jtik._loop.batch.file import BatchFile
    from jtik._loop.batch.pool import BatchPool


class BatchRows(NamedTuple):
    """Solves of a batch, one a row.

    Attributes:
        numbers: numbers of their targets, (k,).
        q: where they ended, (k, nq).
        converged: whether each succeeded, (k,).
        errors: norms of position [m] and orientation [rad] rows of the error, (k, 2).
        counts: steps tried, saddle escapes and restarts used, (k, 3).
        seconds: wall time of each, (k,) [s].
        diagnose: computes why, by the number of the target; the status of all others is CONVERGED.
    """

    numbers: NDArray[np.int64]
    q: Array
    converged: NDArray[np.bool_]
    errors: Array
    counts: NDArray[np.int64]
    seconds: Array
    diagnose: dict[int, Callable[[], Status]]

    def settled(self) -> BatchRows:
        """The same with statuses that are known, which another process can read."""
        return self._replace(diagnose={i: partial(Status, diagnose()) for i, diagnose in self.diagnose.items()})

    def single(self) -> Iterator[BatchRows]:
        """Each row by itself."""
        for k, i in enumerate(self.numbers.tolist()):
            diagnose = {i: self.diagnose[i]} if i in self.diagnose else {}
            columns = [column[k : k + 1] for column in self[:-1]]
            yield BatchRows._make([*columns, diagnose])

    @classmethod
    def converged_rows(cls, numbers: NDArray[np.int64], batch: NativeBatch, begin: int, end: int) -> BatchRows:
        """Rows of a batch in C that have converged.

        Args:
            numbers: numbers of their targets.
            batch: the batch.
            begin: the first row.
            end: the row after the last.
        """
        counts = np.zeros((end - begin, 3), dtype=np.int64)
        counts[:, ::2] = batch.tallies[begin:end, 1:]
        q, errors, seconds = batch.q[begin:end], batch.errors[begin:end], batch.seconds[begin:end]
        return cls(numbers, q, np.ones(end - begin, dtype=bool), errors, counts, seconds, {})

    @classmethod
    def joined(cls, parts: list[BatchRows], nq: int) -> BatchRows:
        """The rows of several parts, in the order of the numbers of their targets.

        Args:
            parts: the parts.
            nq: length of a configuration.
        """
        if not parts:
            empty = np.zeros(0), np.zeros((0, nq)), np.zeros(0, dtype=bool), np.zeros((0, 2)), np.zeros((0, 3))
            numbers, q, converged, errors, counts = empty
            return cls(numbers.astype(np.int64), q, converged, errors, counts.astype(np.int64), np.zeros(0), {})
        parts = (
            sorted((part for part in parts if len(part.numbers)), key=lambda part: int(part.numbers[0])) or parts[:1]
        )
        if len(parts) == 1:
            return parts[0]
        columns = [np.concatenate(column) for column in zip(*[part[:-1] for part in parts], strict=True)]
        numbers = columns[0]
        if (numbers[1:] < numbers[:-1]).any():  # the parts overlap
            order = np.argsort(numbers)
            columns = [column[order] for column in columns]
        return cls._make([*columns, {i: each for part in parts for i, each in part.diagnose.items()}])


def solved(
    count: int,
    nq: int,
    solve: Callable[[NDArray[np.int64]], Iterator[BatchRows]],
    *,
    pool: BatchPool | None,
    file: BatchFile,
    progress: Progress,
) -> BatchRows:
    """The rows of all targets, or of those that were done when Ctrl-C was pressed.

    Args:
        count: number of targets.
        nq: length of a configuration.
        solve: solves for targets in this process.
        pool: solves in other processes; None for none.
        file: where rows are kept while the batch runs, and those that were known before.
        progress: as in `InverseKinematics.solve_batch`.
    """
    known = file.known
    left = np.ones(count, dtype=bool)
    left[known.numbers] = False
    missing = np.flatnonzero(left)
    parts = [known]
    solving: Iterable[BatchRows] = solve(missing) if pool is None else pool.solving(missing)
    if progress is not False:
        solving = watched(_Single(len(missing), solving), progress, "targets")
    try:
        for rows in solving:
            parts.append(rows)
            file.add(parts)
    except KeyboardInterrupt:
        if pool is not None:
            seen = {*BatchRows.joined(parts, nq).numbers.tolist()}
            parts += [row for rows in pool.finished() for row in rows.single() if int(row.numbers[0]) not in seen]
    finally:
        if pool is not None:
            pool.cancel()
        file.write(parts)
    return BatchRows.joined(parts, nq)


class _Single:
    """Rows one by one, with their number."""

    def __init__(self, count: int, solving: Iterable[BatchRows]) -> None:
        self._count, self._solving = count, solving

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[BatchRows]:
        return (row for rows in self._solving for row in rows.single())


def collect(rows: BatchRows, *, targets: Array, inspect: Callable[[int, Array], Report]) -> SolutionBatch:
    """The columns of all rows.

    Args:
        rows: the solves, in the order of their targets.
        targets: the numbers of all targets, (k, size).
        inspect: computes the report of a configuration for the target with a number.
    """
    numbers = rows.numbers
    complete = len(numbers) == len(targets)

    def diagnose() -> tuple[Status, ...]:
        statuses = [Status.CONVERGED] * len(numbers)
        for k, i in enumerate(numbers.tolist()) if rows.diagnose else ():
            if i in rows.diagnose:
                statuses[k] = rows.diagnose[i]()
        return tuple(statuses)

    return SolutionBatch.of(
        diagnose=diagnose,
        q=rows.q.copy(),
        converged=rows.converged,
        position_error=rows.errors[:, 0].copy(),
        orientation_error=rows.errors[:, 1].copy(),
        iterations=rows.counts[:, 0].copy(),
        escapes=rows.counts[:, 1].copy(),
        restarts=rows.counts[:, 2].copy(),
        seconds=rows.seconds,
        targets=np.zeros((0, 0)) if not len(numbers) else targets.copy() if complete else targets[numbers],
        indices=numbers,
        complete=complete,
        inspect=lambda row: inspect(int(numbers[row]), rows.q[row].copy()),
    )
