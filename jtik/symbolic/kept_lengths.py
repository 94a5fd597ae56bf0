"""What rows keep of their length in an orthogonalisation: whether what is left of one is more than rounding.

Derivation: formulations/factorization.md.
"""

from __future__ import annotations

from jtik.symbolic.operations import Expression, fmin, if_else, logic_and, ratio

NOISE = 1e-15
"""The share of its length that a row has kept, times those of the two rows before it that kept least: below this value,
what is left of it is the rounding error of what was subtracted."""


class KeptLengths:
    """What the rows of a factorisation have kept of their squared lengths outside the span of the rows before them."""

    def __init__(self) -> None:
        self._smallest: Expression = 1
        self._two_smallest: Expression = 1

    def more_than_noise(self, i: int, independent: Expression, squared: Expression, whole: Expression) -> Expression:
        """1 if a row is independent and not the rounding of what was subtracted from it.

        Args:
            i: number of the row; they are asked for in order.
            independent: whether what is left is long enough.
            squared: the squared length of what is left of the row.
            whole: that of the row.
        """
        if i == 0:
            return independent
        share = ratio(squared, whole)
        if i > 1:
            independent = logic_and(independent, share * self._two_smallest > NOISE**2)
        share = if_else(independent, share, 1)
        self._two_smallest = fmin(self._two_smallest, self._smallest * share) if i > 1 else share
        self._smallest = fmin(self._smallest, share) if i > 1 else share
        return independent
