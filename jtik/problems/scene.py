"""Obstacles in the way between a start and a goal that are both clear of them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.errors import ArgumentError, finite_array
from jtik.geometry import Ball, Circle, Sphere
from jtik.problems import reach
from jtik.problems.bodies import Bodies
from jtik.problems.case import Case, ProblemSet
from jtik.problems.start import Starts
from jtik.problems.subject import Subject, drawn
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array

ATTEMPTS = 200
"""Places tried for one obstacle."""

PAIRS = 10
"""Pairs of start and goal tried for one case."""


def scene(
    robot: Robot,
    task: Task | Iterable[Task],
    count: int = 100,
    *,
    seed: int = 0,
    obstacles: int = 5,
    radius: tuple[float, float] = (0.01, 0.05),
    clearance: float = 0.01,
    shapes: bool = False,
    criteria: str | Iterable[str] = "obstacle_avoidance",
    q0: ArrayLike | None = None,
    joints: str | Iterable[str] | None = None,
    at: ArrayLike | None = None,
) -> ProblemSet:
    """Scenes for a criterion or a `Clearance` with live centres: the same number of circles or spheres in each.

    Drawn for each case: a start and a goal as in `reachable`; then each obstacle: its radius, uniform; a configuration
    on the straight way from start to goal in joint space, a link, and a point on it, all uniform; its centre a normal
    deviate of one radius beside that point. An obstacle that comes nearer than ``clearance`` to a link at the start or
    the goal is drawn again, and start and goal, too, where that does not help. The goal meets the target, so that the
    target can be reached in the clear; whether a clear way leads there nobody knows. ``known`` has the least distance
    of a link to an obstacle at start and goal [m], "clearance_start" and "clearance_goal". Distances scale with the
    robot's size (the summed lengths of its links). For every task of jtik.

    The criterion must have as many obstacles: ``ObstacleAvoidance(jtik.problems.obstacles_of(scenes[0]),
    bodies="links")``.

    Args:
        robot, task, joints, at: as `InverseKinematics` takes them; starts are of its reduced robot.
        count: how many cases.
        seed: of the random numbers; case i is the same for every count.
        obstacles: how many in each.
        radius: least and greatest radius, as shares of the robot's size.
        clearance: least distance at start and goal, as a share of the robot's size.
        shapes: whether links are the robot's own solids, enclosed in capsules, instead of the lines of its skeleton.
        criteria: names whose parameters ".centers" and ".radii" a case sets: "obstacle_avoidance", "clearance", both.
        q0: start of every case (nq,); drawn when None.

    Raises:
        ArgumentError: for obstacles that find no place, a robot without solids, or an argument that cannot be used.
    """
    subject = Subject(robot, task, joints, at)
    starts, bodies = Starts(subject, q0), Bodies(subject.robot, shapes=shapes)
    if isinstance(obstacles, bool) or not isinstance(obstacles, (int, np.integer)) or obstacles < 1:
        raise ArgumentError("obstacles", obstacles, "an integer from 1")
    low, high = finite_array("radius", radius, (2,)).tolist()
    if not 0 < low <= high:
        raise ArgumentError("radius", radius, "two positive shares of the robot's size, the lower one first")
    share = float(finite_array("clearance", clearance, ()))
    if share < 0:
        raise ArgumentError("clearance", clearance, "a share of the robot's size from 0")
    size = reach.size(subject.robot, subject.robot.tip)
    names = (criteria,) if isinstance(criteria, str) else tuple(criteria)
    origin = f"{obstacles} obstacles in the way from start to goal, {100 * share:g} % of the size clear of both"

    def place(start: Array, goal: Array, generator: np.random.Generator) -> tuple[Array, float] | None:
        """Centre and radius of one obstacle, or None."""
        way, still = subject.robot.difference(start, goal), [bodies.at(start), bodies.at(goal)]
        for _ in range(ATTEMPTS):
            length = size * generator.uniform(low, high)
            between = subject.robot.integrate(start, generator.random() * way)
            center = bodies.at(between).point(generator)
            center = center + length * generator.standard_normal(len(center))
            if all(links.distance(center) - length >= share * size for links in still):
                return center, length
        return None

    def draw(name: str, generator: np.random.Generator) -> Case:
        for _ in range(PAIRS):
            start, goal = starts.draw(generator), subject.robot.random_configuration(generator)
            placed: list[tuple[Array, float]] = []
            while len(placed) < obstacles:
                found = place(start, goal, generator)
                if found is None:
                    break
                placed.append(found)
            if len(placed) < obstacles:
                continue
            centers, radii = np.array([center for center, _ in placed]), np.array([length for _, length in placed])
            values = {f"{each}.centers": centers for each in names} | {f"{each}.radii": radii for each in names}
            least = [min(bodies.at(q).distance(c) - r for c, r in placed) for q in (start, goal)]
            return Case(
                name=name,
                kind="scene",
                q0=start,
                targets=(subject.target_at(goal),),
                parameters=values,
                reachable=True,
                known={"error": 0.0, "clearance_start": least[0], "clearance_goal": least[1]},
                origin=origin,
            )
        raise ArgumentError("clearance", clearance, f"one at which {obstacles} obstacles of that radius find a place")

    return drawn("scene", count, seed, draw, origin)


def obstacles_of(case: Case, criterion: str = "obstacle_avoidance") -> tuple[Ball, ...]:
    """The circles or spheres of a case, to build a criterion with.

    Raises:
        ArgumentError: when the case has none under that criterion's name.
    """
    keys = [f"{criterion}.centers", f"{criterion}.radii"]
    if not all(key in case.parameters for key in keys):
        raise ArgumentError("case", f"{case!r} with parameters {list(case.parameters)}", f"one with {keys}")
    centers, radii = (case.parameters[key] for key in keys)
    kind = Circle if centers.shape[1] == 2 else Sphere
    return tuple(kind(center, radius) for center, radius in zip(centers, radii.tolist(), strict=True))
