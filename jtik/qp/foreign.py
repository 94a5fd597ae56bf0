"""Any solver qpsolvers knows, by name: outside the fused step, with its data and answers copied across."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from importlib.metadata import metadata
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.qp.backend import ELSEWHERE, PLUGINS, BackendError, CalledBackend, Numbers, Solver, accuracy_of, simplest
from jtik.types import Array

_EXACT: dict[str, dict[str, Any]] = {
    "osqp": {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20000, "polishing": True},
    "scs": {"eps_abs": 1e-8, "eps_rel": 1e-8},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0},
}
"""Defaults of first-order solvers are for control, too coarse to converge by."""


class Foreign(CalledBackend):
    """A solver of qpsolvers. Options pass through to it.

    Raises:
        ArgumentError: for an accuracy that is none.
        BackendError: when it is not installed; it says which are, and how to install one. Or when it refuses the
            options.
    """

    def __init__(self, name: str, *, accuracy: float | None = None, **options: Any) -> None:
        import qpsolvers

        if name not in qpsolvers.available_solvers:
            from jtik.qp.backend import available

            missing = [extra for extra in _installable() if extra not in available()]
            more = f"no solver that qpsolvers could install, which are {', '.join(missing)}"
            if name in missing:
                more = f"install it with: pip install 'qpsolvers[{name}]'"
            raise BackendError(name, f"not installed; there are {', '.join(available())}; {more}")
        self.name = name
        self.accuracy = accuracy_of(accuracy, PLUGINS.get(name, ELSEWHERE))
        self._options = {**_EXACT.get(name, {}), **options}
        if options:
            try:
                _solved(name, simplest(), self._options)
            except Exception as error:
                raise BackendError(name, f"refuses the options {options}: {error}") from error

    def __repr__(self) -> str:
        return f"Foreign({self.name!r})"

    def solver(self, n: int, rows: int) -> Solver:
        """One that splits equalities from inequalities at each call."""
        return _Solver(self.name, self._options)


class _Solver(Solver):
    def __init__(self, name: str, options: dict[str, Any]) -> None:
        self._name, self._options = name, options

    def solve(self, program: Numbers) -> Sequence[Array] | None:
        """Through ``qpsolvers.solve_problem``; a solver that raises has no answer."""
        try:
            return _solved(self._name, program, self._options)
        except Exception:  # their errors have no base in common
            return None


def _solved(name: str, program: Numbers, options: dict[str, Any]) -> Sequence[Array] | None:
    """Through ``qpsolvers.solve_problem``, which may raise anything."""
    import qpsolvers

    problem, equal, above, below = as_problem(program)
    if name not in qpsolvers.dense_solvers:
        problem = _sparse(problem)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # what a solver says of its own interface is not the caller's business
        solution = qpsolvers.solve_problem(problem, solver=name, **options)
    if not solution.found or solution.x is None:
        return None
    rows = np.zeros(len(program.low))
    if equal.any() and solution.y is not None:
        rows[equal] = solution.y
    if (above.any() or below.any()) and solution.z is not None:
        count = int(above.sum())
        rows[above] += solution.z[:count]
        rows[below] -= solution.z[count:]
    box = solution.z_box if solution.z_box is not None and len(solution.z_box) else np.zeros(len(program.q))
    return solution.x, rows, box


def as_problem(program: Numbers) -> tuple[Any, NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """The ``qpsolvers.Problem``, and which rows are equalities, have an upper and have a lower bound."""
    import qpsolvers

    low, high, C = program.low, program.high, program.C
    equal = low == high
    above, below = ~equal & np.isfinite(high), ~equal & np.isfinite(low)
    G = h = A = b = None
    if above.any() or below.any():
        G, h = np.vstack([C[above], -C[below]]), np.concatenate([high[above], -low[below]])
    if equal.any():
        A, b = C[equal], low[equal]
    P = (program.P + program.P.T) / 2
    problem = qpsolvers.Problem(P, program.q.copy(), G, h, A, b, program.lower.copy(), program.upper.copy())
    return problem, equal, above, below


def _sparse(problem: Any) -> Any:
    """The same problem for a solver that takes sparse matrices only."""
    import qpsolvers
    from scipy import sparse

    P, q, G, h, A, b, lb, ub = problem.unpack()
    matrices = [None if matrix is None else sparse.csc_matrix(matrix) for matrix in (P, G, A)]
    return qpsolvers.Problem(matrices[0], q, matrices[1], h, matrices[2], b, lb, ub)


def _installable() -> list[str]:
    """Names of solvers that come as extras of qpsolvers."""
    extras = metadata("qpsolvers").get_all("Provides-Extra") or []
    return [extra for extra in extras if "-" not in extra]
