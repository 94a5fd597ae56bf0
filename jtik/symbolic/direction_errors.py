"""The rounding errors of the directions of an orthogonalisation: whether what is left of a row is more than that.

Derivation: formulations/factorization.md.
"""

from __future__ import annotations

from collections.abc import Sequence

from jtik.symbolic.operations import Expression, logic_and

ROUNDING = 1.1e-16
"""Relative rounding error of an operation."""

NOISE = 10.0
"""What is left of a row is noise below this multiple of its estimated error."""


class DirectionErrors:
    """Squared rounding errors of the directions of a row space, relative to their lengths; rows are taken in order."""

    def __init__(self) -> None:
        self._squared: list[Expression] = []
        self._of_row: Expression = 0

    def more_than_noise(
        self, independent: Expression, squared: Expression, whole: Expression, shares: Sequence[Expression]
    ) -> Expression:
        """1 if a row is independent and what is left of it is not the error of what was subtracted.

        Args:
            independent: whether what is left is long enough.
            squared: the squared length of what is left of the row.
            whole: that of the row.
            shares: what each row before it has taken of that.
        """
        self._of_row = ROUNDING**2 * whole
        for share, error in zip(shares, self._squared, strict=True):
            self._of_row = self._of_row + share * error
        return logic_and(independent, squared > NOISE**2 * self._of_row) if len(shares) > 1 else independent

    def add(self, inverse: Expression) -> None:
        """Count what is left of the row as a direction.

        Args:
            inverse: the reciprocal of its squared length; 0 for a dependent row.
        """
        self._squared.append(self._of_row * inverse)
