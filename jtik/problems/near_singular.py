"""Generator of starts close to a singular posture, with the target in the singular direction of the task."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array
from jtik.errors import ArgumentError
from jtik.problems import reach
from jtik.problems.case import Case, ProblemSet
from jtik.problems.problem_setup import ProblemSetup, draw_set
from jtik.problems.rotation import rotation_about
from jtik.robot import Robot
from jtik.task import FrameTask, Task
from jtik.types import Array

SINGULAR = 1e-12
"""Ratio of the smallest to the largest singular value below which a posture counts as singular."""

ITERATIONS = 60
"""Maximum number of Newton steps to a singular posture."""

PATIENCE = 15
"""Number of steps within which the residual must halve."""

MAX_STEP = 0.5
"""Maximum length of a Newton step [rad] or [m]."""

ATTEMPTS = 50
"""Maximum number of postures tried for one case."""

HALVINGS = 4
"""How often the distance of a target that was not reached is halved."""


def near_singular(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    start_distance: tuple[float, float] = (1e-6, 1e-3),
    target_distance: tuple[float, float] = (0.05, 0.3),
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
    bend: tuple[float, float] | None = None,
    far: tuple[float, float] | None = None,
) -> ProblemSet:
    """Draw problems that start close to a singular posture.

    An undamped inverse takes very long steps there, a transpose very short ones.

    For each case, a configuration is drawn as in `reachable`. Newton's method on J' u = 0, |u| = 1 moves it to a
    singular posture within the limits, such as a stretched or folded arm, or a wrist with aligned axes. The start is
    this posture plus a random displacement, whose length is log-uniform in ``start_distance``. The target lies
    along u, the singular direction of the task. Its distance is uniform in ``target_distance``, relative to the robot's
    size (to one radian for an orientation task). The sign of the direction is drawn; the opposite sign is tried as
    well. The distance is halved up to four times until the target is reached. With several tasks, or a task other than
    `FrameTask`, the target is that of another drawn configuration.

    ``known["sigma_min"]`` and ``known["sigma_max"]`` are the smallest and largest singular values of J at the start.

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        start_distance: smallest and largest distance of the start from the singular posture [rad] or [m].
        target_distance: smallest and largest distance of the target, as shares of the robot's size.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.
        bend: deprecated, use ``start_distance``.
        far: deprecated, use ``target_distance``.

    Raises:
        ArgumentError: if no singular posture is found within the limits, the task has more rows than the robot has
            joints, or an argument is invalid.
    """
    setup = ProblemSetup(robot, task, joints, at)
    arm = setup.robot
    for old, new, value in (("bend", "start_distance", bend), ("far", "target_distance", far)):
        if value is not None:
            text = f"the argument {old} of near_singular is deprecated: use {new}"
            warnings.warn(text, DeprecationWarning, stacklevel=2)
    starts = _range("start_distance", start_distance if bend is None else bend)
    distances = _range("target_distance", target_distance if far is None else far)
    rows = sum(each.row_count(arm) for each in setup.tasks.tasks)
    if rows > arm.n:
        raise ArgumentError(
            "task",
            setup.tasks.tasks,
            f"a task with at most as many rows as the robot has joints ({arm.n}); it has {rows}",
        )
    origin = f"{starts[0]:g} to {starts[1]:g} from a singular posture; the target along the singular direction"

    def draw(name: str, generator: np.random.Generator) -> Case:
        for _ in range(ATTEMPTS):
            found = _posture(setup, arm.random_configuration(generator))
            if found is None:
                continue
            posture, u = found
            away = generator.standard_normal(arm.n)
            length = float(np.exp(generator.uniform(*np.log(starts))))
            start = setup.clamped(arm.integrate(posture, length * away / np.linalg.norm(away)))
            target = _target(setup, posture, u, start, float(generator.uniform(*distances)), generator)
            if target is None:
                continue
            sigma = np.linalg.svd(setup.jacobian(start), compute_uv=False)
            return Case(
                name=name,
                kind="near_singular",
                q0=start,
                targets=(target,),
                reachable=True,
                known={"error": 0.0, "sigma_min": float(sigma[-1]), "sigma_max": float(sigma[0])},
                origin=origin,
            )
        raise ArgumentError(
            "robot", arm, f"a robot with a singular posture within its limits; {ATTEMPTS} attempts found none"
        )

    return draw_set("near_singular", count, seed, draw, origin)


def _range(argument: str, given: tuple[float, float]) -> tuple[float, float]:
    low, high = finite_array(argument, given, (2,)).tolist()
    if not 0 < low <= high:
        raise ArgumentError(argument, given, "two positive numbers in ascending order")
    return low, high


def _posture(setup: ProblemSetup, q: Array) -> tuple[Array, Array] | None:
    """A singular configuration close to q within the limits, and the unit vector u (m,) with J' u = 0, or None."""
    J, n = setup.jacobian(q), setup.robot.n
    u = np.linalg.svd(J)[0][:, -1]
    history: list[float] = []
    for _ in range(ITERATIONS):
        residual = np.append(J.T @ u, (u @ u - 1) / 2)
        history.append(float(np.linalg.norm(residual)))
        if len(history) > PATIENCE and history[-1] > history[-1 - PATIENCE] / 2:
            return None
        if history[-1] <= SINGULAR * np.linalg.norm(J, 2):
            return q, u / np.linalg.norm(u)
        rate = np.block([[setup.jacobian_rate(q, u), J.T], [np.zeros(n), u]])
        step = np.linalg.lstsq(rate, -residual, rcond=1e-10)[0]
        step *= min(1.0, MAX_STEP / np.linalg.norm(step))
        q = setup.clamped(setup.robot.integrate(q, step[:n]))
        u = u + step[n:]
        J = setup.jacobian(q)
    return None


def _target(
    setup: ProblemSetup, posture: Array, u: Array, start: Array, distance: float, generator: np.random.Generator
) -> Any | None:
    """A target along u that the solver reaches, or None."""
    task = setup.tasks.tasks[0]
    if len(setup.tasks.tasks) > 1 or not isinstance(task, FrameTask):
        return setup.target_at(setup.robot.random_configuration(generator))
    length = 1.0 if task.kind == "orientation" else reach.size(setup.robot, task.frame)
    first = 1.0 if generator.random() < 0.5 else -1.0
    singular_target = setup.target_at(posture)
    for halving in range(HALVINGS + 1):
        for side in (first, -first):
            target = _along(task, setup.robot, singular_target, side * length * distance / 2**halving * u)
            if setup.solve(target, start, restarts=10) is not None:
                return target
    return None


def _along(task: FrameTask, robot: Robot, target: Any, rows: Array) -> Any:
    """The target moved so that its error changes by -rows, to first order, in the axes of the task's rows."""
    dimension = robot.dimension
    position = [] if task.kind == "orientation" else [*"xyz"[:dimension]]
    rotations = [] if task.kind == "position" else ["rz"] if dimension == 2 else ["rx", "ry", "rz"]
    names = position + rotations
    full = np.zeros(len(names))
    full[[names.index(name) for name in task.axes or names]] = rows
    if dimension == 2 and task.kind == "orientation":
        return float(target + full[0])
    moved = np.array(target, dtype=np.float64)
    if position and task.error == "logarithm":
        axes = rotation_about(np.array([0.0, 0.0, moved[2]]))[:2, :2] if dimension == 2 else moved[:3, :3]
        full[:dimension] = axes @ full[:dimension]
    if moved.ndim == 1:
        moved[: len(full)] += full
        return moved
    if rotations:
        moved[:3, :3] = moved[:3, :3] @ rotation_about(full[len(position) :])
    if position:
        moved[:3, 3] += full[:3]
    return moved
