"""The null vector of a matrix with one column more than rows, by Householder reflections.

``J H_1 ... H_m = [R 0]`` with R lower triangular. The diagonal of R has the lengths that the rows have outside the span
of the rows before them. The last column of ``H_1 ... H_m`` spans the null space of a J of full rank and m + 1 columns.
It takes three fifths of the operations of `RowSpace`, which knows the null space at any rank.

Source: Golub and Van Loan, *Matrix Computations*, section 5.2.
"""

from __future__ import annotations

from functools import cached_property

import casadi

from jtik.symbolic.factorization import RANK_THRESHOLD
from jtik.symbolic.operations import Expression, dot, fabs, logic_and, ratio, sqrt, sumsqr, vertcat


class Reflections:
    """The reflections that make a symbolic ``J`` (m, n) with m <= n lower triangular.

    Attributes:
        full_rank: 1 where the part of every row outside the span of the rows before it is longer than
            `RANK_THRESHOLD` times the norm of all these parts; else 0.
    """

    def __init__(self, J: Expression) -> None:
        m = J.shape[0]
        rows = [J[i, :].T for i in range(m)]  # from the diagonal on
        self._vectors = list[tuple[Expression, Expression, Expression]]()  # first entry, the others, factor
        squared = list[Expression]()
        for k in range(m):
            edge, rest = rows[k][0], rows[k][1:]
            squared.append(sumsqr(rows[k]))
            length = sqrt(squared[k])
            # a product with 1 / x would become a division
            u, factor = edge + casadi.copysign(length, edge), ratio(length > 0, squared[k] + fabs(edge) * length)
            self._vectors.append((u, rest, factor))
            for i in range(k + 1, m):  # u, which is known last, is added last
                rows[i] = rows[i][1:] - ((dot(rest, rows[i][1:]) + u * rows[i][0]) * factor) * rest
        shortest = RANK_THRESHOLD**2 * sum(squared)
        self.full_rank: Expression = 1
        for each in squared:
            self.full_rank = logic_and(self.full_rank, each > shortest)

    @cached_property
    def null_vector(self) -> Expression:
        """The unit vector (n, 1) of the null space of a J of full rank with n = m + 1."""
        z: Expression = 1
        for u, rest, factor in reversed(self._vectors):
            share = dot(rest, z) * factor
            z = vertcat(-share * u, z - share * rest)
        return z

    def null_part(self, g: Expression) -> Expression:
        """The part of ``g`` (n, 1) in that null space, (n, 1).

        Args:
            g: the vector (n, 1).
        """
        return dot(self.null_vector, g) * self.null_vector
