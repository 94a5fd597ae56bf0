"""Distances of bodies to many obstacles as functions with loops over the pairs.

What is computed for one pair is there once, in text and in time to compile, however many there are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import NamedTuple

import numpy as np

from jtik.geometry.pair_functions import Distances, distance_function, figures_of
from jtik.geometry.slots import ABSENT
from jtik.symbolic import (
    MX,
    Expression,
    Function,
    Sparsity,
    densify,
    function,
    horzcat,
    if_else,
    is_equal,
    jacobian,
    repmat,
    vertcat,
    zeros,
)
from jtik.symbolic.block_products import block_products
from jtik.symbolic.many_columns import of_many

LARGEST_UNROLLED = 3000
"""Operations of all pairs up to which they are written out: for so few loops would be slower."""


class Pair(NamedTuple):
    """Two bodies, or a body and an obstacle.

    Attributes:
        measure: (points, figures) -> distance, and the same with its gradient by each point: functions of scalars.
        points: which of the points it is given.
        figures: first of the figures of the obstacle; 0 of a pair without any.
        radius: radius around both bodies [m].
    """

    measure: tuple[Function, Function]
    points: tuple[int, ...]
    figures: int
    radius: float


@dataclass(frozen=True)
class ManyDistances:
    """Signed distances of many pairs.

    Attributes:
        q: configuration (nq, 1), symbols.
        parameters: all live parameters, symbols.
        points: points of the bodies (d, 1) [m], as expressions of q.
        pairs: the pairs.
        bodies: number of distances of each body, in their order.
        figures: what the distances to obstacles are computed from besides, a column of expressions of the parameters.
        gains: the gain of each pair (k, 1), 0 of one that is absent; None where all are there.
        alike: whether all pairs of a body have the same points, and each body as many pairs.
    """

    q: Expression
    parameters: Expression
    points: Sequence[Expression]
    pairs: Sequence[Pair]
    bodies: Sequence[int]
    figures: Expression
    gains: Expression | None = None
    alike: bool = False

    @classmethod
    def to_obstacles(
        cls,
        q: Expression,
        parameters: Expression,
        bodies: Sequence[Sequence[Expression]],
        radii: Sequence[float],
        obstacles: Sequence[Distances],
        gains: Expression | None,
    ) -> ManyDistances:
        """Those of each body to each obstacle, body by body.

        Args:
            q: configuration (nq, 1), symbols.
            parameters: all live parameters, symbols.
            bodies: for each body one point, or both ends of a segment, (d, 1) [m] each, as expressions of q.
            radii: radius around each body [m].
            obstacles: the obstacles as expressions of the parameters.
            gains: the gain of each obstacle (obstacles, 1), 0 of one that is absent; None where all are there.
        """
        points, places = list[Expression](), list[tuple[int, ...]]()
        for body in bodies:  # each point once: links share their ends
            own = []
            for point in body:
                found = next((i for i, each in enumerate(points) if is_equal(point, each)), len(points))
                points += [point] if found == len(points) else []
                own.append(found)
            places.append(tuple(own))
        starts = np.cumsum([0, *(sum(each.form[2]) for each in obstacles)]).tolist()
        size = int(bodies[0][0].shape[0])
        pairs = []
        for own_points, radius in zip(places, radii, strict=True):
            for each, start in zip(obstacles, starts, strict=False):
                count = len(own_points)
                of = [distance_function(each.form, count, size, gradients=gradients) for gradients in (False, True)]
                pairs.append(Pair((of[0], of[1]), own_points, start, radius))
        of_pairs = None if gains is None else repmat(gains, len(bodies), 1)
        counts = [len(obstacles)] * len(bodies)
        return cls(q, parameters, points, pairs, counts, figures_of(obstacles), of_pairs, alike=True)

    @property
    def are_many(self) -> bool:
        """Whether there are loops over the pairs."""
        return bool(sum(pair.measure[1].n_instructions() for pair in self.pairs) > LARGEST_UNROLLED)

    @cached_property
    def shared(self) -> Function:
        """(q, parameters) -> what the distances are made of: points, figures, gains; a column."""
        gains = [] if self.gains is None else [self.gains]
        parts = vertcat(*self.points, self.figures, *gains)
        return function("measured", [self.q, self.parameters], [parts])

    @cached_property
    def own(self) -> Function:
        """(q, parameters, what `shared` returns) -> all distances (k, 1)."""
        sizes = (self.q.shape[0], self.parameters.shape[0], self.shared.size1_out(0))
        given = [MX.sym(f"i{i}", size) for i, size in enumerate(sizes)]
        return function("distances", given, [self._measured(given[2])[0].T], cse=False)

    def linearized(self, q: Expression, parameters: Expression, tangent: Expression) -> list[Expression]:
        """All distances (k, 1), and their derivative by the velocity (k, n).

        Args:
            q: configuration (nq, 1), of matrix expressions.
            parameters: all live parameters, of matrix expressions.
            tangent: the tangent map at the symbols of q (nq, n).
        """
        distances, gradients = self._measured(self.shared(q, parameters), gradients=True)
        rates = [jacobian(point, self.q) @ tangent for point in self.points]
        if not self.alike:
            sparse = vertcat(*rates)
            nonzeros = vertcat(*[sparse.nz[i] for i in range(sparse.nnz())])
            moving = MX(sparse.sparsity(), function("rates", [self.q], [nonzeros])(q))
            return [distances.T, densify(self._by_points(gradients) @ moving)]
        ends, none = len(gradients), zeros(self._dimension, tangent.shape[1])
        of_bodies, start = [], 0
        for count in self.bodies:
            own = [rates[i] for i in self.pairs[start].points]
            of_bodies.append(vertcat(*own, *[none] * (ends - len(own))))
            start += count
        moving = function("rates", [self.q], [horzcat(*of_bodies)])(q)
        return [distances.T, block_products(vertcat(*gradients).T, moving, len(self.bodies))]

    def _by_points(self, gradients: Sequence[Expression]) -> Expression:
        """The gradients of each distance by all points (k, all points): sparse."""
        d, rows, columns = self._dimension, list[int](), list[int]()
        for end in range(len(gradients)):
            for axis in range(d):
                rows += range(len(self.pairs))
                columns += [d * pair.points[end] + axis for pair in self.pairs]
        shape = len(self.pairs), d * len(self.points)
        order = np.lexsort((rows, columns)).tolist()  # the order of the nonzeros of a sparse matrix
        pattern = Sparsity.triplet(*shape, [rows[i] for i in order], [columns[i] for i in order])
        entries = horzcat(*[each[axis, :] for each in gradients for axis in range(d)])
        return MX(pattern, entries[:, order].T)

    def _measured(self, values: Expression, *, gradients: bool = False) -> tuple[Expression, list[Expression]]:
        """All distances (1, k), and their gradients with respect to each point of the pairs (d, k).

        Args:
            values: what `shared` returns.
            gradients: whether there are gradients.
        """
        ends = max(len(pair.points) for pair in self.pairs) if gradients else 0
        parts: list[list[Expression]] = [[] for _ in range(1 + ends)]

        kinds = [hash(pair.measure[gradients]) for pair in self.pairs]
        order = sorted(range(len(self.pairs)), key=lambda i: kinds.index(kinds[i]))
        for _, group in groupby(order, key=lambda i: kinds[i]):
            distance, *slopes = self._of_alike(values, list(group), gradients=gradients)
            none = MX.zeros(self._dimension, distance.shape[1])
            for part, each in zip(parts, [distance, *slopes, *[none] * (ends - len(slopes))], strict=True):
                part.append(each)
        found = [horzcat(*part) for part in parts]
        if len(set(kinds)) > 1:
            place = {pair: i for i, pair in enumerate(order)}
            found = [each[:, [place[pair] for pair in range(len(order))]] for each in found]
        return found[0], found[1:]

    def _of_alike(self, values: Expression, group: Sequence[int], *, gradients: bool) -> list[Expression]:
        """Distances (1, pairs) of these pairs of one kind, and gradients (d, pairs) by each point."""
        d, pairs, rows = self._dimension, [self.pairs[i] for i in group], values.T
        measure, begin = pairs[0].measure[gradients], d * len(self.points)
        arguments, start = [], 0
        for i in range(measure.n_in()):
            if i < len(pairs[0].points):
                places = [d * pair.points[i] for pair in pairs]
            else:
                places = [begin + pair.figures + start for pair in pairs]
                start += measure.size1_in(i)
            arguments.append([rows[:, [place + row for place in places]] for row in range(measure.size1_in(i))])
        (distance,), *slopes = of_many(measure, arguments)
        radii = [pair.radius for pair in pairs]
        if any(radii):
            distance = distance - MX(radii).T
        if self.gains is not None:
            first = values.shape[0] - len(self.pairs)
            present = rows[:, [first + i for i in group]] > 0
            distance = if_else(present, distance, ABSENT)
            slopes = [[present * row for row in each] for each in slopes]
        # a derivative that is the same for all pairs is one number
        wide = [[repmat(row, 1, len(radii) // row.shape[1]) for row in each] for each in slopes]
        return [distance, *(vertcat(*each) for each in wide)]

    @property
    def _dimension(self) -> int:
        return int(self.points[0].shape[0])
