"""The sections of a problem document: robot, tasks, strategy, criteria and obstacles as objects of jtik."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

from jtik.cli.checks import InputError, Table, call, checked_name, checked_table
from jtik.criterion import Criterion, CriterionSum
from jtik.errors import ArgumentError, UnknownNameError
from jtik.geometry import Circle, Obstacle, Point, Sphere
from jtik.registry import criteria, strategies, strategy_of
from jtik.robot import Robot, gallery
from jtik.strategy import Strategy
from jtik.task import AxisTask, CenterOfMassTask, FrameTask, LookAtTask, RelativeFrameTask, Task

ROBOTS: dict[str, Callable[..., Robot]] = {
    "planar": Robot.planar,
    "vehicle": Robot.vehicle,
    "dh": Robot.from_dh,
    "builtin": Robot.builtin,
}
"""Kinds of robots and the functions that build them."""

TASKS: dict[str, Callable[..., Task]] = {
    "frame": FrameTask,
    "relative": RelativeFrameTask,
    "axis": AxisTask,
    "look_at": LookAtTask,
    "center_of_mass": CenterOfMassTask,
}
"""Types of tasks."""

SHAPES = ("circles", "spheres", "points")
"""Keys of the section [obstacles]."""


def robot_table(specification: str) -> dict[str, Any]:
    """The table [robot] for a robot that is given as one text.

    Args:
        specification: ``planar:10``, ``planar:1,0.8,0.5``, ``vehicle:3`` or the name of a built-in robot.

    Raises:
        ArgumentError: when it is none of those.
        UnknownNameError: when it is a name, but of no built-in robot.
    """
    accepted = "planar:10, planar:1,0.8,0.5, vehicle:3 or a built-in robot; other robots come from a file"
    kind, colon, links = specification.partition(":")
    if kind not in ("planar", "vehicle"):
        if not colon and kind:
            return {"kind": "builtin", "name": gallery.describe(kind).name}
        raise ArgumentError("robot", specification, accepted)
    try:
        lengths = [float(length) for length in links.split(",")]
    except ValueError:
        raise ArgumentError("robot", specification, accepted) from None
    return {"kind": kind, "links": int(links) if links.strip().isdecimal() else lengths}


def read_robot(given: Any) -> Robot:
    """The robot of a section [robot], or of its short form."""
    table = dict(robot_table(given) if isinstance(given, str) else checked_table("[robot]", given))
    kind = checked_name("[robot] kind", table.pop("kind", None), ROBOTS)
    if kind not in ROBOTS:
        raise UnknownNameError("robot kind", kind, ROBOTS)
    return call(f"[robot] {kind}", ROBOTS[kind], table)


def read_tasks(given: Any) -> list[Task]:
    """The tasks of a section [task], or of several [[task]]."""
    tasks = []
    for entry in given if isinstance(given, list) else [given]:
        table = dict(checked_table("[task]", entry))
        kind = checked_name("[task] type", table.pop("type", "frame"), TASKS)
        if kind not in TASKS:
            raise UnknownNameError("task type", kind, TASKS)
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


def read_criteria(given: Any, obstacles: list[Obstacle]) -> CriterionSum:
    """The weighted sum of the sections [[criteria]]."""
    if not isinstance(given, list):
        raise InputError("criteria: accepted: a list of tables with name, weight and options")
    total = CriterionSum(())
    for entry in given:
        table = checked_table(
            "[[criteria]]", {"name": entry} if isinstance(entry, str) else entry, ("name", "weight", "options")
        )
        name = checked_name("[[criteria]] name", table.get("name"), criteria.names())
        weight = table.get("weight", 1.0)
        if not isinstance(weight, (int, float)):
            raise ArgumentError(f"weight of {name}", weight, "a finite number")
        total = total + weight * _criterion(name, checked_table("options", table.get("options", {})), obstacles)
    return total


def _criterion(name: str, options: Table, obstacles: list[Obstacle]) -> Criterion:
    """One criterion; it gets the obstacles if it has that argument."""
    plugin = criteria[name]
    where = f"criterion {name!r}"
    if "obstacles" in options:
        raise InputError(f"{where}: obstacles belong in [obstacles], or in --circle, --sphere and --point")
    wanted = inspect.signature(plugin).parameters.get("obstacles")
    if wanted is None:
        return call(where, plugin, options)
    if not obstacles and wanted.default is wanted.empty:
        raise InputError(f"{where} needs obstacles: [obstacles] in a file, or --circle, --sphere and --point")
    return call(where, plugin, {**options, "obstacles": obstacles} if obstacles else options)


def read_obstacles(given: Any) -> list[Obstacle]:
    """The obstacles of a section [obstacles]."""
    table = checked_table("[obstacles]", given, SHAPES)
    makers: dict[str, tuple[Callable[..., Obstacle], int]] = {"circles": (Circle, 2), "spheres": (Sphere, 3)}
    found: list[Obstacle] = []
    for shape, rows in table.items():
        if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
            raise InputError(f"[obstacles] {shape}: accepted: a list of lists of numbers")
        for row in rows:
            if shape == "points":
                found.append(call("points", Point, {"center": row}))
                continue
            make, dimension = makers[shape]
            if len(row) != dimension + 1:
                names = ", ".join("xyz"[:dimension])
                raise InputError(f"{shape}: given {row}; accepted: {names}, radius [m]")
            found.append(call(shape, make, {"center": row[:-1], "radius": row[-1]}))
    return found
