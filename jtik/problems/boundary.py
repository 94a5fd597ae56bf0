"""Targets at the edge of the workspace, where the Jacobian loses its rank."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, finite_array
from jtik.problems.case import Case, ProblemSet
from jtik.problems.mover import Mover
from jtik.problems.start import Starts
from jtik.problems.subject import STEPS, Subject, drawn
from jtik.problems.unreachable import bounded
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array

RESOLUTION = 1e-5
"""How exactly the edge is found, as a share of the summed lengths of the links."""

COARSE = 1e-2
"""Share above which a target that was not reached is tried from other starts, too."""

RESTARTS = 10
"""Those other starts."""

QUICK = 100
"""Most iterations of an attempt that others can replace."""

ATTEMPTS = 50
"""Goals tried for one case."""


def boundary(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    share: float = 0.9999,
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Problems at the edge of the workspace: reachable, but only just, and only by a nearly singular posture.

    Drawn for each case: a start and a goal as in `reachable`. A ray goes from the arm's first joint through the goal's
    position, that of the first `FrameTask` that has one; other coordinates, orientations and tasks stay as the goal
    has them. Where the ray leaves what can be reached is found by solving: bisection between the goal and the summed
    lengths of the links, each try from the last arrival and, while the interval is wide, from ten other starts. The
    target is at ``share`` of that distance, and was reached. ``known["reach"]`` is the distance of the edge from the
    first joint [m], exact for a planar chain of hinges without limits and otherwise found to about 1e-5 of the summed
    lengths. It is the edge for that search: about one ray in twenty of a Panda's poses goes on beyond it.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        share: how far out on the way to the edge, in (0, 1).
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for tasks none of which reads a position, a robot without bounds or without an edge that can be
            found, or an argument that cannot be used.
    """
    subject = Subject(robot, task, joints, at)
    mover, starts = Mover.of(subject), Starts(subject, q0)
    part = float(finite_array("share", share, ()))
    if not 0 < part < 1:
        raise ArgumentError("share", share, "a number between 0 and 1")
    bounded(mover)
    origin = f"{100 * part:g} % of the way from the first joint to the edge of the workspace, which was solved for"

    def draw(name: str, generator: np.random.Generator) -> Case:
        start = starts.draw(generator)
        for _ in range(ATTEMPTS):
            found = _edge(mover, subject.robot.random_configuration(generator), part)
            if found is None:
                continue
            target, edge = found
            return Case(
                name=name,
                kind="boundary",
                q0=start,
                targets=(target,),
                reachable=True,
                known={"error": 0.0, "reach": edge},
                origin=origin,
            )
        raise ArgumentError("robot", subject.robot, f"one with an edge that {ATTEMPTS} rays can find")

    return drawn("boundary", count, seed, draw, origin)


def _edge(mover: Mover, goal: Array, share: float) -> tuple[Any, float] | None:
    """The target on the ray through the goal, and the distance of the edge [m]; None where the ray is of no use."""
    subject, bound = mover.subject, mover.bound
    away = mover.only(mover.position(goal) - mover.center)
    begin = float(np.linalg.norm(away))
    if begin <= COARSE * bound:
        return None
    direction, target = away / begin, subject.target_at(goal)

    def at(distance: float) -> Any:
        return mover.moved(target, (distance - begin) * direction)

    low, q = (bound, goal) if mover.is_exact else _bisected(subject, at, begin, bound, goal)
    arrived = subject.arrival(at(share * low), q, restarts=RESTARTS)
    return None if arrived is None else (at(share * low), low)


def _bisected(
    subject: Subject, at: Callable[[float], Any], begin: float, bound: float, q: Array
) -> tuple[float, Array]:
    """The edge between ``begin``, which q reaches, and ``bound`` [m], and where it was reached."""
    low, high = begin, bound
    while high - low > RESOLUTION * bound:
        middle = (low + high) / 2
        wide = high - low > COARSE * bound
        found = subject.arrival(
            at(middle),
            q,
            restarts=RESTARTS if wide else 0,
            steps=QUICK if wide else STEPS,
            tolerance=0.1 * RESOLUTION * bound,
        )
        low, high, q = (low, middle, q) if found is None else (middle, high, found)
    return low, q
