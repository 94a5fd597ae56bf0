"""Many targets solved one after the other, as arrays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik._loop.search import Found
from jtik.errors import ArgumentError
from jtik.result.report import Report
from jtik.result.solution import Solution, Status
from jtik.task import TaskStack
from jtik.types import Array


class Entry(NamedTuple):
    """One solve of a batch: where it ended and why, whether that was asked for, errors [m] and [rad], and time [s]."""

    found: Found
    status: Status
    converged: bool
    errors: tuple[float, float]
    seconds: float


@dataclass(frozen=True, eq=False, repr=False)
class SolutionBatch:
    """Solutions of k targets, a column of each figure; ``batch[i]`` is the `Solution` of target i.

    Attributes:
        q: configurations, (k, nq) [rad] and [m].
        statuses: why each stopped.
        converged: whether what was asked for was achieved, (k,).
        position_error, orientation_error: norms of the error at q, (k,) [m] and (k,) [rad].
        iterations, escapes, restarts: as of a Solution, (k,).
        seconds: wall time of each solve, (k,) [s].
        targets: the numbers each was solved for, (k, target size).
        look: the report of a configuration for such numbers.
    """

    q: Array
    statuses: tuple[Status, ...]
    converged: NDArray[np.bool_]
    position_error: Array
    orientation_error: Array
    iterations: NDArray[np.int64]
    escapes: NDArray[np.int64]
    restarts: NDArray[np.int64]
    seconds: Array
    targets: Array
    look: Callable[[Array, Array], Report]

    def __len__(self) -> int:
        return len(self.q)

    def __getitem__(self, index: int) -> Solution:
        q = self.q[index].copy()
        return Solution(
            q=q,
            status=self.statuses[index],
            converged=bool(self.converged[index]),
            iterations=int(self.iterations[index]),
            escapes=int(self.escapes[index]),
            restarts=int(self.restarts[index]),
            seconds=float(self.seconds[index]),
            look=partial(self.look, q, self.targets[index]),
        )

    def __iter__(self) -> Iterator[Solution]:
        return (self[index] for index in range(len(self)))

    def __repr__(self) -> str:
        lines = [
            f"SolutionBatch: {int(self.converged.sum())} of {len(self)} solved, {1e3 * self.seconds.sum():.3g} ms",
            *(f"  {count:6}  {status.value}" for status, count in Counter(self.statuses).most_common()),
        ]
        if len(self):
            iterations, worst = self.iterations, (self.position_error.max(), self.orientation_error.max())
            lines.append(f"  iterations  median {np.median(iterations):.3g}, mean {iterations.mean():.3g}")
            lines.append(f"  restarts    in {int((self.restarts > 0).sum())} of {len(self)}")
            lines.append(f"  largest error  {worst[0]:.3g} m, {worst[1]:.3g} rad")
        return "\n".join(lines)


def read_targets(tasks: TaskStack, targets: Iterable[Any]) -> list[Array]:
    """The numbers of each target, all checked before any is solved.

    Raises:
        ArgumentError: naming the target, such as ``targets[3]``.
    """
    numbers = []
    for i, target in enumerate(targets):
        try:
            numbers.append(tasks.read_target(target))
        except ArgumentError as error:
            inner = error.argument.removeprefix("target")
            raise ArgumentError(f"targets[{i}]{inner}", error.given, error.accepted) from None
    return numbers


def collect(
    entries: Sequence[Entry],
    *,
    targets: Sequence[Array],
    nq: int,
    look: Callable[[Array, Array], Report],
) -> SolutionBatch:
    """The columns of all entries."""
    count = len(entries)
    errors = np.array([entry.errors for entry in entries], dtype=np.float64).reshape(count, 2)
    return SolutionBatch(
        q=np.array([entry.found.q for entry in entries]).reshape(count, nq),
        statuses=tuple(entry.status for entry in entries),
        converged=np.array([entry.converged for entry in entries], dtype=bool),
        position_error=errors[:, 0],
        orientation_error=errors[:, 1],
        iterations=np.array([entry.found.iterations for entry in entries], dtype=np.int64),
        escapes=np.array([entry.found.escapes for entry in entries], dtype=np.int64),
        restarts=np.array([entry.found.restarts for entry in entries], dtype=np.int64),
        seconds=np.array([entry.seconds for entry in entries], dtype=np.float64),
        targets=np.array(targets).reshape(count, -1) if count else np.zeros((0, 0)),
        look=look,
    )
