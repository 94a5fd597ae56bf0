"""Solving for many targets: the entries of a batch, collected into columns."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from jtik._loop.arrivals import SearchResult
from jtik.result.batch import SolutionBatch
from jtik.result.report import Report
from jtik.result.status import Status
from jtik.types import Array


class BatchEntry(NamedTuple):
    """One solve of a batch.

    Attributes:
        found: where it ended.
        diagnose: computes why.
        converged: whether the solve succeeded.
        errors: norms of position [m] and orientation [rad] rows of the error.
        seconds: wall time [s].
    """

    found: SearchResult
    diagnose: Callable[[], Status]
    converged: bool
    errors: tuple[float, float]
    seconds: float


def collect(
    entries: Sequence[BatchEntry],
    *,
    targets: Sequence[Array],
    nq: int,
    inspect: Callable[[int], Report],
) -> SolutionBatch:
    """The columns of all entries.

    Args:
        entries: the solves.
        targets: the numbers that each was solved for.
        nq: length of a configuration.
        inspect: computes the report of a row.
    """
    count = len(entries)
    errors = np.array([entry.errors for entry in entries], dtype=np.float64).reshape(count, 2)
    return SolutionBatch.of(
        diagnose=lambda: tuple(entry.diagnose() for entry in entries),
        q=np.array([entry.found.q for entry in entries]).reshape(count, nq),
        converged=np.array([entry.converged for entry in entries], dtype=bool),
        position_error=errors[:, 0],
        orientation_error=errors[:, 1],
        iterations=np.array([entry.found.iterations for entry in entries], dtype=np.int64),
        escapes=np.array([entry.found.escapes for entry in entries], dtype=np.int64),
        restarts=np.array([entry.found.restarts for entry in entries], dtype=np.int64),
        seconds=np.array([entry.seconds for entry in entries], dtype=np.float64),
        targets=np.array(targets).reshape(count, -1) if count else np.zeros((0, 0)),
        inspect=inspect,
    )
