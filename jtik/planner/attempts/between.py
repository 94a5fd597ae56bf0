"""The smallest distance along a motion, between its samples too.

The joints move straight from one sample to the next. Along such a piece no point of the robot moves farther than L
(`MotionBound`), so the smallest of all distances falls by at most the length moved. With the distances a and b at the
ends of a piece it is therefore at least (a + b - L) / 2 inside. The piece with the smallest such bound is halved until
no bound is smaller than the smallest distance found, less the accuracy.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from jtik.constraints.motion_bound import MotionBound
from jtik.robot import Robot
from jtik.study.path_metrics import displacements
from jtik.symbolic import function, symbol, vertcat
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

ACCURACY = 1e-3
"""How far the smallest distance found may be above the smallest one [m]."""

MOST_HALVINGS = 200_000
"""Largest number of distances evaluated between samples; beyond it the bound is what is proved by then."""


@dataclass(frozen=True)
class Smallest:
    """The smallest distance along a motion.

    Attributes:
        distance: the smallest distance found [m]; infinite without obstacles.
        bound: no distance is smaller [m].
        time: where it was found [s].
        body: name of the body, such as "link2-link3".
        obstacle: index of the obstacle in the order of the measure.
    """

    distance: float = math.inf
    bound: float = math.inf
    time: float = 0.0
    body: str = ""
    obstacle: int = 0

    def smaller(self, other: Smallest) -> Smallest:
        """The smaller of two, with the smaller bound."""
        first, second = (self, other) if self.distance <= other.distance else (other, self)
        return replace(first, bound=min(first.bound, second.bound))


class Distances:
    """The distances of a measure along straight joint motions.

    Args:
        robot: the robot.
        measure: a `jtik.constraints.clearance.Measure`, such as the criterion "obstacle_avoidance".
    """

    def __init__(self, robot: Robot, measure: Any) -> None:
        self._robot, self._given = robot, dict(measure.parameters(robot))
        parameters = {name: symbol(name, *_matrix(value).shape) for name, value in self._given.items()}
        q, dq, share = symbol("q", robot.nq), symbol("dq", robot.n), symbol("share", 1)
        moved = robot.integrate(q, share * dq)
        bodies = measure.distances(robot.at(moved), parameters)
        names = getattr(measure, "body_names", None)
        self._bodies = list(names(robot)) if callable(names) else [f"body {i}" for i in range(len(bodies))]
        self._width = len(bodies[0]) if bodies else 0
        flat = vertcat(*[distance for body in bodies for distance in body])
        self._distances = CompiledFunction(function("distances", [q, dq, share, *parameters.values()], [flat]))
        self._length = CompiledFunction(function("length", [q, dq], [vertcat(MotionBound(robot, q).lengths(dq)[0])]))

    def smallest(
        self,
        times: Array,
        configurations: Array,
        *,
        parameters: Mapping[str, Any] | None = None,
        accuracy: float = ACCURACY,
    ) -> Smallest:
        """The smallest distance along a motion.

        Args:
            times: time of each sample (k,) [s].
            configurations: (k, nq), k from 1.
            parameters: values of the measure's parameters, by default those that it was made with.
            accuracy: how far the distance found may be above the smallest one [m].
        """
        if not self._width:
            return Smallest()
        values = [_matrix(value) for value in (self._given if parameters is None else parameters).values()]
        steps = displacements(self._robot, configurations)
        still = np.zeros(self._robot.n)
        found: list[tuple[float, float, int]] = []  # distance, time, which of them

        def at(i: int, share: float) -> float:
            dq = steps[i] if i < len(steps) else still
            every = self._distances(configurations[i], dq, share, *values)[0][:, 0]
            which = int(every.argmin())
            end = times[min(i + 1, len(times) - 1)]
            found.append((float(every[which]), float(times[i] + share * (end - times[i])), which))
            return float(every[which])

        ends = [at(i, 0.0) for i in range(len(configurations))]
        best = min(found)
        pieces = []
        for i, dq in enumerate(steps):
            length = float(self._length(configurations[i], dq)[0].item())
            pieces.append(_Piece.of(i, 0.0, 1.0, (ends[i], ends[i + 1]), length))
        heapq.heapify(pieces)
        for _ in range(MOST_HALVINGS):
            if not pieces or pieces[0].bound >= best[0] - accuracy:
                break
            piece = heapq.heappop(pieces)
            i, half, size = piece.sample, piece.length / 2, piece.size / 2
            middle = at(i, piece.begin + size)
            best = min(best, found[-1])
            heapq.heappush(pieces, _Piece.of(i, piece.begin, size, (piece.ends[0], middle), half))
            heapq.heappush(pieces, _Piece.of(i, piece.begin + size, size, (middle, piece.ends[1]), half))
        bound = min(best[0], pieces[0].bound) if pieces else best[0]
        distance, time, which = best
        return Smallest(distance, bound, time, self._bodies[which // self._width], which % self._width)


class _Piece(NamedTuple):
    """A part of the way between two samples.

    Attributes:
        bound: no distance on it is smaller [m].
        index: the sample before it.
        begin: where it begins, as a share of that way.
        size: its share of that way.
        ends: the distances at its ends [m].
        length: largest motion of any point on it [m].
    """

    bound: float
    sample: int
    begin: float
    size: float
    ends: tuple[float, float]
    length: float

    @classmethod
    def of(cls, sample: int, begin: float, size: float, ends: tuple[float, float], length: float) -> _Piece:
        """A piece, with its bound."""
        return cls((sum(ends) - length) / 2, sample, begin, size, ends, length)


def _matrix(value: Any) -> Array:
    """A parameter's value as a matrix, as CasADi has it."""
    array = np.asarray(value, dtype=np.float64)
    return array.reshape(-1, 1) if array.ndim < 2 else array
