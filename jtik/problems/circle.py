"""Circles to follow: closed paths, after which a law that is not cyclic finds its joints elsewhere."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.case import ProblemSet
from jtik.problems.tour import Curve, angles, closed_up, toured
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array


def _shape(points: int, radius: float) -> Array:
    angle = angles(points)
    return closed_up(radius * np.column_stack([np.cos(angle) - 1, np.sin(angle)]))


CURVE = Curve(
    kind="circle",
    dimensions=2,
    shape=_shape,
    closed=True,
    sizes=(0.05, 0.15),
    origin="a circle through the start's own position, evenly spaced, that was followed to its end",
)


def circle(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    radius: float | None = None,
    points: int = 100,
    dt: float = 0.02,
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Circles once round, with the first target where the start already is.

    Drawn for each case: a start as in `reachable`; a radius, uniform from 5 to 15 % of the robot's size (the summed
    lengths of its links); a plane and the way to the centre, uniform over rotations. All is drawn again, each time
    with a radius smaller by a tenth unless it is given, until a solver that starts each target from the last arrival
    follows the whole circle. The position of the first `FrameTask` that has one goes round; orientations and other
    tasks stay as the start has them. ``known["size"]`` is the radius [m].

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        radius: of every circle [m]; drawn when None.
        points: intervals of a circle; it has one target more, and the last is the first.
        dt: time from target to target [s].
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for tasks none of which reads two coordinates of a position, circles that cannot be followed,
            or an argument that cannot be used.
    """
    size = ("radius", radius)
    return toured(robot, task, count, CURVE, seed=seed, size=size, points=points, dt=dt, q0=q0, joints=joints, at=at)
