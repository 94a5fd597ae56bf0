"""Path problems: curves that begin at the start position and that the robot can follow to their end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import integer, positive_number
from jtik.errors import ArgumentError
from jtik.problems import reach
from jtik.problems.case import Case, ProblemSet
from jtik.problems.position_task import PositionTask
from jtik.problems.problem_setup import ProblemSetup, draw_set
from jtik.problems.start_sampler import StartSampler
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array

ATTEMPTS = 60
"""Maximum number of curves drawn for one case."""

SHRINK = 0.9
"""Factor on the size of a drawn curve after each one that could not be followed."""


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A curve that begins at the origin.

    Attributes:
        kind: kind of the cases.
        dimensions: number of dimensions of the curve.
        shape: (points, size [m]) -> positions (points + 1, dimensions) [m] relative to the first.
        closed: whether the last position equals the first.
        sizes: smallest and largest size drawn, as shares of the robot's size.
        origin: description of the curve.
    """

    kind: str
    dimensions: int
    shape: Callable[[int, float], Array]
    closed: bool
    sizes: tuple[float, float]
    origin: str


def path_problems(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int,
    curve: Curve,
    *,
    seed: int,
    size: tuple[str, float | None],
    points: int,
    dt: float,
    q0: ArrayLike | None,
    joints: str | Iterable[str] | None,
    at: ArrayLike | None,
) -> ProblemSet:
    """Draw cases that follow a curve.

    For each case, the start is drawn as in `reachable`. The size is uniform in the curve's range, unless given. The
    directions are uniform over rotations, within the coordinates that the task keeps. The curve begins at the position
    of the frame at the start. All of them are drawn again, with a smaller size unless it is given, until a
    warm-started solver follows the curve to its end. ``known["size"]`` is the size [m].

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        curve: the curve.
        seed: seed of the random numbers.
        size: name of the caller's size argument, and its value [m] or None.
        points: number of intervals of the curve.
        dt: time between consecutive targets [s].
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if no task has enough coordinates of a position, no curve can be followed, or an argument is
            invalid.
    """
    setup = ProblemSetup(robot, task, joints, at)
    position_task, starts = PositionTask.of(setup, dimensions=curve.dimensions), StartSampler(setup, q0)
    points = integer("points", points, 2, "an integer of at least 2")
    argument, given = size
    fixed = None if given is None else positive_number(argument, given)
    dt = positive_number("dt", dt)
    extent = reach.size(setup.robot, position_task.task.frame)

    def draw(name: str, generator: np.random.Generator) -> Case:
        shrunk = 1.0
        for _ in range(ATTEMPTS):
            start = starts.draw(generator)
            own = extent * shrunk * generator.uniform(*curve.sizes) if fixed is None else fixed
            offsets = curve.shape(points, own) @ position_task.basis(generator, curve.dimensions).T
            begin = setup.target_at(start)
            targets = [position_task.moved(begin, offset) for offset in offsets]
            if follows(setup, start, targets):
                return Case(
                    name=name,
                    kind=curve.kind,
                    q0=start,
                    targets=tuple(targets),
                    dt=dt,
                    closed=curve.closed,
                    reachable=True,
                    known={"error": 0.0, "size": own},
                    origin=curve.origin,
                )
            shrunk *= SHRINK
        given = f"{fixed:g} m" if fixed is not None else f"drawn, down to {shrunk * curve.sizes[0] * extent:.2g} m"
        raise ArgumentError(
            argument, given, f"a size that {setup.robot!r} can follow; {ATTEMPTS} curves were not followed"
        )

    return draw_set(curve.kind, count, seed, draw, curve.origin)


def follows(setup: ProblemSetup, q: Array, targets: Sequence[Any]) -> bool:
    """Whether each target is reached from the solution of the previous one, beginning at q."""
    for target in targets:
        found = setup.solve(target, q)
        if found is None:
            return False
        q = found
    return True


def angles(points: int) -> Array:
    """Evenly spaced angles (points + 1,) from 0 to 2 pi [rad]."""
    return np.linspace(0, 2 * np.pi, points + 1)


def closed_exactly(offsets: Array) -> Array:
    """The curve with its first and last positions set to exactly zero."""
    offsets[0] = offsets[-1] = 0
    return offsets
