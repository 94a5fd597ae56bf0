"""A recorded path of targets followed again, by another solver or among other obstacles."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from jtik.planner.attempts.attempt import Attempt
from jtik.planner.session.settings import Problem, Structure, Values
from jtik.planner.session.solving import Solver
from jtik.planner.session.targets import Targets, target_of
from jtik.types import Array


def resolved(
    problem: Problem,
    structure: Structure,
    values: Values,
    attempt: Attempt,
    settings: Mapping[str, Any],
    targets: Targets,
) -> Attempt:
    """The attempt that follows the targets of another one, one step for each, from where that one begins.

    Args:
        problem: what stays as it is.
        structure: what the solver is built for.
        values: what the solver is filled with; its obstacles stay as they are.
        attempt: the attempt whose targets are followed.
        settings: the settings as plain data.
        targets: the task that is guided in the attempt, and the targets of the others.

    Raises:
        JtikError: where there is no solver for the structure.
    """
    solver = Solver(problem, structure)
    solver.fill(values)
    q = attempt.configurations[0]
    found: list[Array] = [q]
    for target, dt in zip(attempt.targets[1:], np.diff(attempt.times).tolist(), strict=True):
        position, orientation = target[: problem.robot.dimension], target[3:] if len(target) == 7 else None
        q = solver.step(q, target_of(problem, targets, position, orientation), dt).q
        if not np.isfinite(q).all():
            q = found[-1]
        found.append(q)
    return Attempt(
        name=f"{attempt.name} again"[:100],
        dt=attempt.dt,
        times=attempt.times,
        configurations=np.array(found),
        targets=attempt.targets,
        scenes=((0.0, values.scene.to_dict()),),
        strategy=structure.strategy,
        criteria=structure.criteria,
        settings=settings,
        parent=attempt.name,
    )
