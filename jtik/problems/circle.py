"""Generator of circles: closed paths, after which the joints have drifted if the strategy is not cyclic."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.case import ProblemSet
from jtik.problems.path_problem import Curve, angles, closed_exactly, path_problems
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array


def _shape(points: int, radius: float) -> Array:
    angle = angles(points)
    return closed_exactly(radius * np.column_stack([np.cos(angle) - 1, np.sin(angle)]))


CURVE = Curve(
    kind="circle",
    dimensions=2,
    shape=_shape,
    closed=True,
    sizes=(0.05, 0.15),
    origin="a circle through the start position, with even spacing, which a solver followed to its end",
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
    """Draw circles whose first target is met by the start.

    For each case, the start is drawn as in `reachable`. The radius is uniform from 5 to 15 % of the robot's size (the
    total length of its links). The plane and the direction to the centre are uniform over rotations. All of them are
    drawn again until a solver, started at each target from the previous solution, follows the whole circle. Each new
    draw reduces the radius by a tenth, unless it is given. The position of the first `FrameTask` that has a position
    follows the circle. Orientations and other tasks keep their values at the start. ``known["size"]`` is the radius
    [m].

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        radius: radius of every circle [m]; drawn when None.
        points: number of intervals of a circle; it has one more target, and the last equals the first.
        dt: time between consecutive targets [s].
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if no task has two coordinates of a position, no circle can be followed, or an argument is
            invalid.
    """
    return path_problems(
        robot,
        task,
        count,
        CURVE,
        seed=seed,
        size=("radius", radius),
        points=points,
        dt=dt,
        q0=q0,
        joints=joints,
        at=at,
    )
