"""Generator of Lissajous figures: closed paths that cross themselves and curve in both directions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import integer, several
from jtik.errors import ArgumentError
from jtik.problems.case import ProblemSet
from jtik.problems.path_problem import Curve, angles, closed_exactly, path_problems
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array


def _shape(points: int, amplitude: float, *, frequencies: tuple[int, int] = (1, 2)) -> Array:
    angle, (first, second) = angles(points), frequencies
    return closed_exactly(amplitude * np.column_stack([np.sin(first * angle), np.sin(second * angle) / 2]))


CURVE = Curve(
    kind="lissajous",
    dimensions=2,
    shape=_shape,
    closed=True,
    sizes=(0.05, 0.15),
    origin="a Lissajous figure around the start position, which a solver followed to its end",
)


def lissajous(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    amplitude: float | None = None,
    frequencies: tuple[int, int] = (1, 2),
    points: int = 200,
    dt: float = 0.02,
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Draw figures x = a sin(f1 s), y = a/2 sin(f2 s), s from 0 to 2 pi, around the start position.

    For each case, the start is drawn as in `reachable`. The amplitude a is uniform from 5 to 15 % of the robot's size
    (the total length of its links). The directions of x and y are uniform over rotations. All of them are drawn again,
    as in `circle`, until the figure can be followed. The position of the first `FrameTask` that has a position follows
    the figure. Orientations and other tasks keep their values at the start. ``known["size"]`` is a [m].

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        amplitude: amplitude a of every figure [m]; drawn when None.
        frequencies: positive integers f1 and f2; (1, 2) is a figure of eight.
        points: number of intervals of a figure; it has one more target, and the last equals the first.
        dt: time between consecutive targets [s].
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if no task has two coordinates of a position, no figure can be followed, or an argument is
            invalid.
    """
    accepted = "two positive integers, such as (1, 2)"
    numbers = [integer("frequencies", each, 1, accepted) for each in several("frequencies", frequencies, accepted)]
    if len(numbers) != 2:
        raise ArgumentError("frequencies", frequencies, accepted)
    first, second = numbers
    curve = replace(CURVE, shape=partial(_shape, frequencies=(first, second)))
    return path_problems(
        robot,
        task,
        count,
        curve,
        seed=seed,
        size=("amplitude", amplitude),
        points=points,
        dt=dt,
        q0=q0,
        joints=joints,
        at=at,
    )
