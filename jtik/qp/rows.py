"""Rows of a quadratic program: named groups of linear constraints, hard or elastic."""

from __future__ import annotations

from dataclasses import dataclass

from jtik.qp.elastic import Elastic
from jtik.symbolic import Expression


@dataclass(frozen=True)
class Rows:
    """A named group of rows ``lower <= matrix x <= upper``; equal bounds are an equality.

    Attributes:
        name: name of the group.
        matrix: (k, n).
        lower: lower bounds (k, 1).
        upper: upper bounds (k, 1).
        elastic: how far the rows may be relaxed, with which penalty; None for hard rows.
    """

    name: str
    matrix: Expression
    lower: Expression
    upper: Expression
    elastic: Elastic | None = None

    @classmethod
    def equal(cls, name: str, matrix: Expression, to: Expression, elastic: Elastic | None = None) -> Rows:
        """The equalities ``matrix x = to``."""
        return cls(name, matrix, to, to, elastic)

    @property
    def count(self) -> int:
        """Number of rows."""
        return int(self.matrix.shape[0])
