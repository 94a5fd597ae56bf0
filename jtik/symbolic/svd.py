"""Singular value decomposition of a Jacobian as one expression of fixed length: one-sided Jacobi rotations.

``J = U S V'``: pairs of rows are rotated in their plane until all rows are orthogonal. The rows are then
``sigma_i v_i``, and the product of the rotations is U'. A rotation has no branches, so a decomposition can be fused,
differentiated and compiled. The number of rotations that is enough is known for the few rows of a task
(formulations/svd.md).

Nothing is divided by a singular value, so an exactly singular J needs no special case.

Source: Hestenes (1958); Nash (1975), for rotations that also sort; Golub and Van Loan, *Matrix Computations*, 8.6.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from jtik.errors import ArgumentError
from jtik.symbolic.operations import TINY, Expression, dot, fabs, fmax, fmin, if_else, sqrt, sumsqr, vertcat, zeros

SWEEPS = {1: 0, 2: 1, 3: 5, 4: 5, 5: 6, 6: 6}
"""Sweeps over all pairs after which m rows are orthogonal to working precision, by m; measured."""

MAX_SWEEPS = 8
"""The number of sweeps for more rows; measured up to 16 rows."""


class SingularValues:
    """Singular values and vectors of a symbolic ``J`` (m, n), the largest first.

    Values below 1e-8 of the largest are as accurate as the others, but may stand in any order.

    Args:
        J: the matrix, any m and n; for m > n the last m - n singular values are zero.
        sweeps: sweeps over all pairs of rows; by default as many as m needs.

    Attributes:
        rows: sigma_i v_i, m columns (n, 1), orthogonal to each other.
        squared: sigma_i^2, m scalars.

    Raises:
        ArgumentError: when the number of sweeps is negative.
    """

    def __init__(self, J: Expression, *, sweeps: int | None = None) -> None:
        self._m, self._n = J.shape
        if sweeps is not None and sweeps < 0:
            raise ArgumentError("sweeps", sweeps, "a non-negative number, or None for as many as the rows need")
        rounds = SWEEPS.get(self._m, MAX_SWEEPS) if sweeps is None else sweeps
        rows = [J[i, :].T for i in range(self._m)]
        self._rotations: list[tuple[int, int, Expression, Expression]] = []
        for _ in range(rounds):
            squared = [sumsqr(row) for row in rows]
            for p in range(self._m - 1):
                for q in range(p + 1, self._m):
                    c, s, gain = _rotation(squared[p], squared[q], dot(rows[p], rows[q]))
                    self._rotations.append((p, q, c, s))
                    rows[p], rows[q] = c * rows[p] + s * rows[q], c * rows[q] - s * rows[p]
                    larger, smaller = fmax(squared[p], squared[q]), fmin(squared[p], squared[q])
                    squared[p], squared[q] = larger + gain, smaller - gain
        self.rows: tuple[Expression, ...] = tuple(rows)
        self.squared: tuple[Expression, ...] = tuple(sumsqr(row) for row in rows)

    @cached_property
    def values(self) -> tuple[Expression, ...]:
        """sigma_i, the largest first."""
        return tuple(sqrt(squared + TINY) for squared in self.squared)

    def components(self, r: Expression) -> list[Expression]:
        """u_i' r of a vector (m, 1), by the rotations of the rows, without computing U.

        Args:
            r: the vector (m, 1).
        """
        entries = [r[i] for i in range(self._m)]
        for p, q, c, s in self._rotations:
            entries[p], entries[q] = c * entries[p] + s * entries[q], c * entries[q] - s * entries[p]
        return entries

    @cached_property
    def left(self) -> tuple[Expression, ...]:
        """u_i, m columns (m, 1), orthonormal at any rank."""
        unit = [[1 if i == j else 0 for j in range(self._m)] for i in range(self._m)]
        entries = [self.components(column) for column in unit]
        return tuple(vertcat(*[entries[j][i] for j in range(self._m)]) for i in range(self._m))

    def combined(self, gains: Sequence[Expression]) -> Expression:
        """The sum of gain_i sigma_i v_i, (n, 1).

        Args:
            gains: one gain for each singular value, the largest first.
        """
        total = zeros(self._n)
        for gain, row in zip(gains, self.rows, strict=True):
            total = total + gain * row
        return total

    def image(self, gains: Sequence[Expression]) -> Expression:
        """J times ``combined(gains)``: the sum of gain_i sigma_i^2 u_i, (m, 1), by the inverse rotations.

        Args:
            gains: one gain for each singular value, the largest first.
        """
        entries = [gain * squared for gain, squared in zip(gains, self.squared, strict=True)]
        for p, q, c, s in reversed(self._rotations):
            entries[p], entries[q] = c * entries[p] - s * entries[q], s * entries[p] + c * entries[q]
        return vertcat(*entries)


def _rotation(a: Expression, b: Expression, product: Expression) -> tuple[Expression, Expression, Expression]:
    """Cosine and sine of the rotation that makes two rows orthogonal and the first the longer one, and its gain.

    With their squared lengths a and b and their inner product g: tan 2phi = 2 g / (a - b). Of the two solutions the
    one is taken that leaves max(a, b) + ``gain`` and min(a, b) - ``gain`` as squared lengths, in this order. Where
    both a - b and g are zero the rows stay as they are.
    """
    difference = a - b
    tangent = 2 * product / (fabs(difference) + sqrt(difference**2 + 4 * product**2 + TINY) + TINY)
    cosine = 1 / sqrt(1 + tangent**2)
    sine = tangent * cosine
    ordered = difference >= 0
    return if_else(ordered, cosine, sine), if_else(ordered, sine, cosine), tangent * product
