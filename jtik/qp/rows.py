"""Rows of a quadratic program: named groups of linear constraints, hard or elastic."""

from __future__ import annotations

from dataclasses import dataclass

from jtik.qp.elastic import Elastic
from jtik.symbolic import Expression
from jtik.symbolic.factorization import RowSpace


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
