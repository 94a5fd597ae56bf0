"""Generator of scenes with obstacles between a collision-free start and a collision-free goal."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import finite_array, flag, instance, non_negative_number, positive_integer, text
from jtik.arguments import names as read_names
from jtik.errors import ArgumentError
from jtik.geometry import Ball, Circle, Sphere
from jtik.problems import reach
from jtik.problems.bodies import Bodies
from jtik.problems.case import Case, ProblemSet
from jtik.problems.problem_setup import ProblemSetup, draw_set
from jtik.problems.start_sampler import StartSampler
from jtik.robot import Robot
from jtik.task import Task
from jtik.types import Array

ATTEMPTS = 200
"""Maximum number of positions tried for one obstacle."""

PAIRS = 10
"""Maximum number of start and goal pairs tried for one case."""


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
    """Draw scenes for a criterion or a `Clearance` with live centres: each has the same number of circles or spheres.

    For each case, a start and a goal are drawn as in `reachable`. For each obstacle, a radius, a configuration on the
    straight line from start to goal in joint space, a link and a point on it are drawn, all uniform. The centre is this
    point plus a normal deviate with a standard deviation of one radius. An obstacle closer than ``clearance`` to a link
    at the start or the goal is drawn again. If no position is found, start and goal are drawn again. The goal meets
    the target, so a collision-free solution exists. Whether a collision-free path leads to it is unknown.

    ``known["clearance_start"]`` and ``known["clearance_goal"]`` are the smallest distances of a link to an obstacle at
    start and goal [m]. Distances scale with the robot's size (the total length of its links). All tasks of jtik are
    supported.

    The criterion must have the same number of obstacles: ``ObstacleAvoidance(jtik.problems.obstacles_of(scenes[0]),
    bodies="links")``.

    Args:
        robot: the robot.
        task: a Task, or several.
        count: number of cases.
        seed: seed of the random numbers; case i is the same for every count.
        obstacles: number of obstacles in each scene.
        radius: smallest and largest radius, as shares of the robot's size.
        clearance: smallest distance at start and goal, as a share of the robot's size.
        shapes: whether links are the robot's solids enclosed in capsules, instead of the segments of its skeleton.
        criteria: names whose parameters ".centers" and ".radii" a case sets: "obstacle_avoidance", "clearance" or both.
        q0: start of every case, (nq,) of the reduced robot; drawn when None.
        joints: joints that move, as in `InverseKinematics`.
        at: configuration at which the other joints are locked, as in `InverseKinematics`.

    Raises:
        ArgumentError: if the obstacles cannot be placed, the robot has no solids, or an argument is invalid.
    """
    setup = ProblemSetup(robot, task, joints, at)
    shapes = flag("shapes", shapes, "whether links are the robot's solids")
    starts, bodies = StartSampler(setup, q0), Bodies(setup.robot, shapes=shapes)
    obstacles = positive_integer("obstacles", obstacles)
    low, high = finite_array("radius", radius, (2,)).tolist()
    if not 0 < low <= high:
        raise ArgumentError("radius", radius, "two positive shares of the robot's size, in ascending order")
    share = non_negative_number("clearance", clearance, "a non-negative share of the robot's size")
    size = reach.size(setup.robot, setup.robot.tip)
    names = read_names("criteria", criteria, "names of criteria or clearances")
    if not all(names) or not names:
        raise ArgumentError("criteria", criteria, "names of criteria or clearances")
    origin = f"{obstacles} obstacles between start and goal, at least {100 * share:g} % of the robot's size from both"

    def place(start: Array, goal: Array, generator: np.random.Generator) -> tuple[Array, float] | None:
        """Centre and radius of one obstacle; None if it cannot be placed."""
        displacement, ends = setup.robot.difference(start, goal), [bodies.at(start), bodies.at(goal)]
        for _ in range(ATTEMPTS):
            length = size * generator.uniform(low, high)
            between = setup.robot.integrate(start, generator.random() * displacement)
            center = bodies.at(between).point(generator)
            center = center + length * generator.standard_normal(len(center))
            if all(links.distance(center) - length >= share * size for links in ends):
                return center, length
        return None

    def draw(name: str, generator: np.random.Generator) -> Case:
        for _ in range(PAIRS):
            start, goal = starts.draw(generator), setup.robot.random_configuration(generator)
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
            smallest = [min(bodies.at(q).distance(c) - r for c, r in placed) for q in (start, goal)]
            return Case(
                name=name,
                kind="scene",
                q0=start,
                targets=(setup.target_at(goal),),
                parameters=values,
                reachable=True,
                known={"error": 0.0, "clearance_start": smallest[0], "clearance_goal": smallest[1]},
                origin=origin,
            )
        raise ArgumentError(
            "clearance", clearance, f"a clearance at which {obstacles} obstacles of that radius can be placed"
        )

    return draw_set("scene", count, seed, draw, origin)


def obstacles_of(case: Case, criterion: str = "obstacle_avoidance") -> tuple[Ball, ...]:
    """The circles or spheres of a case, for building a criterion.

    Args:
        case: a case of `scene`.
        criterion: name of the criterion whose parameters hold them.

    Raises:
        ArgumentError: if the case has no obstacles under that name.
    """
    instance("case", case, Case, "a jtik.problems.Case")
    text("criterion", criterion, "the name of a criterion")
    keys = [f"{criterion}.centers", f"{criterion}.radii"]
    if not all(key in case.parameters for key in keys):
        raise ArgumentError("case", f"{case!r} with parameters {list(case.parameters)}", f"a case with {keys}")
    centers, radii = (case.parameters[key] for key in keys)
    kind = Circle if centers.shape[1] == 2 else Sphere
    return tuple(kind(center, radius) for center, radius in zip(centers, radii.tolist(), strict=True))
