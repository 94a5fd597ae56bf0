"""Complete orthogonal decomposition of a Jacobian: pseudo-inverse and null-space projector at any rank.

``J = L Q``: the rows of Q are an orthonormal basis of the row space of J (modified Gram-Schmidt), L is lower
trapezoidal. One rank decision is made per row: a row whose part outside the span of the rows before it is
shorter than ``RANK_THRESHOLD`` times the Frobenius norm of J is dependent and spans nothing. With all rows independent L
is triangular and everything is a substitution; with dependent rows the columns of L are orthogonalised too, and
the least-squares solution of least norm results, as an SVD truncated at the same threshold would give it.

No Gram matrix is formed, so a condition number of 1e8 is as harmless as 1e4 is to a Cholesky factor of ``J J'``.

Source: Golub and Van Loan, *Matrix Computations*, section 5.4 (complete orthogonal decomposition).
"""

from __future__ import annotations

from functools import cached_property

from jtik.symbolic import Expression, dot, if_else, sqrt, sumsqr, vertcat, zeros

RANK_THRESHOLD = 1e-8
"""Relative length below which a row of J counts as dependent on the rows before it."""


class RowSpace:
    """Row space of a symbolic ``J`` (m, n): ``J+ r``, ``(J')+ g`` and ``(I - J+ J) g`` from one factorisation."""

    def __init__(self, J: Expression, *, threshold: float = RANK_THRESHOLD) -> None:
        self._m, self._n = J.shape
        limit = threshold**2 * sumsqr(J)
        self._basis: list[Expression] = []
        self._pivot: list[Expression] = []
        self._lower: list[list[Expression]] = []
        self._independent: list[Expression] = []
        for i in range(self._m):
            row = J[i, :].T
            coefficients = []
            for basis in self._basis:
                coefficient = dot(basis, row)
                row = row - coefficient * basis
                coefficients.append(coefficient)
            squared = sumsqr(row)
            independent = squared > limit
            length = sqrt(if_else(independent, squared, 1))
            self._basis.append(row * if_else(independent, 1 / length, 0))
            self._pivot.append(length)
            self._lower.append([*coefficients, if_else(independent, length, 0)])
            self._independent.append(independent)

    @cached_property
    def rank(self) -> Expression:
        """Number of independent rows."""
        return sum(self._independent[1:], self._independent[0])

    @cached_property
    def _column_space(self) -> tuple[list[Expression], list[list[Expression]]]:
        """Orthonormal columns U and the rows of the upper triangular R with ``L = U R``."""
        m = self._m
        columns = [vertcat(*[0] * j, *[self._lower[i][j] for i in range(j, m)]) for j in range(m)]
        U: list[Expression] = []
        R: list[list[Expression]] = [[] for _ in range(m)]
        for j, column in enumerate(columns):
            for i, unit in enumerate(U):
                coefficient = dot(unit, column)
                column = column - coefficient * unit
                R[i].append(coefficient)
            kept = self._independent[j]
            length = sqrt(if_else(kept, sumsqr(column), 1))
            U.append(column * if_else(kept, 1 / length, 0))
            R[j].append(length)
        return U, R

    def least_squares(self, r: Expression) -> Expression:
        """``J+ r``: of all x that minimise ``|J x - r|`` the shortest, shape (n, 1)."""
        U, R = self._column_space
        y: list[Expression] = [0] * self._m
        for i in reversed(range(self._m)):
            total = dot(U[i], r)
            for j in range(i + 1, self._m):
                total = total - R[i][j - i] * y[j]
            y[i] = total / R[i][0]
        solution = zeros(self._n)
        for component, basis in zip(y, self._basis, strict=True):
            solution = solution + component * basis
        return solution

    def multipliers(self, g: Expression) -> Expression:
        """``(J')+ g``: the least-squares solution of ``J' x = g``, shape (m, 1)."""
        U, R = self._column_space
        y: list[Expression] = []
        for i in range(self._m):
            total = dot(self._basis[i], g)
            for j in range(i):
                total = total - R[j][i - j] * y[j]
            y.append(total / R[i][0])
        solution = zeros(self._m)
        for component, unit in zip(y, U, strict=True):
            solution = solution + component * unit
        return solution

    def project(self, g: Expression) -> Expression:
        """``(I - J+ J) g``: the part of g that moves nothing to first order, shape (n, 1)."""
        for basis in [*self._basis, *reversed(self._basis[:-1])]:
            g = g - dot(basis, g) * basis
        return g
