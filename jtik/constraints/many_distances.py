"""Distances of bodies to many obstacles as functions with loops over the pairs.

What is computed for one pair is there once, in text and in time to compile, however many there are.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import groupby

from jtik.geometry.pair_functions import Distances, distance_function, figures_of
from jtik.geometry.slots import ABSENT
from jtik.symbolic import (
    MX,
    Expression,
    Function,
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


@dataclass(frozen=True)
class ManyDistances:
    """Signed distances of each body of a robot to each obstacle, body by body.

    Attributes:
        q: configuration (nq, 1), symbols.
        parameters: all live parameters, symbols.
        bodies: for each body one point, or both ends of a segment, (d, 1) [m] each, as expressions of q.
        radii: radius around each body [m].
        obstacles: the obstacles as expressions of the parameters.
        gains: the gain of each obstacle (obstacles, 1), 0 of one that is absent; None where all are there.
    """

    q: Expression
    parameters: Expression
    bodies: Sequence[Sequence[Expression]]
    radii: Sequence[float]
    obstacles: Sequence[Distances]
    gains: Expression | None = None

    @cached_property
    def shared(self) -> Function:
        """(q, parameters) -> what the distances are made of: points, figures of the obstacles, gains; a column."""
        gains = [] if self.gains is None else [self.gains]
        return function(
            "measured", [self.q, self.parameters], [vertcat(*self._points, figures_of(self.obstacles), *gains)]
        )

    @cached_property
    def own(self) -> Function:
        """(q, parameters, what `shared` returns) -> all distances (k, 1)."""
        q, parameters, values = self._symbols()
        return function("distances", [q, parameters, values], [self._measured(values)[0].T], cse=False)

    def linearized(self, q: Expression, parameters: Expression, tangent: Expression) -> list[Expression]:
        """All distances (k, 1), and their derivative by the velocity (k, n).

        Args:
            q: configuration (nq, 1), of matrix expressions.
            parameters: all live parameters, of matrix expressions.
            tangent: the tangent map at the symbols of q (nq, n).
        """
        distances, gradients = self._measured(self.shared(q, parameters), gradients=True)
        rates = [jacobian(point, self.q) @ tangent for point in self._points]
        ends, none = len(gradients), zeros(self._dimension, tangent.shape[1])
        of_bodies = [
            vertcat(*[rates[own[end]] if end < len(own) else none for end in range(ends)]) for own in self._index
        ]
        moving = function("rates", [self.q], [horzcat(*of_bodies)])(q)
        return [distances.T, block_products(vertcat(*gradients).T, moving, len(self.bodies))]

    def _measured(self, values: Expression, *, gradients: bool = False) -> tuple[Expression, list[Expression]]:
        """All distances (1, k), and their gradients with respect to each end of the bodies (d, k).

        Args:
            values: what `shared` returns.
            gradients: whether there are gradients.
        """
        ends = max(map(len, self.bodies)) if gradients else 0
        parts: list[list[Expression]] = [[] for _ in range(1 + ends)]
        order = list[int]()
        for bodies, obstacles in self._alike():
            order += [body * len(self.obstacles) + obstacle for body in bodies for obstacle in obstacles]
            distance, *slopes = self._of_alike(values, bodies, obstacles, gradients=gradients)
            parts[0].append(distance)
            for end in range(ends):
                none = MX.zeros(self._dimension, distance.shape[1])
                parts[1 + end].append(slopes[end] if end < len(slopes) else none)
        distances, *found = (horzcat(*part) for part in parts)
        if order == sorted(order):
            return distances, found
        place = {pair: i for i, pair in enumerate(order)}
        by_body = [place[pair] for pair in range(len(order))]
        return distances[:, by_body], [each[:, by_body] for each in found]

    def _alike(self) -> Iterator[tuple[list[int], list[int]]]:
        """Bodies with as many points, and obstacles next to each other of one kind."""
        for points in sorted(set(map(len, self.bodies))):
            bodies = [i for i, body in enumerate(self.bodies) if len(body) == points]
            for _, group in groupby(range(len(self.obstacles)), key=lambda i: self.obstacles[i].form):
                yield bodies, list(group)

    def _of_alike(
        self, values: Expression, bodies: Sequence[int], obstacles: Sequence[int], *, gradients: bool
    ) -> list[Expression]:
        """Distances (1, pairs) of these bodies to these obstacles, and gradients (d, pairs) by each end."""
        d, form = self._dimension, self.obstacles[obstacles[0]].form
        rows = values.T

        def of_bodies(first: Sequence[int]) -> Expression:
            return rows[:, [each for each in first for _ in obstacles]]

        def of_obstacles(first: Sequence[int]) -> Expression:
            return rows[:, [each for _ in bodies for each in first]]

        arguments = [
            [of_bodies([d * self._index[body][end] + axis for body in bodies]) for axis in range(d)]
            for end in range(len(self.bodies[bodies[0]]))
        ]
        start = self._figures_start
        for i, size in enumerate(form[2]):
            before = sum(form[2][:i])
            arguments.append([of_obstacles([start[each] + before + row for each in obstacles]) for row in range(size)])
        measure = distance_function(form, len(self.bodies[bodies[0]]), d, gradients=gradients)
        (distance,), *slopes = of_many(measure, arguments)
        radii = [self.radii[body] for body in bodies for _ in obstacles]
        if any(radii):
            distance = distance - MX(radii).T
        if self.gains is not None:
            present = of_obstacles([values.shape[0] - len(self.obstacles) + each for each in obstacles]) > 0
            distance = if_else(present, distance, ABSENT)
            slopes = [[present * row for row in each] for each in slopes]
        # a derivative that is the same for all pairs is one number
        wide = [[repmat(row, 1, len(radii) // row.shape[1]) for row in each] for each in slopes]
        return [distance, *(vertcat(*each) for each in wide)]

    @cached_property
    def _points(self) -> list[Expression]:
        """Each point once: links share their ends."""
        found = list[Expression]()
        for point in (point for body in self.bodies for point in body):
            if not any(is_equal(point, each) for each in found):
                found.append(point)
        return found

    @cached_property
    def _index(self) -> list[list[int]]:
        """For each body which of the points are its own."""
        places = range(len(self._points))
        return [[next(i for i in places if is_equal(point, self._points[i])) for point in body] for body in self.bodies]

    @property
    def _dimension(self) -> int:
        return int(self.bodies[0][0].shape[0])

    @cached_property
    def _figures_start(self) -> list[int]:
        """Where in `shared` the figures of each obstacle begin."""
        start, found = self._dimension * len(self._points), list[int]()
        for each in self.obstacles:
            found.append(start)
            start += sum(each.form[2])
        return found

    def _symbols(self) -> tuple[Expression, Expression, Expression]:
        """Symbols for q, the parameters, and what `shared` returns."""
        sizes = (self.q.shape[0], self.parameters.shape[0], self.shared.size1_out(0))
        return MX.sym("q", sizes[0]), MX.sym("parameters", sizes[1]), MX.sym("values", sizes[2])
