"""The rounding error of what rows keep in an orthogonalisation: whether what is left of one is more than that.

Derivation: formulations/factorization.md.
"""

from __future__ import annotations

from collections.abc import Sequence

from jtik.symbolic.operations import Expression, logic_and

ROUNDING = 1.1e-16
"""Relative rounding error of an operation."""

NOISE = 10.0
"""What is left of a row is noise below this multiple of its estimated error."""


class KeptLengths:
    """Squared errors of what the rows of a factorisation have kept outside the span of the rows before them."""

    def __init__(self) -> None:
        self._of_directions: list[Expression] = []

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
        self._noise = ROUNDING**2 * whole
        for share, error in zip(shares, self._of_directions, strict=True):
            self._noise = self._noise + share * error
        return logic_and(independent, squared > NOISE**2 * self._noise) if len(shares) > 1 else independent

    def add(self, inverse: Expression) -> None:
        """Count what is left of the row as a direction.

        Args:
            inverse: the reciprocal of its squared length; 0 for a dependent row.
        """
        self._of_directions.append(self._noise * inverse)
