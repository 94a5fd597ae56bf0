"""A path problem from the caller's own targets."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import mapping, several
from jtik.problems.case import Case, ProblemSet
from jtik.problems.problem_setup import ProblemSetup
from jtik.robot import Robot
from jtik.task import Task

RESTARTS = 20
"""Number of restarts when the start is solved for."""


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
    """A set with one case that follows the given targets in order.

    The path is closed if its last target equals the first.

    Args:
        robot: the robot.
        task: a Task, or several.
        targets: at least one target, in any form that the task accepts.
        q0: start, (nq,) of the reduced robot. When None, a solver looks for a configuration that meets the first
            target, from `Robot.home` and up to 20 others. `Robot.home` is used if it finds none.
        dt: time between consecutive targets [s].
        name: name of the case and of the set.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.
        parameters: values of live parameters of criteria by name.
        origin: source of the path.

    Raises:
        ArgumentError: for no target, or naming the target or start that does not fit.
    """
    setup = ProblemSetup(robot, task, joints, at)
    arm = setup.robot
    given = several("targets", targets, "a list of targets")
    named = {} if parameters is None else mapping("parameters", parameters, "a dict from name to values, or None")
    start = arm.home if q0 is None else arm.configuration(q0, argument="q0")

    def made(start: Any) -> ProblemSet:
        case = Case(
            name=name,
            kind="path",
            q0=start,
            targets=given,
            dt=dt,
            closed=closed,
            parameters=named,
            origin=origin,
        )
        return ProblemSet(name, (case,), origin=origin)

    closed = False
    made(start).check(arm, setup.tasks.tasks, joints="all")
    first, last = (setup.tasks.read_target(target) for target in (given[0], given[-1]))
    closed = len(given) > 2 and bool(np.array_equal(first, last))
    if q0 is None:
        found = setup.solve(given[0], start, restarts=RESTARTS)
        start = start if found is None else found
    return made(start)
