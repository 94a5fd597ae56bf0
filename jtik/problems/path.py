"""A path of the caller's own as a problem."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.problems.case import Case, ProblemSet
from jtik.problems.subject import Subject
from jtik.robot import Robot
from jtik.task import Task

RESTARTS = 20


def path(
    robot: Robot,
    task: Task | Iterable[Task],
    targets: Iterable[Any],
    *,
    q0: ArrayLike | None = None,
    dt: float | None = None,
    name: str = "path",
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
    parameters: Mapping[str, ArrayLike] | None = None,
    origin: str = "the caller's own path",
) -> ProblemSet:
    """Targets of your own, to be followed in order: a set of one case, closed where the last target is the first.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them.
        targets: what the task reads as one, each; at least one.
        q0: where to start, (nq,) of the reduced robot; when None, where a solver meets the first target, from the
            neutral configuration or up to 20 others, and the neutral one where it does not.
        dt: time from target to target [s].
        name: of the case and the set.
        parameters: values of live parameters of criteria, by name.
        origin: where the path comes from.

    Raises:
        ArgumentError: for a target or start that does not fit, naming it, and for no targets.
    """
    subject = Subject(robot, task, joints, at)
    arm = subject.robot
    given = tuple(targets)
    start = arm.neutral if q0 is None else arm.configuration(q0, argument="q0")

    def made(start: Any) -> ProblemSet:
        case = Case(
            name=name,
            kind="path",
            q0=start,
            targets=given,
            dt=dt,
            closed=closed,
            parameters={key: np.asarray(value) for key, value in (parameters or {}).items()},
            origin=origin,
        )
        return ProblemSet(name, (case,), origin=origin)

    closed = False
    made(start).check(arm, subject.tasks.tasks, joints="all")
    first, last = (subject.tasks.read_target(target) for target in (given[0], given[-1]))
    closed = len(given) > 2 and bool(np.array_equal(first, last))
    if q0 is None:
        found = subject.arrival(given[0], start, restarts=RESTARTS)
        start = start if found is None else found
    return made(start)
