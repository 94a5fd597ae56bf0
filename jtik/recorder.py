"""Recording a solve: one row an iteration, made into a Trace when the solve is over."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from jtik.runner import Runner
from jtik.solution import Trace

Array = NDArray[np.float64]


class Recorder:
    """Rows of a runner whose fused function was built with its record."""

    def __init__(self, runner: Runner) -> None:
        self.runner = runner
        self._q: list[Array] = []
        self._rows: list[Array] = []
        self._escaped: list[bool] = []

    def before(self, q: Array) -> None:
        """An iteration begins at q."""
        self._q.append(q.copy())

    def after(self) -> None:
        """It is over: keep its figures."""
        self._rows.append(self.runner.record.copy())
        self._escaped.append(False)

    def escaped(self) -> None:
        """It ended in a second-order step out of a singular stall."""
        self._escaped[-1] = True

    def forget(self) -> None:
        """It was none."""
        for rows in (self._q, self._rows, self._escaped):
            rows.pop()

    def trace(self, end: Array, error: Callable[[Array], Array]) -> Trace:
        """Figures by name, and those that need a factorisation of the recorded Jacobians."""
        layout, count = self.runner.fused.record, len(self._rows)
        n = layout.slices["term"].stop - layout.slices["term"].start
        m = (layout.slices["J"].stop - layout.slices["J"].start) // n
        table = np.array(self._rows).reshape(count, layout.size)
        columns = {name: table[:, where] for name, where in layout.slices.items()}
        J = columns.pop("J").reshape(count, n, m).transpose(0, 2, 1)
        null, term = columns.pop("null_term"), columns.pop("term")
        figures = {name: column[:, 0] for name, column in columns.items()}
        figures["step_length"] = np.linalg.norm(term, axis=1)
        figures["sigma_min"] = np.array([_least_singular_value(each) for each in J])
        length = np.linalg.norm(null, axis=1)
        moved = np.linalg.norm(np.einsum("kmn,kn->km", J, null), axis=1)
        figures["leakage"] = np.divide(moved, length, out=np.full(count, np.nan), where=length > 0)
        figures["escaped"] = np.array(self._escaped, dtype=float)
        q = np.array([*self._q, end])
        return Trace(q=q, error=np.array([np.linalg.norm(error(each)) for each in q]), figures=figures)


def _least_singular_value(J: Array) -> float:
    """NaN where J is not finite."""
    return float(np.linalg.svd(J, compute_uv=False)[-1]) if np.isfinite(J).all() else float("nan")
