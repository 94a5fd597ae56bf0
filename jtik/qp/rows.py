"""Rows of a quadratic program: named groups of linear constraints, hard or elastic."""

from __future__ import annotations

from dataclasses import dataclass

from jtik.qp.elastic import Elastic
from jtik.symbolic import MX, SX, TINY, Expression, either, fabs, function, is_finite, looped, sqrt, sum1, sum2
from jtik.symbolic.factorization import RowSpace

LARGEST_UNROLLED = 300
"""Entries of rows up to which what is done with them is written out, operation by operation."""


@dataclass(frozen=True)
class Rows:
    """A named group of rows ``lower <= matrix x <= upper``; equal bounds are an equality.

    Attributes:
        name: name of the group.
        matrix: (k, n).
        lower: lower bounds (k, 1).
        upper: upper bounds (k, 1).
        elastic: how far the rows may be relaxed, with which penalty; None for hard rows.
        exact: whether equalities are to hold to rounding instead of to the solver's tolerance, as those of a null space
            must: what a solver returns is then corrected. Not for elastic rows.
    """

    name: str
    matrix: Expression
    lower: Expression
    upper: Expression
    elastic: Elastic | None = None
    exact: bool = False

    @classmethod
    def equal(cls, name: str, matrix: Expression, to: Expression, elastic: Elastic | None = None) -> Rows:
        """The equalities ``matrix x = to``.

        Args:
            name: name of the group.
            matrix: the rows (k, n).
            to: right-hand side (k, 1).
            elastic: how far the rows may be relaxed, with which penalty; None for hard rows.
        """
        return cls(name, matrix, to, to, elastic)

    @classmethod
    def in_null_space(cls, name: str, space: RowSpace, matrix: Expression = None, to: Expression = 0) -> Rows:
        """The exact equalities ``unit_basis x = 0`` of a row space; its zero rows, of dependent rows of J, are free.

        Args:
            name: name of the group.
            space: the row space, of m rows.
            matrix: (m, n), in place of its orthonormal basis.
            to: right-hand side (m, 1).
        """
        lower, upper = (to + space.dependent_bounds(side) for side in (-1, 1))
        return cls(name, space.unit_basis if matrix is None else matrix, lower, upper, exact=True)

    @property
    def count(self) -> int:
        """Number of rows."""
        return int(self.matrix.shape[0])

    @property
    def is_finite(self) -> Expression:
        """1 where every number of the matrix is finite, else 0."""
        return looped(_is_finite, self.matrix, when=self._is_large)[0]

    def product(self, x: Expression) -> Expression:
        """The rows times x, (k, 1).

        Args:
            x: a column (n, 1).
        """
        return looped(_product, self.matrix, x, when=self._is_large)[0]

    def combination(self, multipliers: Expression) -> Expression:
        """The sum of the rows times their multipliers, (n, 1).

        Args:
            multipliers: one for each row (k, 1).
        """
        return looped(_combination, self.matrix, multipliers, when=self._is_large)[0]

    def sizes(self, multipliers: Expression) -> Expression:
        """The length of each row times its multiplier, (k, 1).

        Args:
            multipliers: one for each row (k, 1).
        """
        return looped(_sizes, self.matrix, multipliers, when=self._is_large)[0]

    @property
    def _is_large(self) -> bool:
        return isinstance(self.matrix, SX) and self.matrix.numel() > LARGEST_UNROLLED


def _product(matrix: Expression, x: Expression) -> list[Expression]:
    return [matrix @ x]


def _is_finite(matrix: Expression) -> list[Expression]:
    return [is_finite(matrix)]


def _combination(matrix: Expression, multipliers: Expression) -> list[Expression]:
    return _where_any(multipliers, matrix, (multipliers.T @ matrix).T)


def _sizes(matrix: Expression, multipliers: Expression) -> list[Expression]:
    return _where_any(multipliers, matrix, fabs(multipliers) * sqrt(sum2(matrix**2) + TINY))


def _where_any(multipliers: Expression, matrix: Expression, value: Expression) -> list[Expression]:
    """A value that is zero where all multipliers are: in a call it is evaluated only where one is not."""
    if not isinstance(value, MX):
        return [value]
    given = [multipliers, matrix]
    evaluated = function("evaluated", given, [value])
    found: list[Expression] = either(evaluated, function("zero", given, [MX.zeros(*value.shape)])).call(
        [sum1(fabs(multipliers)) != 0, *given]
    )
    return found
