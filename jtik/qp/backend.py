"""Back ends that solve quadratic programs: base classes, and the names that ``InverseKinematics(solver=)`` accepts."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from jtik.arguments import positive_number
from jtik.constructors import Constructed
from jtik.errors import JtikError
from jtik.symbolic import Function, has_conic
from jtik.symbolic.compilation.archives import Archive
from jtik.types import Array

PLUGINS = {"daqp": 1e-7, "osqp": 1e-3, "piqp": 1e-5, "proxqp": 1e-3, "qpoases": 1e-7, "highs": 1e-5, "qrqp": 1e-5}
"""CasADi's conic plugins and the accuracy (violation, stationarity) that their solutions are checked against."""

EXCLUDED = ("qrqp",)
"""Plugins that are refused: qrqp returned wrong solutions to up to a sixth of box-constrained QPs."""

DEFAULT_ACCURACY = 1e-3
"""The accuracy of a solver of qpsolvers that is not in the table."""


class BackendError(JtikError):
    """A QP solver cannot be used.

    Attributes:
        solver: name of the solver.
        reason: why it cannot be used, and what could be used instead.
    """

    def __init__(self, solver: str, reason: str) -> None:
        super().__init__(solver, reason)
        self.solver = solver
        self.reason = reason

    def __str__(self) -> str:
        return f"solver {self.solver!r}: {self.reason}"


@dataclass(frozen=True)
class NumericQP:
    """A quadratic program as NumPy arrays in memory that is shared with the step; matrices are column-major.

    Attributes:
        P: Hessian (n, n).
        q: linear cost (n,).
        C: matrix of the rows (k, n).
        low: lower bounds of the rows (k,).
        high: upper bounds of the rows (k,).
        lower: lower bounds of the variables (n,).
        upper: upper bounds of the variables (n,).
    """

    P: Array
    q: Array
    C: Array
    low: Array
    high: Array
    lower: Array
    upper: Array

    @property
    def valid(self) -> bool:
        """Whether every number is finite, or an infinite bound: some solvers loop on NaN."""
        finite = np.isfinite(self.P).all() and np.isfinite(self.q).all() and np.isfinite(self.C).all()
        bounds = (self.low, self.high, self.lower, self.upper)
        return bool(finite) and not any(np.isnan(bound).any() for bound in bounds)


class _BackendBase(metaclass=Constructed):
    """What both kinds of back end have in common.

    Attributes:
        name: the name that ``solver=`` accepts.
        accuracy: largest violation, and largest stationarity residual relative to 1 + |q|, of an accepted solution.
        fallback: back end for QPs that a fused one fails to solve; None for none.
    """

    name: str
    accuracy: float
    fallback: CalledBackend | None = None

    def warm_up(self) -> None:
        """Load what is otherwise loaded when a first QP is solved."""
        if self.fallback:
            self.fallback.warm_up()


class FusedBackend(_BackendBase):
    """A back end that CasADi calls, so that the step stays one function.

    Attributes:
        archive: the static library that the step in generated C calls; None where it cannot call the solver.
    """

    archive: Archive | None = None

    @abstractmethod
    def function(self, n: int, rows: int) -> Function:
        """The function (P, q, C, l, u, lb, ub) -> (x, row multipliers, box multipliers).

        Args:
            n: number of variables.
            rows: number of rows of C.
        """


class CalledBackend(_BackendBase):
    """A back end that Python calls, between the functions of a step."""

    @abstractmethod
    def solver(self, n: int, rows: int) -> QPSolver:
        """A solver of QPs of this size, to be called once per QP.

        Args:
            n: number of variables.
            rows: number of rows of C.
        """


Backend: TypeAlias = FusedBackend | CalledBackend
"""What ``solver=`` accepts besides a name."""


def accuracy_of(given: float | None, default: float) -> float:
    """The accuracy to check solutions against.

    Raises:
        ArgumentError: unless it is finite and positive.
    """
    if given is None:
        return default
    return positive_number("accuracy", given)


def trial_qp() -> NumericQP:
    """A small QP to try a solver's options on; its solution is x = -1."""
    one = np.ones((1, 1))
    return NumericQP(one, one[0], one, -2 * one[0], np.full(1, np.inf), -3 * one[0], 3 * one[0])


class QPSolver(ABC):
    """A solver of QPs of one size, which may keep a workspace between calls."""

    @abstractmethod
    def solve(self, qp: NumericQP) -> Sequence[Array] | None:
        """Solve one QP.

        Args:
            qp: the quadratic program.

        Returns:
            x (n,), row multipliers (k,) and box multipliers (n,); None if the solver found no solution.
        """


def available() -> list[str]:
    """Names that ``solver=`` accepts in this environment: CasADi's plugins, then the solvers of qpsolvers."""
    import qpsolvers

    plugins = [name for name in PLUGINS if name not in EXCLUDED and has_conic(name)]
    return [*plugins, *[name for name in qpsolvers.available_solvers if name not in plugins]]


def backend_of(solver: str | Backend | None) -> Backend:
    """The back end of that name; DAQP for None.

    Args:
        solver: name of a solver, or a back end itself.

    Raises:
        BackendError: if the solver is not installed, or excluded.
    """
    from jtik.qp.conic import Conic
    from jtik.qp.qpsolvers_backend import QPSolversBackend

    if isinstance(solver, Backend):
        return solver
    name = "daqp" if solver is None else solver
    if not isinstance(name, str):
        raise BackendError(
            repr(solver), f"give a FusedBackend or a CalledBackend of jtik.qp, or one of {', '.join(available())}"
        )
    if name in EXCLUDED:
        raise BackendError(name, f"is wrong on box-constrained QPs; use one of {', '.join(available())}")
    if name in PLUGINS and has_conic(name):
        return Conic(name)
    return QPSolversBackend(name)
