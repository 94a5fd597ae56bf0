"""Starts next to a singular posture, with the target in the direction that the tip cannot start out in."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, finite_array
from jtik.problems import reach
from jtik.problems.case import Case, ProblemSet
from jtik.problems.spin import turn
from jtik.problems.subject import Subject, drawn
from jtik.robot import Robot
from jtik.task import FrameTask, Task
from jtik.types import Array

SINGULAR = 1e-12
"""Share of the largest singular value below which the smallest one is zero."""

ITERATIONS = 60
"""Most Newton steps to a singular posture."""

PATIENCE = 15
"""Steps after which the residual must have halved."""

LONGEST = 0.5
"""Longest such step [rad] or [m]."""

ATTEMPTS = 50
"""Postures tried for one case."""

HALVINGS = 4
"""How often a target that was not reached is brought nearer."""


def near_singular(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    bend: tuple[float, float] = (1e-6, 1e-3),
    far: tuple[float, float] = (0.05, 0.3),
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Problems on which an undamped inverse takes enormous steps, and a transpose hardly any.

    Drawn for each case: a configuration as in `reachable`, from which Newton's method on J' u = 0, |u| = 1 goes to a
    singular posture within the limits; an arm stretched out or folded, a wrist whose axes meet. The start is that
    posture, bent by a random direction of a length [rad or m] drawn evenly in its logarithm from ``bend``. The target
    lies along u, the direction of the task that is lost there, at a distance drawn uniformly from ``far``, a share of
    the robot's size (of a radian, where the task is an orientation); to that side, and as far at first and halved up
    to four times, as it was in fact reached. Several tasks, and tasks other than `FrameTask`, take the target of
    another drawn configuration instead. ``known`` has the least and the largest singular value of J at the start.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        bend: least and greatest distance of the start from the singular posture.
        far: least and greatest distance of the target.

    Raises:
        ArgumentError: for a robot in whose limits no singular posture is found, a task with more rows than the robot
            has joints, or an argument that cannot be used.
    """
    subject = Subject(robot, task, joints, at)
    arm = subject.robot
    bends = _range("bend", bend)
    distances = _range("far", far)
    rows = sum(each.row_count(arm) for each in subject.tasks.tasks)
    if rows > arm.n:
        raise ArgumentError("task", subject.tasks.tasks, f"at most as many rows as joints: {rows} are not {arm.n}")
    origin = f"bent by {bends[0]:g} to {bends[1]:g} from a singular posture; the target along the direction lost there"

    def draw(name: str, generator: np.random.Generator) -> Case:
        for _ in range(ATTEMPTS):
            found = _posture(subject, arm.random_configuration(generator))
            if found is None:
                continue
            posture, u = found
            away = generator.standard_normal(arm.n)
            length = float(np.exp(generator.uniform(*np.log(bends))))
            start = subject.led_in(arm.integrate(posture, length * away / np.linalg.norm(away)))
            target = _target(subject, posture, u, start, float(generator.uniform(*distances)), generator)
            if target is None:
                continue
            sigma = np.linalg.svd(subject.jacobian(start), compute_uv=False)
            return Case(
                name=name,
                kind="near_singular",
                q0=start,
                targets=(target,),
                reachable=True,
                known={"error": 0.0, "sigma_min": float(sigma[-1]), "sigma_max": float(sigma[0])},
                origin=origin,
            )
        raise ArgumentError("robot", arm, f"one of which {ATTEMPTS} attempts find a singular posture in its limits")

    return drawn("near_singular", count, seed, draw, origin)


def _range(argument: str, given: tuple[float, float]) -> tuple[float, float]:
    low, high = finite_array(argument, given, (2,)).tolist()
    if not 0 < low <= high:
        raise ArgumentError(argument, given, "two positive numbers, the lower one first")
    return low, high


def _posture(subject: Subject, q: Array) -> tuple[Array, Array] | None:
    """A singular configuration near q within the limits, and the unit vector u (m,) with J' u = 0; None if none."""
    J, n = subject.jacobian(q), subject.robot.n
    u = np.linalg.svd(J)[0][:, -1]
    history: list[float] = []
    for _ in range(ITERATIONS):
        residual = np.append(J.T @ u, (u @ u - 1) / 2)
        history.append(float(np.linalg.norm(residual)))
        if len(history) > PATIENCE and history[-1] > history[-1 - PATIENCE] / 2:
            return None
        if history[-1] <= SINGULAR * np.linalg.norm(J, 2):
            return q, u / np.linalg.norm(u)
        rate = np.block([[subject.dual_rate(q, u), J.T], [np.zeros(n), u]])
        step = np.linalg.lstsq(rate, -residual, rcond=1e-10)[0]
        step *= min(1.0, LONGEST / np.linalg.norm(step))
        q = subject.led_in(subject.robot.integrate(q, step[:n]))
        u = u + step[n:]
        J = subject.jacobian(q)
    return None


def _target(
    subject: Subject, posture: Array, u: Array, start: Array, distance: float, generator: np.random.Generator
) -> Any | None:
    """A target along u that is reached, or None."""
    task = subject.tasks.tasks[0]
    if len(subject.tasks.tasks) > 1 or not isinstance(task, FrameTask):
        return subject.target_at(subject.robot.random_configuration(generator))
    length = 1.0 if task.kind == "orientation" else reach.size(subject.robot, task.frame)
    first = 1.0 if generator.random() < 0.5 else -1.0
    there = subject.target_at(posture)
    for halving in range(HALVINGS + 1):
        for side in (first, -first):
            target = _along(task, subject.robot, there, side * length * distance / 2**halving * u)
            if subject.arrival(target, start, restarts=10) is not None:
                return target
    return None


def _along(task: FrameTask, robot: Robot, target: Any, rows: Array) -> Any:
    """The target moved so that its error changes by -rows: positions in world axes, turns in the target's own."""
    dimension = robot.dimension
    position = [] if task.kind == "orientation" else [*"xyz"[:dimension]]
    turns = [] if task.kind == "position" else ["rz"] if dimension == 2 else ["rx", "ry", "rz"]
    names = position + turns
    full = np.zeros(len(names))
    full[[names.index(name) for name in task.axes or names]] = rows
    if dimension == 2 or task.kind == "position":
        return float(target + full[0]) if task.kind == "orientation" else np.asarray(target) + full
    moved = np.array(target)
    moved[:3, :3] = moved[:3, :3] @ turn(full[len(position) :])
    if position:
        moved[:3, 3] += full[:3]
    return moved
