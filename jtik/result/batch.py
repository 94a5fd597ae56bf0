"""The Solutions of many targets, as arrays."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass, fields
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from jtik.result.deprecated import RenamedAttribute
from jtik.result.report import Report
from jtik.result.solution import Solution
from jtik.result.status import Status
from jtik.types import Array


@dataclass(frozen=True, eq=False, repr=False)
class SolutionBatch:
    """Solutions of k targets: each figure of a `Solution` as a column, under the same name.

    ``batch[i]`` is the `Solution` of target i. A batch can be pickled; the reports of all rows are then computed.

    Attributes:
        q: configurations, (k, nq) [rad] and [m].
        status: why each solve stopped, k of them.
        converged: whether the solve succeeded, (k,).
        position_error: norm of the position error at q, (k,) [m].
        orientation_error: norm of the orientation error at q, (k,) [rad].
        iterations: steps tried, (k,).
        escapes: how many saddle escapes there were, (k,).
        restarts: how many other starting configurations were tried, (k,).
        seconds: wall time of each solve, (k,) [s].
        targets: the numbers that each was solved for, (k, target size).
        indices: the number of each row's target among those given, (k,); 0, 1, 2 ... of a complete batch.
        complete: whether all targets are included; False after Ctrl-C.
        inspect: function that computes the report of a row.

    Example:
        >>> ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask("tip"))
        >>> batch = ik.solve_batch([[2.0, 1.0], [1.0, 2.0], [9.0, 0.0]])
        >>> batch.converged.tolist(), batch.q.shape
        ([True, True, False], (3, 3))
    """

    q: Array
    status: tuple[Status, ...]
    converged: NDArray[np.bool_]
    position_error: Array
    orientation_error: Array
    iterations: NDArray[np.int64]
    escapes: NDArray[np.int64]
    restarts: NDArray[np.int64]
    seconds: Array
    targets: Array
    indices: NDArray[np.int64]
    complete: bool
    inspect: Callable[[int], Report]

    statuses = RenamedAttribute("status")

    @classmethod
    def of(cls, diagnose: Callable[[], tuple[Status, ...]], **columns: Any) -> SolutionBatch:
        """As the constructor, with a function that computes ``status`` when it is first read.

        Args:
            diagnose: returns the status of each solve.
            columns: all other fields of the constructor, as keywords.
        """
        batch = object.__new__(cls)
        batch.__dict__.update(columns, diagnose=diagnose)
        return batch

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            diagnose = self.__dict__.get("diagnose") if name == "status" else None
            if diagnose is None:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            status = self.__dict__["status"] = diagnose()
            return status

    def __len__(self) -> int:
        return len(self.q)

    def __getitem__(self, index: int) -> Solution:
        row = range(len(self))[index]
        return Solution(
            q=self.q[row].copy(),
            status=self.status[row],
            converged=bool(self.converged[row]),
            iterations=int(self.iterations[row]),
            escapes=int(self.escapes[row]),
            restarts=int(self.restarts[row]),
            seconds=float(self.seconds[row]),
            inspect=partial(self.inspect, row),
        )

    def __iter__(self) -> Iterator[Solution]:
        return (self[index] for index in range(len(self)))

    def __reduce__(self) -> tuple[Any, ...]:
        *columns, _ = (getattr(self, field.name) for field in fields(self))
        return type(self), (*columns, ComputedReports(tuple(self.inspect(row) for row in range(len(self)))))

    def __repr__(self) -> str:
        lines = [
            f"SolutionBatch: {int(self.converged.sum())} of {len(self)} solved, {1e3 * self.seconds.sum():.3g} ms"
            + ("" if self.complete else "; incomplete"),
            *(f"  {count:6}  {status.value}" for status, count in Counter(self.status).most_common()),
        ]
        if len(self):
            iterations, worst = self.iterations, (self.position_error.max(), self.orientation_error.max())
            lines.append(f"  iterations  median {np.median(iterations):.3g}, mean {iterations.mean():.3g}")
            lines.append(f"  restarts    in {int((self.restarts > 0).sum())} of {len(self)}")
            lines.append(f"  largest error  {worst[0]:.3g} m, {worst[1]:.3g} rad")
        return "\n".join(lines)


@dataclass(frozen=True)
class ComputedReports:
    """The ``inspect`` of a SolutionBatch that was pickled: reports that are already computed.

    Attributes:
        reports: the report of each row.
    """

    reports: tuple[Report, ...]

    def __call__(self, row: int) -> Report:
        """The report of a row."""
        return self.reports[row]
