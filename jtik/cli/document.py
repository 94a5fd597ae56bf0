"""A problem as a document: what a TOML or JSON file and the options of ``jtik solve`` are read into.

target = [6.0, 3.0]
q0 = [0.1, 0.1, 0.1]
strategy = "hybrid"                       # or a table: name, and options of that strategy

[robot]
kind = "planar"                           # planar, vehicle, dh or builtin, and the arguments of its builder
links = 3

[task]                                    # arguments of FrameTask; or type = "relative", "axis", "look_at" or
frame = "tip"                             # "center_of_mass" and its arguments; or several [[task]], then the
                                          # target is a table by their names

[[criteria]]                              # name, weight, and options of that criterion
name = "obstacle_avoidance"
weight = 0.3
options = { bodies = "both" }

[obstacles]                               # for every criterion that takes obstacles
circles = [[4.0, 2.0, 0.6]]               # x, y, radius [m]

[solve]                                   # limits, and arguments of InverseKinematics.solve
until = "stationary"
"""

from __future__ import annotations

import inspect
import json
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from jtik.criterion.base import Criterion, CriterionSum
from jtik.errors import ArgumentError, JtikError, UnknownNameError
from jtik.geometry import Circle, Obstacle, Point, Sphere
from jtik.registry import criteria, strategies
from jtik.robot import Robot, gallery
from jtik.solver import InverseKinematics
from jtik.strategy import Strategy
from jtik.task import AxisTask, CenterOfMassTask, FrameTask, LookAtTask, RelativeFrameTask, Task

Table = Mapping[str, Any]
T = TypeVar("T")

ROBOTS: dict[str, Callable[..., Robot]] = {
    "planar": Robot.planar,
    "vehicle": Robot.vehicle,
    "dh": Robot.from_dh,
    "builtin": Robot.builtin,
}
TASKS: dict[str, Callable[..., Task]] = {
    "frame": FrameTask,
    "relative": RelativeFrameTask,
    "axis": AxisTask,
    "look_at": LookAtTask,
    "center_of_mass": CenterOfMassTask,
}
KEYS = ("robot", "task", "target", "q0", "strategy", "criteria", "obstacles", "solve")
SHAPES = ("circles", "spheres", "points")
_SOLVE = tuple(
    name
    for name in inspect.signature(InverseKinematics.solve).parameters
    if name not in ("self", "target", "q0", "trace")
)


class InputError(JtikError):
    """Input of the command line that cannot be used; the message says what is accepted."""


@dataclass(frozen=True)
class Problem:
    """What a document says.

    Attributes:
        ik: the solver.
        target: for its task.
        options: of its ``solve``.
    """

    ik: InverseKinematics
    target: Any
    options: Mapping[str, Any]


def load(path: str | Path) -> dict[str, Any]:
    """The document in a TOML or JSON file. Raises InputError when it is neither, or broken."""
    file = Path(path)
    readers: dict[str, Callable[[str], Any]] = {".toml": tomllib.loads, ".json": json.loads}
    if file.suffix not in readers:
        raise InputError(f"{file}: the name of a problem file ends in {' or '.join(readers)}")
    try:
        document = readers[file.suffix](file.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise InputError(f"{file}: no such file") from None
    except ValueError as error:  # of both readers, and of the decoding
        raise InputError(f"{file}: not valid {file.suffix[1:].upper()}: {error}") from None
    return dict(_table(str(file), document, KEYS))


@dataclass(frozen=True)
class Subject:
    """What a document says of robot, tasks and criteria."""

    robot: Robot
    tasks: list[Task]
    criteria: CriterionSum


def read_subject(document: Table) -> Subject:
    """Robot, tasks and criteria that a document describes.

    Raises:
        JtikError: for an unknown or missing key, a name that is not registered, or an argument that is refused.
    """
    _table("the problem", document, KEYS)
    if "robot" not in document:
        raise InputError(f"robot is missing; a problem needs one, and takes {', '.join(KEYS)}")
    return Subject(
        _robot(document["robot"]),
        _tasks(document.get("task", {})),
        _criteria(document.get("criteria", []), _obstacles(document.get("obstacles", {}))),
    )


def read(document: Table) -> Problem:
    """The problem a document describes.

    Raises:
        JtikError: for an unknown or missing key, a name that is not registered, or an argument that is refused.
    """
    if "target" not in document:
        raise InputError(f"target is missing; a problem needs robot and target, and takes {', '.join(KEYS)}")
    subject = read_subject(document)
    options = dict(_table("[solve]", document.get("solve", {}), (*_SOLVE, "limits")))
    limits = options.pop("limits", True)
    if not isinstance(limits, bool):
        raise ArgumentError("limits", limits, "true or false")
    ik = InverseKinematics(
        subject.robot,
        subject.tasks,
        criteria=subject.criteria,
        strategy=_strategy(document.get("strategy", "hybrid")),
        limits=limits,
    )
    return Problem(ik, document["target"], {**options, "q0": document.get("q0")})


def robot_table(specification: str) -> dict[str, Any]:
    """``planar:10``, ``planar:1,0.8,0.5``, ``vehicle:3`` or the name of a built-in robot as the table [robot].

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


def _robot(given: Any) -> Robot:
    table = dict(robot_table(given) if isinstance(given, str) else _table("[robot]", given))
    kind = _name("[robot] kind", table.pop("kind", None), ROBOTS)
    if kind not in ROBOTS:
        raise UnknownNameError("robot kind", kind, ROBOTS)
    return _call(f"[robot] {kind}", ROBOTS[kind], table)


def _tasks(given: Any) -> list[Task]:
    tasks = []
    for entry in given if isinstance(given, list) else [given]:
        table = dict(_table("[task]", entry))
        kind = _name("[task] type", table.pop("type", "frame"), TASKS)
        if kind not in TASKS:
            raise UnknownNameError("task type", kind, TASKS)
        tasks.append(_call("[task]", TASKS[kind], table))
    return tasks


def _strategy(given: Any) -> Strategy:
    table = dict(_table("[strategy]", {"name": given} if isinstance(given, str) else given))
    name = _name("[strategy] name", table.pop("name", None), strategies)
    return _call(f"strategy {name!r}", strategies[name], table)


def _criteria(given: Any, obstacles: list[Obstacle]) -> CriterionSum:
    if not isinstance(given, list):
        raise InputError("criteria: accepted: a list of tables with name, weight and options")
    total = CriterionSum(())
    for entry in given:
        table = _table(
            "[[criteria]]", {"name": entry} if isinstance(entry, str) else entry, ("name", "weight", "options")
        )
        name = _name("[[criteria]] name", table.get("name"), criteria)
        weight = table.get("weight", 1.0)
        if not isinstance(weight, (int, float)):
            raise ArgumentError(f"weight of {name}", weight, "a finite number")
        total = total + weight * _criterion(name, _table("options", table.get("options", {})), obstacles)
    return total


def _criterion(name: str, options: Table, obstacles: list[Obstacle]) -> Criterion:
    plugin = criteria[name]
    where = f"criterion {name!r}"
    if "obstacles" in options:
        raise InputError(f"{where}: obstacles belong in [obstacles], or in --circle, --sphere and --point")
    wanted = inspect.signature(plugin).parameters.get("obstacles")
    if wanted is None:
        return _call(where, plugin, options)
    if not obstacles and wanted.default is wanted.empty:
        raise InputError(f"{where} needs obstacles: [obstacles] in a file, or --circle, --sphere and --point")
    return _call(where, plugin, {**options, "obstacles": obstacles} if obstacles else options)


def _obstacles(given: Any) -> list[Obstacle]:
    table = _table("[obstacles]", given, SHAPES)
    makers: dict[str, tuple[Callable[..., Obstacle], int]] = {"circles": (Circle, 2), "spheres": (Sphere, 3)}
    found: list[Obstacle] = []
    for shape, rows in table.items():
        if not isinstance(rows, list) or not all(isinstance(row, list) for row in rows):
            raise InputError(f"[obstacles] {shape}: accepted: a list of lists of numbers")
        for row in rows:
            if shape == "points":
                found.append(_call("points", Point, {"center": row}))
                continue
            make, dimension = makers[shape]
            if len(row) != dimension + 1:
                names = ", ".join("xyz"[:dimension])
                raise InputError(f"{shape}: given {row}; accepted: {names}, radius [m]")
            found.append(_call(shape, make, {"center": row[:-1], "radius": row[-1]}))
    return found


def _name(where: str, given: Any, known: Iterable[str]) -> str:
    """``given``, if it is a text at all."""
    if not isinstance(given, str):
        raise ArgumentError(where, "nothing" if given is None else given, f"one of {', '.join(known)}")
    return given


def _table(where: str, given: Any, accepted: Iterable[str] | None = None) -> Table:
    """``given``, if it is a table without unknown keys."""
    if not isinstance(given, Mapping):
        listed = "" if accepted is None else f" with keys {', '.join(accepted)}"
        raise InputError(f"{where}: accepted: a table{listed}")
    if accepted is not None:
        known = tuple(accepted)
        for key in given:
            if key not in known:
                raise UnknownNameError(f"key of {where}", key, known)
    return given


def _call(where: str, make: Callable[..., T], options: Any) -> T:
    """``make`` with options from a document; whatever is wrong with them is told with the place."""
    parameters = inspect.signature(make).parameters
    _table(where, options, parameters)
    for name, parameter in parameters.items():
        if parameter.default is parameter.empty and name not in options:
            raise InputError(f"{where}: {name} is missing; accepted: {', '.join(parameters)}")
    try:
        return make(**options)
    except JtikError:
        raise
    except (TypeError, ValueError) as error:  # a text where a number belongs, say
        raise InputError(f"{where}: {error}") from error
