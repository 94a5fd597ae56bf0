"""Recording a solve: one row an iteration, made into a Trace when the solve is over."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from jtik._loop.runner import Runner
from jtik.result.length import length
from jtik.result.trace import Trace
from jtik.types import Array

ROUNDING = 1e-8
"""A null-space step up to this long [rad] or [m] is rounding or a solver's noise; its leakage is not meaningful."""

DISPLACEMENT, NULL_SPACE, NULL_SPACE_IMAGE, JACOBIAN, RELAXED = "dq", "null_space", "null_space_image", "J", "relaxed"
"""Vectors in the record of a step, from which figures are computed; every other entry is a figure."""


class TraceRecorder:
    """Rows of a runner whose fused step gives its record."""

    def __init__(self, runner: Runner) -> None:
        self.runner = runner
        self._q: list[Array] = []
        self._rows: list[Array] = []
        self._escaped: list[bool] = []
        self._attempts: list[int] = []
        self._attempt = -1

    def begin(self) -> None:
        """Note that an attempt begins."""
        self._attempt += 1

    def before(self, q: Array) -> None:
        """Note that an iteration begins at q."""
        self._q.append(q.copy())

    def after(self) -> None:
        """Keep the figures of the iteration, which is over."""
        self._rows.append(self.runner.record.copy())
        self._escaped.append(False)
        self._attempts.append(self._attempt)

    def escaped(self) -> None:
        """Note that the iteration ended in a saddle escape."""
        self._escaped[-1] = True

    def discard(self) -> None:
        """Remove the last call: it was not an iteration."""
        for rows in (self._q, self._rows, self._escaped, self._attempts):
            rows.pop()

    def trace(self, end: Array, error: Callable[[Array], Array]) -> Trace:
        """The Trace.

        Args:
            end: where the solve ended, (nq,).
            error: the task error at a configuration.
        """
        layout, count = self.runner.fused.record, len(self._rows)
        n = layout.slices[DISPLACEMENT].stop - layout.slices[DISPLACEMENT].start
        m = (layout.slices[JACOBIAN].stop - layout.slices[JACOBIAN].start) // n
        table = np.array(self._rows).reshape(count, layout.size)
        columns = {name: table[:, where] for name, where in layout.slices.items()}
        columns.pop(RELAXED, None)  # reported for the last q only
        J = columns.pop(JACOBIAN).reshape(count, n, m).transpose(0, 2, 1)
        null, image, displacement = (columns.pop(name) for name in (NULL_SPACE, NULL_SPACE_IMAGE, DISPLACEMENT))
        figures = {name: column[:, 0] for name, column in columns.items()}
        figures["step_length"] = np.linalg.norm(displacement, axis=1)
        figures["sigma_min"] = _smallest_singular_values(J)
        of_null = np.linalg.norm(null, axis=1)
        moved = np.linalg.norm(image, axis=1)
        figures["leakage"] = np.divide(moved, of_null, out=np.full(count, np.nan), where=of_null > ROUNDING)
        figures["escaped"] = np.array(self._escaped, dtype=float)
        figures["attempt"] = np.array(self._attempts, dtype=float)
        q = np.array([*self._q, end])
        return Trace(q=q, error=np.array([length(error(each)) for each in q]), figures=figures)


def _smallest_singular_values(J: Array) -> Array:
    """Of each of the matrices (k, m, n); NaN where one is not finite."""
    finite = np.isfinite(J).all(axis=(1, 2))
    smallest = np.full(len(J), np.nan)
    if finite.any():
        smallest[finite] = np.linalg.svd(J[finite], compute_uv=False)[:, -1]
    return smallest
