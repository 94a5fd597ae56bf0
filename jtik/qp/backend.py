"""What a back end is, and which there are: the strings that ``InverseKinematics(solver=)`` takes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from jtik.errors import ArgumentError, JtikError, finite_array
from jtik.symbolic import Function, has_conic
from jtik.types import Array

PLUGINS = {"daqp": 1e-7, "osqp": 1e-3, "piqp": 1e-5, "proxqp": 1e-3, "qpoases": 1e-7, "highs": 1e-5, "qrqp": 1e-5}
"""CasADi's conic plugins and how exactly an answer of theirs is expected to hold (violation, stationarity)."""

WRONG = ("qrqp",)
"""Plugins that are not to be used: qrqp was wrong on up to a sixth of box-constrained programs."""

ELSEWHERE = 1e-3
"""The same for a solver of qpsolvers that is not in the table."""


class BackendError(JtikError):
    """A solver that cannot be used. Attributes: solver, reason."""

    def __init__(self, solver: str, reason: str) -> None:
        super().__init__(solver, reason)
        self.solver = solver
        self.reason = reason

    def __str__(self) -> str:
        return f"solver {self.solver!r}: {self.reason}"


@dataclass(frozen=True)
class Numbers:
    """A program's data as arrays: P (n, n), q (n,), C (k, n), l, u (k,), lb, ub (n,); columns first, shared memory."""

    P: Array
    q: Array
    C: Array
    low: Array
    high: Array
    lower: Array
    upper: Array

    @property
    def sound(self) -> bool:
        """Whether every number is finite, or an infinite bound: there are solvers that loop on NaN."""
        finite = np.isfinite(self.P).all() and np.isfinite(self.q).all() and np.isfinite(self.C).all()
        bounds = (self.low, self.high, self.lower, self.upper)
        return bool(finite) and not any(np.isnan(bound).any() for bound in bounds)


class _Answering(ABC):
    """What solves the programs of a step.

    ``name`` is what the user called it; ``accuracy`` what its answers are held to; ``second`` is asked where a fused
    one has no answer.
    """

    name: str
    accuracy: float
    second: CalledBackend | None = None


class FusedBackend(_Answering):
    """One that CasADi calls, so that a step stays one function."""

    @abstractmethod
    def function(self, n: int, rows: int) -> Function:
        """(P, q, C, l, u, lb, ub) -> (x, row multipliers, box multipliers), for programs of this size."""


class CalledBackend(_Answering):
    """One that Python calls, between the functions of a step."""

    @abstractmethod
    def solver(self, n: int, rows: int) -> Solver:
        """Something that solves programs of this size, one after the other."""


Backend: TypeAlias = FusedBackend | CalledBackend
"""What ``solver=`` takes, beside a name."""


def accuracy_of(given: float | None, usual: float) -> float:
    """What answers are held to. Raises ArgumentError unless it is finite and positive."""
    if given is None:
        return usual
    accuracy = float(finite_array("accuracy", given, ()))
    if not accuracy > 0:
        raise ArgumentError("accuracy", given, "a positive number")
    return accuracy


def simplest() -> Numbers:
    """A program that every solver answers, to try its options on: x = -1 in a box, above -2."""
    one = np.ones((1, 1))
    return Numbers(one, one[0], one, -2 * one[0], np.full(1, np.inf), -3 * one[0], 3 * one[0])


class Solver(ABC):
    """One program's solver, with whatever it keeps from call to call."""

    @abstractmethod
    def solve(self, program: Numbers) -> Sequence[Array] | None:
        """x (n,), row multipliers (k,) and box multipliers (n,), or None where there is no answer."""


def available() -> list[str]:
    """Names that ``solver=`` accepts here: CasADi's plugins, then what qpsolvers has."""
    import qpsolvers

    plugins = [name for name in PLUGINS if name not in WRONG and has_conic(name)]
    return [*plugins, *[name for name in qpsolvers.available_solvers if name not in plugins]]


def backend_of(solver: str | Backend | None) -> Backend:
    """The back end a name stands for; DAQP for None.

    Raises:
        BackendError: when it is not installed, or not to be used.
    """
    from jtik.qp.conic import Conic
    from jtik.qp.foreign import Foreign

    if isinstance(solver, Backend):
        return solver
    name = "daqp" if solver is None else solver
    if not isinstance(name, str):
        raise BackendError(
            repr(solver), f"give a FusedBackend or a CalledBackend of jtik.qp, or one of {', '.join(available())}"
        )
    if name in WRONG:
        raise BackendError(name, f"is wrong on box-constrained programs; use one of {', '.join(available())}")
    if name in PLUGINS and has_conic(name):
        return Conic(name)
    return Foreign(name)
