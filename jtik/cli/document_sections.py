"""The sections of a problem document: tasks, strategy, criteria and obstacles as objects of jtik."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Sequence
from typing import Any

from jtik.cli.checks import InputError, Table, call, checked_name, checked_table
from jtik.cli.own_criteria import is_own, own_criterion
from jtik.criterion import Criterion, CriterionSum, FunctionCriterion
from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry import Circle, Obstacle, Point, Scene, Sphere
from jtik.registry import criteria, strategies, strategy_of
from jtik.robot import Robot
from jtik.strategy import Strategy
from jtik.task import AxisTask, CenterOfMassTask, FrameTask, LookAtTask, RelativeFrameTask, Task

TASKS: dict[str, Callable[..., Task]] = {
    "frame": FrameTask,
    "relative": RelativeFrameTask,
    "axis": AxisTask,
    "look_at": LookAtTask,
    "center_of_mass": CenterOfMassTask,
}
"""Types of tasks."""

SHAPES = ("circles", "spheres", "points", "balls")
"""Keys of the section [obstacles]. A ball has a centre with as many coordinates as the robot, and perhaps a radius.

Any other key is the name of an obstacle, with a table as in the file of a `jtik.Scene`; `scene` is such a file."""


def read_tasks(given: Any, robot: Robot) -> list[Task]:
    """The tasks of a section [task], or of several [[task]]; a frame that is not named is the robot's tip."""
    tasks = []
    for entry in given if isinstance(given, list) else [given]:
        table = dict(checked_table("[task]", entry))
        kind = checked_name("[task] type", table.pop("type", "frame"), TASKS)
        if kind not in TASKS:
            raise UnknownNameError("task type", kind, TASKS)
        if kind == "frame":
            table = {"frame": robot.tip, **table}
        tasks.append(call("[task]", TASKS[kind], table))
    return tasks


def read_strategy(given: Any) -> Strategy:
    """The strategy of a name or of a pair of names such as newton+qp, or of a section [strategy]."""
    table = dict(checked_table("[strategy]", {"name": given} if isinstance(given, str) else given))
    name = checked_name("[strategy] name", table.pop("name", None), strategies.names())
    alone, plus, _ = name.partition("+")
    if plus:
        table["secondary"] = strategy_of(name).secondary  # type: ignore[attr-defined]  # as the pair has it
    return call(f"strategy {name!r}", strategies[alone], table)


def read_criteria(given: Any, obstacles: Sequence[Obstacle] | Scene) -> CriterionSum:
    """The weighted sum of the sections [[criteria]]. Warns of obstacles that no criterion takes."""
    if not isinstance(given, list):
        raise InputError("criteria: accepted: a list of tables with name, weight and options")
    total, taken = CriterionSum(()), not len(obstacles)
    for entry in given:
        table = checked_table(
            "[[criteria]]", {"name": entry} if isinstance(entry, str) else entry, ("name", "weight", "options")
        )
        name = checked_name("[[criteria]] name", table.get("name"), criteria.names())
        weight = table.get("weight", 1.0)
        if not isinstance(weight, (int, float)):
            raise ArgumentError(f"weight of {name}", weight, "a finite number")
        plugin = own_criterion(name) if is_own(name) else criteria[name]
        taken = taken or _takes_obstacles(plugin)
        total = total + weight * _criterion(name, plugin, checked_table("options", table.get("options", {})), obstacles)
    if not taken:
        able = [name for name, plugin in criteria.loaded().items() if _takes_obstacles(plugin)]
        warnings.warn(f"no criterion takes the obstacles; those that do: {', '.join(able)}", stacklevel=2)
    return total


def _takes_obstacles(plugin: Any) -> bool:
    return isinstance(plugin, type) and "obstacles" in inspect.signature(plugin).parameters


def _criterion(
    name: str, plugin: Criterion | type[Criterion], options: Table, obstacles: Sequence[Obstacle] | Scene
) -> Criterion:
    """One criterion; it gets the obstacles if it has that argument."""
    where = f"criterion {name!r}"
    if isinstance(plugin, FunctionCriterion):
        return plugin(**options)
    if isinstance(plugin, Criterion):
        checked_table(where, options, ())
        return plugin
    if "obstacles" in options:
        raise InputError(f"{where}: obstacles belong in [obstacles], or in --obstacle")
    if not _takes_obstacles(plugin):
        return call(where, plugin, options, "; a problem file has them as options of [[criteria]]")
    wanted = inspect.signature(plugin).parameters["obstacles"]
    if not len(obstacles) and wanted.default is wanted.empty:
        raise InputError(f"{where} needs obstacles: [obstacles] in a file, or --obstacle, --circle, --sphere, --point")
    return call(where, plugin, {**options, "obstacles": obstacles} if len(obstacles) else options)


def read_obstacles(given: Any, dimension: int) -> Sequence[Obstacle] | Scene:
    """The obstacles of a section [obstacles]; ``dimension`` is that of the robot's positions.

    A scene where one of them has a name and a table of its own, or is in the file of a scene; else a list.
    """
    table = checked_table("[obstacles]", given)
    named = {key: row for key, row in table.items() if key not in SHAPES and isinstance(row, dict)}
    lists = {key: row for key, row in table.items() if key not in named}
    checked_table("[obstacles]", lists, (*SHAPES, "scene", "or a table for each obstacle"))
    file = lists.pop("scene", None)
    found = _listed(lists, dimension)
    if file is None and not named:
        return found
    scene = Scene(found)
    for part in (Scene() if file is None else Scene.load(file), Scene.from_dict({"obstacles": named})):
        for name, obstacle in part.obstacles.items():
            if name in scene:
                raise InputError(f"[obstacles] {name}: given twice")
            scene = scene.with_(name, obstacle, part.gains[name])
    return scene


def _listed(table: Table, dimension: int) -> list[Obstacle]:
    """The obstacles of lists of numbers."""
    makers: dict[str, tuple[Callable[..., Obstacle], int]] = {"circles": (Circle, 2), "spheres": (Sphere, 3)}
    found: list[Obstacle] = []
    for shape, rows in table.items():
        if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
            raise InputError(f"[obstacles] {shape}: accepted: a list of lists of numbers")
        for row in rows:
            if shape == "points":
                found.append(call("points", Point, {"center": row}))
                continue
            make, count = makers[shape] if shape in makers else (makers["circles"], makers["spheres"])[dimension - 2]
            if shape == "balls" and len(row) == count:
                found.append(call(shape, Point, {"center": row}))
                continue
            if len(row) != count + 1:
                names = ", ".join("xyz"[:count])
                more = f", or {names} of a point" if shape == "balls" else ""
                raise InputError(f"{shape}: given {row}; accepted: {names}, radius [m]{more}")
            found.append(call(shape, make, {"center": row[:-1], "radius": row[-1]}))
    return found
