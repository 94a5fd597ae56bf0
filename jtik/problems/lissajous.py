"""Lissajous figures to follow: closed paths that cross themselves and turn both ways."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError
from jtik.problems.case import ProblemSet
from jtik.problems.tour import Curve, angles, closed_up, toured
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array


def _shape(points: int, amplitude: float, *, frequencies: tuple[int, int] = (1, 2)) -> Array:
    angle, (first, second) = angles(points), frequencies
    return closed_up(amplitude * np.column_stack([np.sin(first * angle), np.sin(second * angle) / 2]))


CURVE = Curve(
    kind="lissajous",
    dimensions=2,
    shape=_shape,
    closed=True,
    sizes=(0.05, 0.15),
    origin="a Lissajous figure about the start's own position, that was followed to its end",
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
    """Figures x = a sin(f1 s), y = a/2 sin(f2 s), s from 0 to 2 pi, about the place where the start already is.

    Drawn for each case: a start as in `reachable`; a, uniform from 5 to 15 % of the robot's size (the summed lengths
    of its links); the directions of x and y, uniform over rotations. All is drawn again as in `circle` until the
    figure can be followed. The position of the first `FrameTask` that has one moves; orientations and other tasks stay
    as the start has them.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        amplitude: a of every figure [m]; drawn when None.
        frequencies: f1 and f2, whole numbers; (1, 2) is a figure of eight.
        points: intervals of a figure; it has one target more, and the last is the first.
        dt: time from target to target [s].
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for tasks none of which reads two coordinates of a position, figures that cannot be followed,
            or an argument that cannot be used.
    """
    numbers = np.asarray(frequencies)
    if numbers.shape != (2,) or numbers.dtype.kind not in "iu" or numbers.min() < 1:
        raise ArgumentError("frequencies", frequencies, "two whole numbers from 1, such as (1, 2)")
    first, second = (int(number) for number in numbers)
    curve = replace(CURVE, shape=partial(_shape, frequencies=(first, second)))
    size = ("amplitude", amplitude)
    return toured(robot, task, count, curve, seed=seed, size=size, points=points, dt=dt, q0=q0, joints=joints, at=at)
