"""Straight lines to follow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.case import ProblemSet
from jtik.problems.tour import Curve, closed_up, toured
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array


def _shape(points: int, length: float) -> Array:
    return length * np.linspace(0, 1, points + 1)[:, None]


def _there_and_back(points: int, length: float) -> Array:
    return closed_up(length * (1 - np.abs(np.linspace(-1, 1, points + 1)))[:, None])


CURVE = Curve(
    kind="line",
    dimensions=1,
    shape=_shape,
    closed=False,
    sizes=(0.1, 0.4),
    origin="a straight line from the start's own position, evenly spaced, that was followed to its end",
)


def line(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    length: float | None = None,
    back: bool = False,
    points: int = 100,
    dt: float = 0.02,
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Straight lines, with the first target where the start already is.

    Drawn for each case: a start as in `reachable`; a length, uniform from 10 to 40 % of the robot's size (the summed
    lengths of its links); a direction, uniform. All is drawn again as in `circle` until the line can be followed. The
    position of the first `FrameTask` that has one moves; orientations and other tasks stay as the start has them.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        length: of every line [m]; drawn when None.
        back: whether the path comes back, and is closed.
        points: intervals of a path; it has one target more.
        dt: time from target to target [s].
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for tasks none of which reads a position, lines that cannot be followed, or an argument that
            cannot be used.
    """
    size = ("length", length)
    curve = replace(CURVE, shape=_there_and_back, closed=True) if back else CURVE
    return toured(robot, task, count, curve, seed=seed, size=size, points=points, dt=dt, q0=q0, joints=joints, at=at)
