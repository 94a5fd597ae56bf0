"""Distances of bodies to many obstacles as functions with loops over the pairs.

What is computed for one pair is there once, in text and in time to compile, however many there are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import chain, groupby, pairwise
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
    reshape,
    symbol,
    vec,
    vertcat,
    zeros,
)
from jtik.symbolic.block_products import block_products
from jtik.symbolic.row_by_row import row_by_row

FEW = 30
"""Pairs of bodies and obstacles up to which they are written out, body by body: for so few loops are slower."""

FEW_OPERATIONS = 3000
"""Operations of other pairs up to which they are written out."""

GROUP = 60
"""Pairs of a group of bodies from which on another body belongs to the next group."""


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
        if self.alike:
            return len(self.pairs) > FEW
        return bool(sum(pair.measure[1].n_instructions() for pair in self.pairs) > FEW_OPERATIONS)

    @cached_property
    def shared(self) -> Function:
        """(q, parameters) -> what the distances are made of: points, figures, gains; a column."""
        gains = [] if self.gains is None else [self.gains]
        parts = vertcat(*self.points, self.figures, *gains)
        return function("measured", [self.q, self.parameters], [parts])

    @cached_property
    def own(self) -> list[Function]:
        """For each group of bodies (q, parameters, what `shared` returns) -> its distances, a column.

        A group has bodies next to each other: loops over few pairs are slow, and not all bodies are near on every path.
        """
        sizes = (self.q.shape[0], self.parameters.shape[0], self.shared.size1_out(0))
        given, found = [MX.sym(f"i{i}", size) for i, size in enumerate(sizes)], []
        for start, end in pairwise(np.cumsum([0, *self.sizes]).tolist()):
            distances, _ = self._measured(given[2], range(start, end))
            found.append(function("distances", given, [distances], cse=False))
        return found

    @cached_property
    def sizes(self) -> list[int]:
        """Number of distances of each group of bodies."""
        found = [0]
        for count in self.bodies:
            if found[-1] >= GROUP:
                found.append(0)
            found[-1] += count
        return found

    def linearized(self, q: Expression, parameters: Expression, tangent: Expression) -> list[Expression]:
        """All distances (k, 1), and their derivative by the velocity (k, n).

        Args:
            q: configuration (nq, 1), of matrix expressions.
            parameters: all live parameters, of matrix expressions.
            tangent: the tangent map at the symbols of q (nq, n).
        """
        distances, found = self._measured(self.shared(q, parameters), range(len(self.pairs)), gradients=True)
        rates = [jacobian(point, self.q) @ tangent for point in self.points]
        if not self.alike:
            sparse = vertcat(*rates)
            nonzeros = vertcat(*[sparse.nz[i] for i in range(sparse.nnz())])
            moving = MX(sparse.sparsity(), function("rates", [self.q], [nonzeros])(q))
            return [distances, densify(self._by_points(found[:, 1:]) @ moving)]
        none = zeros(self._dimension, tangent.shape[1])
        of_bodies, start = [], 0
        for count in self.bodies:
            own = [rates[i] for i in self.pairs[start].points]
            of_bodies.append(vertcat(*own, *[none] * (self._ends - len(own))))
            start += count
        moving = function("rates", [self.q], [horzcat(*of_bodies)])(q)
        return [distances, block_products(found, moving, len(self.bodies))]

    def _by_points(self, gradients: Expression) -> Expression:
        """The gradients of each distance by all points (k, all points): sparse."""
        d, rows, columns = self._dimension, list[int](), list[int]()
        for end in range(self._ends):
            for axis in range(d):
                rows += range(len(self.pairs))
                columns += [d * pair.points[end] + axis for pair in self.pairs]
        order = np.lexsort((rows, columns)).tolist()  # the order of the nonzeros of a sparse matrix
        shape, places = (len(self.pairs), d * len(self.points)), ([each[i] for i in order] for each in (rows, columns))
        pattern = Sparsity.triplet(*shape, *places)
        return MX(pattern, vec(gradients)[order])

    def _measured(self, values: Expression, chosen: range, *, gradients: bool = False) -> tuple[Expression, Expression]:
        """Distances (k, 1) of some pairs, and columns; the last are their gradients by the entries of each point.

        Args:
            values: what `shared` returns.
            chosen: which of the pairs.
            gradients: whether there are gradients; none otherwise.
        """
        kinds = {i: hash(self.pairs[i].measure[gradients]) for i in chosen}
        first = list(dict.fromkeys(kinds.values()))
        order = sorted(chosen, key=lambda i: first.index(kinds[i]))
        groups = [list(group) for _, group in groupby(order, key=kinds.__getitem__)]
        parts = [self._of_alike(values, group, gradients=gradients) for group in groups]
        found = parts[0]
        if len(parts) > 1:
            place = {pair: i for i, pair in enumerate(order)}
            found = horzcat(*[part.T for part in parts])[:, [place[i] for i in chosen]].T
        distances = found[:, 0]
        radii = [self.pairs[i].radius for i in chosen]
        if any(radii):
            distances = distances - MX(radii)
        if self.gains is not None:
            gains = values[values.shape[0] - len(self.pairs) :]
            present = gains[chosen.start : chosen.stop] > 0
            distances = if_else(present, distances, ABSENT)
            found = repmat(present, 1, found.shape[1]) * found
        return distances, found

    def _of_alike(self, values: Expression, group: Sequence[int], *, gradients: bool) -> Expression:
        """The distance of each of these pairs of one kind, and its gradients, a row (1 + ends d)."""
        d, pairs = self._dimension, [self.pairs[i] for i in group]
        measure, begin = pairs[0].measure[gradients], d * len(self.points)
        figures = sum(measure.size1_in(i) for i in range(len(pairs[0].points), measure.n_in()))
        columns = [
            [d * pair.points[end] + axis for pair in pairs] for end in range(len(pairs[0].points)) for axis in range(d)
        ]
        columns += [[begin + pair.figures + k for pair in pairs] for k in range(figures)]
        rows = reshape(values[list(chain(*columns))], len(pairs), len(columns))
        found = row_by_row(_of_column(measure), rows)
        missing = (self._ends * d if gradients else 0) - (found.shape[1] - 1)
        return horzcat(found, MX.zeros(len(pairs), missing)) if missing else found

    @property
    def _ends(self) -> int:
        """Largest number of points of a pair."""
        return max(len(pair.points) for pair in self.pairs)

    @property
    def _dimension(self) -> int:
        return int(self.points[0].shape[0])


@cache
def _of_column(measure: Function) -> Function:
    """A function of columns as one of a single column, with one column of results."""
    column, parts, start = symbol("column", sum(measure.size1_in(i) for i in range(measure.n_in()))), [], 0
    for i in range(measure.n_in()):
        parts.append(column[start : start + measure.size1_in(i)])
        start += measure.size1_in(i)
    return function(measure.name(), [column], [vertcat(*measure.call(parts, True, False))])
