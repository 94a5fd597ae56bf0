"""Solvers of qpsolvers as back ends, by name: called from Python between the functions of a step."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import text
from jtik.qp.backend import (
    DEFAULT_ACCURACY,
    PLUGINS,
    BackendError,
    CalledBackend,
    NumericQP,
    QPSolver,
    accuracy_of,
    trial_qp,
)
from jtik.types import Array

_DEFAULTS: dict[str, dict[str, Any]] = {
    "osqp": {"eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20000, "polishing": True},
    "scs": {"eps_abs": 1e-8, "eps_rel": 1e-8},
    "proxqp": {"eps_abs": 1e-9, "eps_rel": 0.0},
}
"""Default options: the tolerances of first-order solvers are too coarse for a step to converge."""


class QPSolversBackend(CalledBackend):
    """A solver of qpsolvers as the back end. Prefer it where CasADi has no plugin for the solver.

    Args:
        name: name of the solver in qpsolvers.
        accuracy: what solutions are checked against; a default for each solver.
        **options: options of the solver, passed through to it.

    Raises:
        ArgumentError: if ``accuracy`` is not finite and positive.
        BackendError: if the solver is not installed, with the installed ones and how to install it, or if it refuses
            the options.
    """

    def __init__(self, name: str, *, accuracy: float | None = None, **options: Any) -> None:
        import qpsolvers

        text("name", name, "the name of a solver of qpsolvers")
        if name not in qpsolvers.available_solvers:
            from jtik.qp.backend import available

            missing = [extra for extra in _installable() if extra not in available()]
            more = f"no solver that qpsolvers could install, which are {', '.join(missing)}"
            if name in missing:
                more = f"install it with: pip install 'qpsolvers[{name}]'"
            raise BackendError(name, f"not installed; there are {', '.join(available())}; {more}")
        self.name = name
        self.accuracy = accuracy_of(accuracy, PLUGINS.get(name, DEFAULT_ACCURACY))
        self._options = {**_DEFAULTS.get(name, {}), **options}
        if options:
            try:
                _solve(name, trial_qp(), self._options)
            except Exception as error:
                raise BackendError(name, f"refuses the options {options}: {error}") from error

    def __repr__(self) -> str:
        return f"QPSolversBackend({self.name!r})"

    def warm_up(self) -> None:
        """Load qpsolvers and the solver, by a small QP."""
        self.solver(1, 1).solve(trial_qp())

    def solver(self, n: int, rows: int) -> QPSolver:
        """A solver that separates equalities from inequalities at each call."""
        return _QPSolversSolver(self.name, self._options)


class _QPSolversSolver(QPSolver):
    """One solver of qpsolvers with its options."""

    def __init__(self, name: str, options: dict[str, Any]) -> None:
        self._name, self._options = name, options

    def solve(self, qp: NumericQP) -> Sequence[Array] | None:
        """Solve by ``qpsolvers.solve_problem``; None if the solver raises."""
        try:
            return _solve(self._name, qp, self._options)
        except Exception:  # the solvers' errors have no common base class
            return None


def _solve(name: str, qp: NumericQP, options: dict[str, Any]) -> Sequence[Array] | None:
    """Solve by ``qpsolvers.solve_problem``, which may raise any error."""
    import qpsolvers

    problem, equal, above, below = as_problem(qp)
    if name not in qpsolvers.dense_solvers:
        problem = _sparse(problem)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # solvers warn about their own interfaces, which the caller cannot change
        solution = qpsolvers.solve_problem(problem, solver=name, **options)
    if not solution.found or solution.x is None:
        return None
    rows = np.zeros(len(qp.low))
    if equal.any() and solution.y is not None:
        rows[equal] = solution.y
    if (above.any() or below.any()) and solution.z is not None:
        count = int(above.sum())
        rows[above] += solution.z[:count]
        rows[below] -= solution.z[count:]
    box = solution.z_box if solution.z_box is not None and len(solution.z_box) else np.zeros(len(qp.q))
    return solution.x, rows, box


def as_problem(qp: NumericQP) -> tuple[Any, NDArray[np.bool_], NDArray[np.bool_], NDArray[np.bool_]]:
    """Convert a QP to a ``qpsolvers.Problem``.

    Args:
        qp: the quadratic program.

    Returns:
        The problem; masks (k,) of the rows that are equalities, have an upper bound, and have a lower bound.
    """
    import qpsolvers

    low, high, C = qp.low, qp.high, qp.C
    equal = low == high
    above, below = ~equal & np.isfinite(high), ~equal & np.isfinite(low)
    G = h = A = b = None
    if above.any() or below.any():
        G, h = np.vstack([C[above], -C[below]]), np.concatenate([high[above], -low[below]])
    if equal.any():
        A, b = C[equal], low[equal]
    P = (qp.P + qp.P.T) / 2
    problem = qpsolvers.Problem(P, qp.q.copy(), G, h, A, b, qp.lower.copy(), qp.upper.copy())
    return problem, equal, above, below


def _sparse(problem: Any) -> Any:
    """The same problem with sparse matrices, for a solver that accepts only sparse ones."""
    import qpsolvers
    from scipy import sparse

    P, q, G, h, A, b, lb, ub = problem.unpack()
    matrices = [None if matrix is None else sparse.csc_matrix(matrix) for matrix in (P, G, A)]
    return qpsolvers.Problem(matrices[0], q, matrices[1], h, matrices[2], b, lb, ub)


def _installable() -> list[str]:
    """Names of the solvers that can be installed as extras of qpsolvers."""
    from importlib.metadata import metadata

    extras = metadata("qpsolvers").get_all("Provides-Extra") or []
    return [extra for extra in extras if "-" not in extra]
