"""The smallest distance of a robot to the obstacles of scenes, along a motion."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from jtik.arguments import choice, mapping, positive_number
from jtik.geometry import Scene, Slots, Solid
from jtik.planner.attempts.attempt import Attempt, SceneChange
from jtik.planner.attempts.between import ACCURACY, Distances, Smallest
from jtik.registry import criteria
from jtik.robot import Robot
from jtik.types import Array

BODIES = ("joints", "links", "both", "shapes")


def clearance(
    robot: Robot,
    attempt: Attempt,
    *,
    scenes: Iterable[SceneChange] | None = None,
    bodies: str | None = None,
    accuracy: float = ACCURACY,
) -> tuple[Smallest, str]:
    """The smallest distance along an attempt, between its samples too, and the name of the obstacle.

    Args:
        robot: the robot.
        attempt: the attempt.
        scenes: when the obstacles change and what they are; by default as they were recorded.
        bodies: what may not come close to obstacles; by default "shapes", else "links", else "joints".
        accuracy: how far the distance found may be above the smallest one [m].
    """
    changes = attempt.scenes if scenes is None else scenes
    return smallest(robot, attempt.times, attempt.configurations, changes, bodies=bodies, accuracy=accuracy)


def smallest(
    robot: Robot,
    times: Array,
    configurations: Array,
    scenes: Iterable[tuple[float, Scene | Mapping[str, Any]]],
    *,
    bodies: str | None = None,
    accuracy: float = ACCURACY,
) -> tuple[Smallest, str]:
    """The smallest distance along a motion, see `clearance`."""
    chosen = default_bodies(robot) if bodies is None else choice("bodies", bodies, BODIES)
    accuracy = positive_number("accuracy", accuracy, "a positive length [m]")
    changes = list(scenes)
    if not changes:
        return Smallest(), ""
    ends = [*(begin for begin, _ in changes[1:]), float(times[-1])]
    avoidance: Any = criteria["obstacle_avoidance"]
    built: dict[Any, Distances] = {}
    best, name = Smallest(), ""
    for (begin, scene), end in zip(changes, ends, strict=True):
        first = max(int(np.searchsorted(times, begin, side="right")) - 1, 0)
        rows = slice(first, int(np.searchsorted(times, end)) + 1)  # from the sample before to the sample after
        obstacles = present(scene)
        if not obstacles:
            continue
        measure: Any = avoidance(list(obstacles.values()), bodies=chosen)
        parameters = measure.parameters(robot)
        key = tuple((each, value.shape) for each, value in parameters.items() if hasattr(value, "shape"))
        if key not in built:
            built[key] = Distances(robot, measure)
        found = built[key].smallest(times[rows], configurations[rows], parameters=parameters, accuracy=accuracy)
        if found.distance < best.distance:
            slots = Slots.exactly(obstacles.values(), robot.dimension).place(obstacles.values())
            name = next(each for each, slot in zip(obstacles, slots, strict=True) if slot == found.obstacle)
        best = best.smaller(found)
    return best, name


def present(scene: Scene | Mapping[str, Any]) -> dict[str, Solid]:
    """The obstacles of a scene that are not switched off, by name; none of an empty mapping."""
    if not isinstance(scene, Scene) and not mapping("scene", scene, "a jtik.Scene, or a dict of Scene.to_dict"):
        return {}
    read = scene if isinstance(scene, Scene) else Scene.from_dict(scene)
    return {name: obstacle for name, obstacle in read.obstacles.items() if read.gains[name] > 0}


def default_bodies(robot: Robot) -> str:
    """ "shapes" on a robot with solids that move, else "links"; "joints" on one without links, such as a gantry."""
    if any(joint.is_moving for frame in robot.shapes for joint in robot.path(frame)):
        return "shapes"
    return "links" if robot.segments else "joints"
