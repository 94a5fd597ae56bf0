"""Solving for many targets: the entries of a batch, one after the other or by other processes, and their columns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from functools import partial
from typing import NamedTuple

import numpy as np

from jtik._loop.batch_file import BatchFile
from jtik._loop.batch_pool import BatchPool
from jtik.progress import Progress, watched
from jtik.result.batch import SolutionBatch
from jtik.result.report import Report
from jtik.result.status import Status
from jtik.types import Array


class BatchEntry(NamedTuple):
    """One solve of a batch.

    Attributes:
        q: where it ended, (nq,).
        diagnose: computes why.
        converged: whether the solve succeeded.
        errors: norms of position [m] and orientation [rad] rows of the error.
        iterations: steps tried.
        escapes: saddle escapes.
        restarts: restarts used.
        seconds: wall time [s].
    """

    q: Array
    diagnose: Callable[[], Status]
    converged: bool
    errors: tuple[float, float]
    iterations: int
    escapes: int
    restarts: int
    seconds: float

    def settled(self) -> BatchEntry:
        """The same with a status that is known, which another process can read."""
        return self._replace(diagnose=partial(Status, self.diagnose()))


def solved(
    count: int,
    solve: Callable[[list[int]], Iterator[BatchEntry]],
    *,
    pool: BatchPool | None,
    file: BatchFile,
    progress: Progress,
) -> dict[int, BatchEntry]:
    """The entries by the number of their target; all of them, or those that were done when Ctrl-C was pressed.

    Args:
        count: number of targets.
        solve: solves for targets in this process.
        pool: solves in other processes; None for none.
        file: where entries are kept while the batch runs, and those that were known before.
        progress: as in `InverseKinematics.solve_batch`.
    """
    entries = file.entries()
    missing = [i for i in range(count) if i not in entries]
    solving: Iterable[tuple[int, BatchEntry]]
    solving = zip(missing, solve(missing), strict=True) if pool is None else pool.solving(missing)
    try:
        for i, entry in watched(_Counted(len(missing), solving), progress, "targets"):
            entries[i] = entry
            file.add(entries)
    except KeyboardInterrupt:
        if pool is not None:
            entries.update(pool.leftover())
    finally:
        if pool is not None:
            pool.cancel()
        file.write(entries)
    return entries


class _Counted:
    """Items with their number."""

    def __init__(self, count: int, items: Iterable[tuple[int, BatchEntry]]) -> None:
        self._count, self._items = count, items

    def __len__(self) -> int:
        return self._count

    def __iter__(self) -> Iterator[tuple[int, BatchEntry]]:
        return iter(self._items)


def collect(
    entries: Mapping[int, BatchEntry],
    *,
    targets: list[Array],
    nq: int,
    inspect: Callable[[int, Array], Report],
) -> SolutionBatch:
    """The columns of all entries, in the order of their targets.

    Args:
        entries: the solves, by the number of their target.
        targets: the numbers of all targets.
        nq: length of a configuration.
        inspect: computes the report of a configuration for the target with a number.
    """
    count, numbers = len(entries), sorted(entries)
    rows = [entries[i] for i in numbers]
    errors = np.array([entry.errors for entry in rows], dtype=np.float64).reshape(count, 2)
    return SolutionBatch.of(
        diagnose=lambda: tuple(entry.diagnose() for entry in rows),
        q=np.array([entry.q for entry in rows]).reshape(count, nq),
        converged=np.array([entry.converged for entry in rows], dtype=bool),
        position_error=errors[:, 0],
        orientation_error=errors[:, 1],
        iterations=np.array([entry.iterations for entry in rows], dtype=np.int64),
        escapes=np.array([entry.escapes for entry in rows], dtype=np.int64),
        restarts=np.array([entry.restarts for entry in rows], dtype=np.int64),
        seconds=np.array([entry.seconds for entry in rows], dtype=np.float64),
        targets=np.array([targets[i] for i in numbers]).reshape(count, -1) if count else np.zeros((0, 0)),
        indices=np.array(numbers, dtype=np.int64),
        complete=count == len(targets),
        inspect=lambda row: inspect(numbers[row], rows[row].q.copy()),
    )
