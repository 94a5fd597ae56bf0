"""Complete orthogonal decomposition of a Jacobian: pseudo-inverse and null-space projector at any rank.

``J = L Q``: the rows of Q are an orthogonal basis of the row space of J (modified Gram-Schmidt), L is lower
trapezoidal with ones where a row is independent. One rank decision is made per row: a row whose part outside the
span of the rows before it is shorter than ``RANK_THRESHOLD`` times the Frobenius norm of J is dependent and left out.
With all rows independent L is triangular and solved by substitution. With dependent rows the columns of L are
orthogonalised too, and the result is the least-squares solution of minimum norm, as from an SVD truncated at the same
threshold.

No Gram matrix is formed: a condition number of 1e8 does no more harm here than 1e4 does to a Cholesky factor of
``J J'``.

Source: Golub and Van Loan, *Matrix Computations*, section 5.4 (complete orthogonal decomposition).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf

from jtik.symbolic.operations import (
    TINY,
    Expression,
    dot,
    identity,
    if_else,
    ratio,
    solve_ldl,
    sqrt,
    sumsqr,
    trace,
    vertcat,
    zeros,
)

RANK_THRESHOLD = 1e-8
"""Relative length below which a row of J counts as dependent on the rows before it."""


def squared_length(J: Expression) -> Expression:
    """Square of the Frobenius norm, row by row, so that a factorisation shares its terms."""
    return sum(sumsqr(J[i, :].T) for i in range(J.shape[0]))


class RowVector:
    """A vector of the row space by its coordinates in the basis: lengths and products cost m operations instead of n.

    Attributes:
        coordinates: m coordinates in the basis.
        vector: the vector itself (n, 1), built when it is first read.
        image: J times the vector (m, 1), built when it is first read.
    """

    def __init__(self, space: RowSpace, coordinates: Sequence[Expression]) -> None:
        self._space = space
        self.coordinates = tuple(coordinates)

    @cached_property
    def vector(self) -> Expression:
        """The vector itself, (n, 1)."""
        return self._space.combined(self.coordinates)

    @cached_property
    def image(self) -> Expression:
        """J times the vector, (m, 1)."""
        return self._space.image(self.coordinates)

    @cached_property
    def squared_length(self) -> Expression:
        """Its squared Euclidean length."""
        return self.dot(self)

    def dot(self, other: RowVector) -> Expression:
        """Inner product with another vector of the same row space."""
        return self._space.inner(self.coordinates, other.coordinates)

    def __rmul__(self, factor: Expression) -> RowVector:
        return RowVector(self._space, [factor * c for c in self.coordinates])

    def __add__(self, other: RowVector) -> RowVector:
        return RowVector(self._space, [a + b for a, b in zip(self.coordinates, other.coordinates, strict=True)])


DAMPING_FLOOR = 1e-16
"""Smallest lambda, relative to |J|^2: below it the damped normal equations of a singular J have no factor."""


def damped_multipliers(J: Expression, damping: Expression, r: Expression) -> Expression:
    """``(J J' + lambda I)^-1 r`` (m, 1) by L D L'; lambda is ``damping`` plus `DAMPING_FLOOR` times |J|^2."""
    gram = J @ J.T
    floor = DAMPING_FLOOR * trace(gram) + TINY
    return solve_ldl(gram + (damping + floor) * identity(J.shape[0]), r)


@dataclass(frozen=True)
class Split:
    """A gradient g split by the row space of J.

    Attributes:
        null: (I - J+ J) g, (n, 1), the part in the null space.
        rest: J+ J g, the part in the row space.
        multipliers: (J')+ g, (m, 1).
    """

    null: Expression
    rest: RowVector
    multipliers: Expression


class RowSpace:
    """Row space of a symbolic ``J`` (m, n): pseudo-inverse, null-space projection and rank from one factorisation.

    Args:
        J: the matrix (m, n).
        threshold: relative length below which a row counts as dependent on the rows before it.
        squared_scale: the square of the length that the threshold is relative to; by default the squared Frobenius
            norm of J. Give it for a J that remains of larger rows after a projection: all of it may be rounding.

    Attributes:
        squared_length: the squared Frobenius norm of J.
    """

    def __init__(
        self, J: Expression, *, threshold: float = RANK_THRESHOLD, squared_scale: Expression | None = None
    ) -> None:
        self._m, self._n = J.shape
        self.squared_length = squared_length(J)
        limit = threshold**2 * (self.squared_length if squared_scale is None else squared_scale)
        self._basis: list[Expression] = []
        self._inverse: list[Expression] = []
        self._squared: list[Expression] = []
        self._lower: list[list[Expression]] = []
        self._products: list[list[Expression]] = []
        self._independent: list[Expression] = []
        for i in range(self._m):
            row = J[i, :].T
            products, coefficients = [], []
            for basis, inverse in zip(self._basis, self._inverse, strict=True):
                product = dot(basis, row)
                coefficient = product * inverse
                products.append(product)
                row = row - coefficient * basis
                coefficients.append(coefficient)
            squared = sumsqr(row)
            independent = squared > limit
            self._basis.append(row)
            self._squared.append(squared)
            self._inverse.append(ratio(independent, squared))
            self._lower.append([*coefficients, independent])
            self._products.append(products)
            self._independent.append(independent)

    @cached_property
    def unit_basis(self) -> Expression:
        """Orthonormal rows of the row space, (m, n); zeros for dependent ones."""
        return vertcat(*[(sqrt(i) * b).T for i, b in zip(self._inverse, self._basis, strict=True)])

    def dependent_bounds(self, side: int) -> Expression:
        """Bounds (m, 1) that make ``unit_basis @ x`` zero and leave the zero rows free: ``side`` -1 lower, 1 upper."""
        return vertcat(*[if_else(independent, 0, side * inf) for independent in self._independent])

    @cached_property
    def volume(self) -> Expression:
        """sqrt(det J J') where m <= n, the manipulability: the product of the lengths of the rows' orthogonal parts."""
        volume: Expression = 1
        for squared in self._squared:
            volume = volume * sqrt(squared + TINY)
        return volume

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
            length = sqrt(sumsqr(column) + TINY)  # a dependent row left a column of zeros
            U.append(column / length)
            R[j].append(length)
        return U, R

    def combined(self, coordinates: Sequence[Expression]) -> Expression:
        """The vector (n, 1) with these coordinates."""
        total = zeros(self._n)
        for component, basis in zip(coordinates, self._basis, strict=True):
            total = total + component * basis
        return total

    def image(self, coordinates: Sequence[Expression]) -> Expression:
        """J times the vector with these coordinates, (m, 1)."""
        scaled = [c * squared for c, squared in zip(coordinates, self._squared, strict=True)]
        return vertcat(*[sum(a * b for a, b in zip(row, scaled, strict=False)) for row in self._lower])

    def inner(self, first: Sequence[Expression], second: Sequence[Expression]) -> Expression:
        """Inner product of two vectors given by coordinates."""
        # the length first: the square of a coordinate alone could overflow
        return sum(a * length * b for a, b, length in zip(first, second, self._squared, strict=True))

    def transposed(self, r: Expression) -> RowVector:
        """``J' r``, without the share of dependent rows, which is below the rank threshold."""
        m = self._m
        return RowVector(self, [sum(self._lower[k][i] * r[k] for k in range(i, m)) for i in range(m)])

    def least_squares(self, r: Expression) -> RowVector:
        """``J+ r``: the shortest x that minimises ``|J x - r|``."""
        U, R = self._column_space
        y: list[Expression] = [0] * self._m
        for i in reversed(range(self._m)):
            total = dot(U[i], r)
            for j in range(i + 1, self._m):
                total = total - R[i][j - i] * y[j]
            y[i] = total / R[i][0]
        return RowVector(self, [component * inverse for component, inverse in zip(y, self._inverse, strict=True)])

    def damped(self, r: Expression, damping: Expression) -> RowVector:
        """A damped step to ``J x = r``, each row in its turn with its own part of the row space.

        Coordinate i minimises ``|J_i x - r_i|^2 + damping |x_i|^2`` for the coordinates before it, and is at most
        ``|J_i x - r_i| / (2 sqrt(damping))`` long. It costs a tenth of damped least squares beside this factorisation.
        """
        coordinates: list[Expression] = []
        for i in range(self._m):
            left = r[i]
            for product, known in zip(self._products[i], coordinates, strict=True):
                left = left - product * known
            coordinates.append(ratio(left, self._squared[i] + damping))
        return RowVector(self, coordinates)

    def split(self, g: Expression) -> Split:
        """g as the sum of its part in the null space and its part in the row space."""
        coefficients = []
        for basis, inverse in zip(self._basis, self._inverse, strict=True):
            coefficient = dot(basis, g) * inverse
            g = g - coefficient * basis
            coefficients.append(coefficient)
        # a second pass: near a constrained optimum g lies almost in the row space, and the rounding left by the first
        # pass would move the end effector
        for basis, inverse in zip(self._basis, self._inverse, strict=True):
            g = g - (dot(basis, g) * inverse) * basis
        U, R = self._column_space
        y: list[Expression] = []
        for i in range(self._m):
            total = coefficients[i]
            for j in range(i):
                total = total - R[j][i - j] * y[j]
            y.append(total / R[i][0])
        solution = zeros(self._m)
        for component, unit in zip(y, U, strict=True):
            solution = solution + component * unit
        return Split(g, RowVector(self, coefficients), solution)
