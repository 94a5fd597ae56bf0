"""Complete orthogonal decomposition of a Jacobian: pseudo-inverse and null-space projector at any rank.

``J = L Q``: the rows of Q are an orthogonal basis of the row space of J (modified Gram-Schmidt), L is lower
trapezoidal with ones where a row is independent. One rank decision is made per row: a row whose part outside the span
of the rows before it is shorter than ``RANK_THRESHOLD`` times the norm of J, or is noise, is left out.
With all rows independent L is triangular and solved by substitution. With dependent rows the columns of L are
orthogonalised too, and the result is the least-squares solution of minimum norm, as from an SVD truncated at the same
threshold.

No Gram matrix is formed, and solutions are recovered from the last row to the first, which makes up for the
orthogonality that Gram-Schmidt loses: a condition number of 1e8 does no more harm here than 1e4 does to a Cholesky
factor of ``J J'`` (formulations/factorization.md).

Source: Golub and Van Loan, *Matrix Computations*, section 5.4 (complete orthogonal decomposition); Bjorck and Paige,
SIAM J. Matrix Anal. Appl. 13, 1992 (the recursion).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf

from jtik.symbolic.direction_errors import DirectionErrors
from jtik.symbolic.ldl import solve_ldl
from jtik.symbolic.operations import (
    TINY,
    Expression,
    dot,
    identity,
    if_else,
    ratio,
    sqrt,
    sumsqr,
    trace,
    vertcat,
    zeros,
)

RANK_THRESHOLD = 1e-8
"""Relative length below which a row of J counts as dependent on the rows before it."""


def squared_length(J: Expression) -> Expression:
    """Square of the Frobenius norm, row by row, so that a factorisation shares its terms.

    Args:
        J: the matrix (m, n).
    """
    return sum(sumsqr(J[i, :].T) for i in range(J.shape[0]))


class RowVector:
    """A vector of the row space by its coordinates in the basis: lengths and products cost m operations instead of n.

    The basis is orthogonal only to the rounding error times the condition number of J. Coordinates and inner products
    with the basis are therefore both kept.

    Args:
        space: the row space.

    Attributes:
        coordinates: m coordinates in the basis.
        products: m inner products of the vector with the rows of the basis, 0 for a dependent row.
        vector: the vector itself (n, 1), built when it is first read.
        image: J times the vector (m, 1), built when it is first read.
    """

    def __init__(
        self,
        space: RowSpace,
        coordinates: Sequence[Expression],
        products: Sequence[Expression],
        vector: Expression | None = None,
    ) -> None:
        self._space, self._vector = space, vector
        self.coordinates = tuple(coordinates)
        self.products = tuple(products)

    @cached_property
    def vector(self) -> Expression:
        """The vector itself, (n, 1)."""
        return self._space.combined(self.coordinates) if self._vector is None else self._vector

    @cached_property
    def image(self) -> Expression:
        """J times the vector, (m, 1)."""
        return self._space._image(self.products)

    @cached_property
    def squared_length(self) -> Expression:
        """Its squared Euclidean length."""
        return self.dot(self)

    def dot(self, other: RowVector) -> Expression:
        """Inner product with another vector of the same row space.

        Args:
            other: the other vector.
        """
        return sum(a * b for a, b in zip(self.coordinates, other.products, strict=True))

    def __rmul__(self, factor: Expression) -> RowVector:
        coordinates, products = ([factor * x for x in entries] for entries in (self.coordinates, self.products))
        return RowVector(self._space, coordinates, products, None if self._vector is None else factor * self._vector)

    def __add__(self, other: RowVector) -> RowVector:
        coordinates = [a + b for a, b in zip(self.coordinates, other.coordinates, strict=True)]
        return RowVector(self._space, coordinates, [a + b for a, b in zip(self.products, other.products, strict=True)])


DAMPING_FLOOR = 1e-16
"""Smallest mu, relative to |J|^2: below it the damped normal equations of a singular J have no factor."""


def damped_multipliers(J: Expression, damping: Expression, r: Expression) -> Expression:
    """``(J J' + mu I)^-1 r`` (m, 1) by L D L'; mu is ``damping`` plus `DAMPING_FLOOR` times |J|^2.

    Args:
        J: the matrix (m, n).
        damping: non-negative, in the unit of J J'.
        r: right-hand side (m, 1).
    """
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
        errors = DirectionErrors()
        for i in range(self._m):
            row = J[i, :].T
            products, coefficients = [], []
            for basis, inverse in zip(self._basis, self._inverse, strict=True):
                products.append(dot(basis, row))
                coefficients.append(products[-1] * inverse)
                row = row - coefficients[-1] * basis
            squared, whole = sumsqr(row), sumsqr(J[i, :].T)
            shares = [a * b for a, b in zip(products, coefficients, strict=True)]
            independent = errors.more_than_noise(squared > limit, squared, whole, shares)
            self._basis.append(row)
            self._squared.append(squared)
            self._inverse.append(ratio(independent, squared))
            errors.add(self._inverse[-1])
            self._lower.append([*coefficients, independent])
            self._products.append(products)
            self._independent.append(independent)

    @cached_property
    def unit_basis(self) -> Expression:
        """Orthonormal rows of the row space, (m, n); zeros for dependent ones."""
        return vertcat(*[(sqrt(i) * b).T for i, b in zip(self._inverse, self._basis, strict=True)])

    @property
    def independent(self) -> Sequence[Expression]:
        """For each row 1 if it is independent of the rows before it, else 0."""
        return self._independent

    def dependent_bounds(self, side: int) -> Expression:
        """Bounds (m, 1) that make ``unit_basis @ x`` zero and leave the zero rows free.

        Args:
            side: -1 for lower bounds, 1 for upper bounds.
        """
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
    def _column_space(self) -> tuple[list[Expression], list[Expression], list[list[Expression]]]:
        """Orthogonal columns of U, their reciprocal squares, and above its unit diagonal R, with ``L = U R``."""
        U: list[Expression] = []
        inverses: list[Expression] = []
        R: list[list[Expression]] = []
        for j in range(self._m):
            column = vertcat(*[0] * j, *[self._lower[i][j] for i in range(j, self._m)])
            coefficients = []
            for basis, inverse in zip(U, inverses, strict=True):
                coefficient = dot(basis, column) * inverse
                column = column - coefficient * basis
                coefficients.append(coefficient)
            U.append(column)
            inverses.append(ratio(1, sumsqr(column)))  # a dependent row left a column of zeros
            R.append(coefficients)
        return U, inverses, R

    def combined(self, coordinates: Sequence[Expression]) -> Expression:
        """The vector (n, 1) with these coordinates.

        Args:
            coordinates: m coordinates in the basis.
        """
        total = zeros(self._n)
        for component, basis in zip(reversed(coordinates), reversed(self._basis), strict=True):
            total = total + component * basis
        return total

    def _image(self, products: Sequence[Expression]) -> Expression:
        """J times a vector of the row space (m, 1) by its inner products with the basis."""
        rows = zip(self._lower, products, strict=True)  # the product with a dependent row is zero already
        return vertcat(*[own + sum(a * b for a, b in zip(row[:-1], products, strict=False)) for row, own in rows])

    def transposed(self, r: Expression) -> RowVector:
        """``J' r``, without the share of dependent rows, which is below the rank threshold.

        Args:
            r: a vector (m, 1).
        """
        m = self._m
        coordinates = [sum(self._lower[k][i] * r[k] for k in range(i, m)) for i in range(m)]
        return self._row_vector(coordinates)

    def least_squares(self, r: Expression) -> RowVector:
        """``J+ r``: the shortest x that minimises ``|J x - r|``.

        Args:
            r: right-hand side (m, 1).
        """
        U, inverses, R = self._column_space
        products: list[Expression] = [0] * self._m
        for j in reversed(range(self._m)):
            products[j] = dot(U[j], r) * inverses[j]
            for k in range(j + 1, self._m):
                products[j] = products[j] - R[k][j] * products[k]
        coordinates, vector = _recovered(products, self._basis, self._inverse, self._n)
        # of two rows a multiple is cheaper to combine anew than to scale
        return RowVector(self, coordinates, products, vector if self._m > 2 else None)

    def damped(self, r: Expression, damping: Expression) -> RowVector:
        """A damped step to ``J x = r``, each row in its turn with its own part of the row space.

        Coordinate i minimises ``|J_i x - r_i|^2 + damping |x_i|^2`` for the coordinates before it, and is at most
        ``|J_i x - r_i| / (2 sqrt(damping))`` long. It costs a tenth of damped least squares beside this factorisation.

        Args:
            r: right-hand side (m, 1).
            damping: non-negative, in the unit of J J'.
        """
        coordinates: list[Expression] = []
        for i in range(self._m):
            left = r[i]
            for product, known in zip(self._products[i], coordinates, strict=True):
                left = left - product * known
            coordinates.append(ratio(left, self._squared[i] + damping))
        products = [squared * x for squared, x in zip(self._squared, coordinates, strict=True)]
        return RowVector(self, coordinates, products)

    def null_part(self, g: Expression) -> Expression:
        """(I - J+ J) g, (n, 1), to the rounding error times the condition number of J.

        Args:
            g: the vector (n, 1).
        """
        for basis, inverse in zip(self._basis, self._inverse, strict=True):
            g = g - (dot(basis, g) * inverse) * basis
        return g

    def split(self, g: Expression) -> Split:
        """A vector as the sum of its part in the null space and its part in the row space.

        Args:
            g: the vector (n, 1).
        """
        coefficients = []
        for basis, inverse in zip(self._basis, self._inverse, strict=True):
            coefficient = dot(basis, g) * inverse
            g = g - coefficient * basis
            coefficients.append(coefficient)
        # a second pass: near a constrained optimum g lies almost in the row space, and the rounding left by the first
        # pass would move the end effector
        g = self.null_part(g)
        U, inverses, R = self._column_space
        y: list[Expression] = []
        for j, above in enumerate(R):
            y.append(coefficients[j] - sum(a * b for a, b in zip(above, y, strict=True)))
        return Split(g, self._row_vector(coefficients), _recovered(y, U, inverses, self._m)[1])

    def _row_vector(self, coordinates: Sequence[Expression]) -> RowVector:
        products = [c * squared for c, squared in zip(coordinates, self._squared, strict=True)]
        return RowVector(self, coordinates, products)


def _recovered(
    products: Sequence[Expression], basis: Sequence[Expression], inverses: Sequence[Expression], size: int
) -> tuple[list[Expression], Expression]:
    """The vector (size, 1) of the span of a basis by its inner products with it: coordinates and the vector itself.

    The recursion of Bjorck and Paige, from the last element to the first. It makes up for the orthogonality that
    Gram-Schmidt loses: the inner products are right to rounding, whatever the condition number.
    """
    x: Expression = zeros(size)
    coordinates: list[Expression] = []
    for product, element, inverse in zip(reversed(products), reversed(basis), reversed(inverses), strict=True):
        # with one element the factor after the product: of two rows the vector itself may not be needed
        other = coordinates[0] * dot(element, basis[-1]) if len(coordinates) == 1 else dot(element, x)
        coordinate = (product - other) * inverse
        x = x + coordinate * element
        coordinates.insert(0, coordinate)
    return coordinates, x
