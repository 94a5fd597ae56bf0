"""Generator of straight lines to follow."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import flag
from jtik.problems.case import ProblemSet
from jtik.problems.path_problem import Curve, closed_exactly, path_problems
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array


def _shape(points: int, length: float) -> Array:
    return length * np.linspace(0, 1, points + 1)[:, None]


def _there_and_back(points: int, length: float) -> Array:
    return closed_exactly(length * (1 - np.abs(np.linspace(-1, 1, points + 1)))[:, None])


CURVE = Curve(
    kind="line",
    dimensions=1,
    shape=_shape,
    closed=False,
    sizes=(0.1, 0.4),
    origin="a straight line from the start position, with even spacing, which a solver followed to its end",
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
    """Draw straight lines whose first target is met by the start.

    For each case, the start is drawn as in `reachable`. The length is uniform from 10 to 40 % of the robot's size (the
    total length of its links). The direction is uniform. All of them are drawn again, as in `circle`, until the line
    can be followed. The position of the first `FrameTask` that has a position follows the line. Orientations and other
    tasks keep their values at the start. ``known["size"]`` is the length [m].

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        length: length of every line [m]; drawn when None.
        back: whether the path returns to its first target.
        points: number of intervals of a path; it has one more target.
        dt: time between consecutive targets [s].
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if no task has a position, no line can be followed, or an argument is invalid.
    """
    back = flag("back", back, "whether the path returns to its first target")
    curve = replace(CURVE, shape=_there_and_back, closed=True) if back else CURVE
    return path_problems(
        robot,
        task,
        count,
        curve,
        seed=seed,
        size=("length", length),
        points=points,
        dt=dt,
        q0=q0,
        joints=joints,
        at=at,
    )
