"""OSQP with a workspace that stays: updated with each step's numbers and started from the last answer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from jtik.qp.backend import BackendError, CalledBackend, Numbers, Solver, accuracy_of, simplest
from jtik.types import Array

_EXACT: dict[str, Any] = {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20000, "polishing": True, "verbose": False}
_INFINITE = 1e30


class PersistentOSQP(CalledBackend):
    """OSQP by its own interface. Options pass through to ``osqp.OSQP.setup``.

    Raises:
        ArgumentError: for an accuracy that is none.
        BackendError: when OSQP refuses the options.
    """

    def __init__(self, *, accuracy: float = 1e-3, **options: Any) -> None:
        self.name = "osqp"
        self.accuracy = accuracy_of(accuracy, 1e-3)
        self._options = {**_EXACT, **options}
        if options:
            try:
                _Workspace(1, 1, self._options).ask(simplest())
            except Exception as error:
                raise BackendError(self.name, f"refuses the options {options}: {error}") from error

    def __repr__(self) -> str:
        return "PersistentOSQP()"

    def solver(self, n: int, rows: int) -> Solver:
        """A workspace for dense programs of this size, set up by the first of them."""
        return _Workspace(n, rows, self._options)


class _Workspace(Solver):
    def __init__(self, n: int, rows: int, options: dict[str, Any]) -> None:
        self._n, self._options = n, options
        self._upper = np.triu_indices(n)
        self._osqp: Any = None
        self._bounds = np.zeros((2, rows + n))

    def solve(self, program: Numbers) -> Sequence[Array] | None:
        """None also where OSQP raises, as for what is not convex; it then sets up a new workspace the next time."""
        try:
            return self.ask(program)
        except Exception:  # its errors have no base in common
            self._osqp = None
            return None

    def ask(self, program: Numbers) -> Sequence[Array] | None:
        """Rows first, then the box as rows of the identity; every entry is stored, so that the pattern stays."""
        import osqp
        from scipy import sparse

        n, k = self._n, len(program.low)
        self._bounds[0, :k], self._bounds[0, k:] = program.low, program.lower
        self._bounds[1, :k], self._bounds[1, k:] = program.high, program.upper
        low, high = np.clip(self._bounds, -_INFINITE, _INFINITE)
        rows, columns = self._upper[1], self._upper[0]  # by columns of the upper triangle
        Px = np.array([program.P[j, i] for i, j in zip(rows, columns, strict=True)])
        order = np.lexsort((columns, rows))
        Px = Px[order]
        Ax = np.concatenate([np.append(program.C[:, j], 1.0) for j in range(n)])
        if self._osqp is None:
            P = sparse.csc_matrix((Px, (columns[order], rows[order])), shape=(n, n))
            A = sparse.csc_matrix(
                (Ax, np.concatenate([np.append(np.arange(k), k + j) for j in range(n)]), (k + 1) * np.arange(n + 1)),
                shape=(k + n, n),
            )
            P.data[:] = Px
            self._osqp = osqp.OSQP()
            self._osqp.setup(P=P, q=program.q.copy(), A=A, l=low, u=high, **self._options)
        else:
            self._osqp.update(q=program.q.copy(), l=low, u=high, Px=Px, Ax=Ax)
        result = self._osqp.solve(raise_error=False)
        if result.info.status_val not in (1, 2):
            return None
        return result.x, result.y[:k], result.y[k:]
