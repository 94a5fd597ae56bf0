"""Paths as problems: a curve drawn so that the robot starts on it and can follow it to its end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from jtik._loop.options import positive
from jtik.errors import ArgumentError
from jtik.problems import reach
from jtik.problems.case import Case, ProblemSet
from jtik.problems.mover import Mover
from jtik.problems.start import Starts
from jtik.problems.subject import Subject, drawn
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array

ATTEMPTS = 60
"""Curves tried for one case."""

SHRINK = 0.9
"""What the size of a curve that was drawn, not given, is multiplied by after a try in vain."""


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A curve that begins at zero.

    Attributes:
        kind: what to call the problems.
        dimensions: how many directions it needs.
        shape: (points, size [m]) -> places (points + 1, dimensions) [m] from the first, which is zero.
        closed: whether the last is the first.
        sizes: least and greatest size drawn, as shares of the robot's size.
        origin: the curve in words.
    """

    kind: str
    dimensions: int
    shape: Callable[[int, float], Array]
    closed: bool
    sizes: tuple[float, float]
    origin: str


def toured(
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
    """Cases of one curve each.

    Drawn for each: a start as in `reachable`; the size, uniform in the curve's shares of the robot's size, unless
    given; directions, uniform over rotations, in the coordinates that the task keeps. The curve begins where the start
    has the frame. Everything is drawn again, with a smaller size unless it is given, until a warm-started solver
    follows the curve to its end. ``known["size"]`` is the size [m].

    Raises:
        ArgumentError: for tasks none of which reads enough of a position, a curve that is never followed, or an
            argument that cannot be used.
    """
    subject = Subject(robot, task, joints, at)
    mover, starts = Mover.of(subject, least=curve.dimensions), Starts(subject, q0)
    if isinstance(points, bool) or not isinstance(points, (int, np.integer)) or points < 2:
        raise ArgumentError("points", points, "an integer from 2")
    argument, given = size
    fixed = None if given is None else positive(argument, given)
    dt = positive("dt", dt)
    extent = reach.size(subject.robot, mover.task.frame)

    def draw(name: str, generator: np.random.Generator) -> Case:
        shrunk = 1.0
        for _ in range(ATTEMPTS):
            start = starts.draw(generator)
            own = extent * shrunk * generator.uniform(*curve.sizes) if fixed is None else fixed
            offsets = curve.shape(int(points), own) @ mover.basis(generator, curve.dimensions).T
            begin = subject.target_at(start)
            targets = [mover.moved(begin, offset) for offset in offsets]
            if follows(subject, start, targets):
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
        raise ArgumentError(argument, given, f"a size that {subject.robot!r} can follow: {ATTEMPTS} curves are too far")

    return drawn(curve.kind, count, seed, draw, curve.origin)


def follows(subject: Subject, q: Array, targets: Sequence[Any]) -> bool:
    """Whether each target is reached from where the one before was, beginning at q."""
    for target in targets:
        found = subject.arrival(target, q)
        if found is None:
            return False
        q = found
    return True


def angles(points: int) -> Array:
    """Angles (points + 1,) of one turn, even, from 0 to 2 pi [rad]."""
    return np.linspace(0, 2 * np.pi, points + 1)


def closed_up(offsets: Array) -> Array:
    """The curve with its last place exactly its first, which is zero."""
    offsets[0] = offsets[-1] = 0
    return offsets
