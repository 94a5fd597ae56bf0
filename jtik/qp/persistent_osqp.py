"""OSQP with a persistent workspace: updated with each step's data and warm-started from the last solution."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jtik.qp.backend import BackendError, CalledBackend, NumericQP, QPSolver, accuracy_of, trial_qp
from jtik.types import Array

_DEFAULTS: dict[str, Any] = {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20000, "polishing": True, "verbose": False}
_INFINITE = 1e30
"""OSQP's value of an infinite bound."""


class PersistentOSQP(CalledBackend):
    """OSQP as the back end, by its own interface. Prefer it to other OSQP back ends for its warm starts.

    Args:
        accuracy: what solutions are checked against.
        **options: options of ``osqp.OSQP.setup``, passed through to it.

    Raises:
        ArgumentError: if ``accuracy`` is not finite and positive.
        BackendError: if OSQP refuses the options.
    """

    def __init__(self, *, accuracy: float = 1e-3, **options: Any) -> None:
        self.name = "osqp"
        self.accuracy = accuracy_of(accuracy, 1e-3)
        self._options = {**_DEFAULTS, **options}
        if options:
            try:
                _Workspace(1, 1, self._options).update_and_solve(trial_qp())
            except Exception as error:
                raise BackendError(self.name, f"refuses the options {options}: {error}") from error

    def __repr__(self) -> str:
        return "PersistentOSQP()"

    def solver(self, n: int, rows: int) -> QPSolver:
        """A workspace for dense QPs of this size, set up by the first of them."""
        return _Workspace(n, rows, self._options)


class _Workspace(QPSolver):
    """An OSQP workspace for QPs of one size."""

    def __init__(self, n: int, rows: int, options: dict[str, Any]) -> None:
        self._n, self._options = n, options
        self._upper = np.triu_indices(n)
        self._osqp: Any = None
        self._bounds = np.zeros((2, rows + n))

    def solve(self, qp: NumericQP) -> Sequence[Array] | None:
        """Solve one QP; None also if OSQP raises, as for a non-convex one. The next QP then sets up a new workspace."""
        try:
            return self.update_and_solve(qp)
        except Exception:  # its errors have no common base class
            self._osqp = None
            return None

    def update_and_solve(self, qp: NumericQP) -> Sequence[Array] | None:
        """Solve with the rows first, then the box as rows of the identity; zeros are stored to keep the pattern."""
        import osqp
        from scipy import sparse

        n, k = self._n, len(qp.low)
        self._bounds[0, :k], self._bounds[0, k:] = qp.low, qp.lower
        self._bounds[1, :k], self._bounds[1, k:] = qp.high, qp.upper
        low, high = np.clip(self._bounds, -_INFINITE, _INFINITE)
        rows, columns = self._upper[1], self._upper[0]  # by columns of the upper triangle
        Px = np.array([qp.P[j, i] for i, j in zip(rows, columns, strict=True)])
        order = np.lexsort((columns, rows))
        Px = Px[order]
        Ax = np.concatenate([np.append(qp.C[:, j], 1.0) for j in range(n)])
        if self._osqp is None:
            P = sparse.csc_matrix((Px, (columns[order], rows[order])), shape=(n, n))
            A = sparse.csc_matrix(
                (Ax, np.concatenate([np.append(np.arange(k), k + j) for j in range(n)]), (k + 1) * np.arange(n + 1)),
                shape=(k + n, n),
            )
            P.data[:] = Px
            self._osqp = osqp.OSQP()
            self._osqp.setup(P=P, q=qp.q.copy(), A=A, l=low, u=high, **self._options)
        else:
            self._osqp.update(q=qp.q.copy(), l=low, u=high, Px=Px, Ax=Ax)
        result = self._osqp.solve(raise_error=False)
        if result.info.status_val not in (1, 2):
            return None
        return result.x, result.y[:k], result.y[k:]
