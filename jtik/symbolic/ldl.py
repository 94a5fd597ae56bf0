"""Symmetric matrices as L D L', unrolled and without pivots."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi

from jtik.symbolic.operations import SX, Expression, mmin


@dataclass(frozen=True)
class LDL:
    """The factorisation of a symmetric matrix, L D L' without pivots: an operation for each step, cubic in its size.

    Attributes:
        pivots: the diagonal D (n, 1), all positive exactly where the matrix is positive definite.
    """

    pivots: Expression
    _upper: Any
    _order: Any

    @classmethod
    def of(cls, A: Expression) -> LDL:
        """The factorisation of ``A`` (n, n).

        Args:
            A: the matrix, symmetric.
        """
        D, upper, order = casadi.ldl(SX(A), False)
        return cls(D.T, upper, order)

    @property
    def positive_definite(self) -> Expression:
        """1 where the matrix is positive definite, else 0."""
        return mmin(self.pivots) > 0

    def solve(self, b: Expression) -> Expression:
        """``A^-1 b`` (n, 1); not finite where A is singular.

        Args:
            b: right-hand side (n, 1).
        """
        return casadi.ldl_solve(b, self.pivots.T, self._upper, self._order)


def solve_ldl(A: Expression, b: Expression) -> Expression:
    """``A^-1 b`` of a symmetric positive definite ``A``.

    Args:
        A: the matrix (n, n).
        b: right-hand side (n, 1).
    """
    return LDL.of(A).solve(b)
