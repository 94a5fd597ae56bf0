"""A problem as a document: the keys of a TOML or JSON file, which the options of ``jtik solve`` can override.

docs/guides/command_line.md describes the format.
"""

from __future__ import annotations

import inspect
import json
import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jtik.cli.checks import InputError, Table, checked_table, read_text
from jtik.cli.document_sections import read_criteria, read_obstacles, read_strategy, read_tasks
from jtik.cli.own_criteria import is_own
from jtik.cli.robots import SUFFIXES, read_robot
from jtik.cli.values import POSES, size, start_of
from jtik.criterion import CriterionSum
from jtik.errors import ArgumentError
from jtik.geometry import Obstacle, Scene
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.task import Task

KEYS = ("robot", "task", "target", "q0", "strategy", "criteria", "obstacles", "solve")
"""Keys of a document."""

_BUILD = ("limits", "compiled", "solver")
"""Keys of the section [solve] that are arguments of InverseKinematics."""

_SOLVE = tuple(
    name
    for name in inspect.signature(InverseKinematics.solve).parameters
    if name not in ("self", "target", "q0", "trace")
)
"""Keys of the section [solve] that are arguments of InverseKinematics.solve."""


MAX_DOTS = 100
"""Most dots of a key of a TOML document."""


@dataclass(frozen=True)
class DocumentSetup:
    """Robot, tasks and criteria of a document.

    Attributes:
        robot: the robot.
        tasks: the tasks.
        criteria: the weighted sum of the criteria; without terms where the document has none.
        obstacles: the obstacles.
    """

    robot: Robot
    tasks: list[Task]
    criteria: CriterionSum
    obstacles: Sequence[Obstacle] | Scene = ()


@dataclass(frozen=True)
class DocumentProblem:
    """A solver, and what it is to solve.

    Attributes:
        ik: the solver.
        target: the target of its task.
        options: the arguments of its ``solve``.
        obstacles: the obstacles of its criteria.
    """

    ik: InverseKinematics
    target: Any
    options: Mapping[str, Any]
    obstacles: Sequence[Obstacle] | Scene


def load(path: str | Path) -> dict[str, Any]:
    """The document of a TOML or JSON file. Raises InputError when it is neither, or its syntax is wrong.

    Files that it names are found from its own folder.
    """
    file = Path(path)
    readers: dict[str, Callable[[str], Any]] = {".toml": _read_toml, ".json": json.loads}
    if file.suffix not in readers:
        raise InputError(f"{file}: the name of a problem file ends in {' or '.join(readers)}")
    text = read_text(file)
    try:
        document = readers[file.suffix](text)
    except ValueError as error:
        raise InputError(f"{file}: not valid {file.suffix[1:].upper()}: {error}") from None
    except RecursionError:
        raise InputError(f"{file}: nested too deeply") from None
    return _from_folder(dict(checked_table(str(file), document, KEYS)), file.parent)


def _read_toml(text: str) -> Any:
    """The document of a TOML text. Raises RecursionError for long dotted keys, whose time is quadratic."""
    for line in text.splitlines():
        parts = line.split("=")
        keys = [re.split(r"[,{\[]", part)[-1] for part in parts[:-1]] or ([] if "," in line else [line])
        if any(key.count(".") > MAX_DOTS for key in keys):
            raise RecursionError
    return tomllib.loads(text)


def _from_folder(document: dict[str, Any], folder: Path) -> dict[str, Any]:
    """The document with its paths, those of a robot, a scene and criteria, as seen from the working directory."""
    robot = document.get("robot")
    if isinstance(robot, str) and Path(robot).suffix.lower() in SUFFIXES:
        document["robot"] = str(folder / robot)
    elif isinstance(robot, dict) and isinstance(robot.get("path"), str):
        document["robot"] = {**robot, "path": str(folder / robot["path"])}
    obstacles = document.get("obstacles")
    if isinstance(obstacles, dict) and isinstance(obstacles.get("scene"), str):
        document["obstacles"] = {**obstacles, "scene": str(folder / obstacles["scene"])}
    criteria = document.get("criteria")
    if isinstance(criteria, list):
        document["criteria"] = [_placed(entry, folder) for entry in criteria]
    return document


def _placed(entry: Any, folder: Path) -> Any:
    if isinstance(entry, dict) and isinstance(entry.get("name"), str):
        return {**entry, "name": _placed(entry["name"], folder)}
    return str(folder / entry) if isinstance(entry, str) and is_own(entry) else entry


def read_setup(document: Table) -> DocumentSetup:
    """Robot, tasks and criteria that a document describes.

    Raises:
        JtikError: for an unknown or missing key, a name that is not registered, or an argument that is refused.
    """
    checked_table("the problem", document, KEYS)
    if "robot" not in document:
        raise InputError(f"robot is missing; a problem needs one, and accepts {', '.join(KEYS)}")
    robot = read_robot(document["robot"])
    obstacles = read_obstacles(document.get("obstacles", {}), robot.dimension)
    tasks = read_tasks(document.get("task", {}), robot)
    return DocumentSetup(robot, tasks, read_criteria(document.get("criteria", []), obstacles), obstacles)


def _of_a_pose(document: Table) -> Table:
    """The document, whose task is one of the pose where the target is a pose and nothing says what kind it is."""
    task = document.get("task", {})
    if size(document["target"]) in POSES and isinstance(task, dict) and not task.keys() & {"kind", "type"}:
        return {**document, "task": {**task, "kind": "pose"}}
    return document


def read(document: Table, *, progress: bool = False) -> DocumentProblem:
    """The problem a document describes.

    Args:
        document: the document.
        progress: whether there is a bar while a solver is compiled.

    Raises:
        JtikError: for an unknown or missing key, a name that is not registered, or an argument that is refused.
    """
    if "target" not in document:
        raise InputError(f"target is missing; a problem needs robot and target, and accepts {', '.join(KEYS)}")
    setup = read_setup(_of_a_pose(document))
    options = dict(checked_table("[solve]", document.get("solve", {}), (*_SOLVE, *_BUILD)))
    build = {name: options.pop(name) for name in _BUILD if name in options}
    for flag in ("limits", "compiled"):
        if not isinstance(build.get(flag, True), bool):
            raise ArgumentError(flag, build[flag], "true or false")
    strategy = read_strategy(document.get("strategy", "hybrid"))
    build["progress"] = progress and build.get("compiled", False)
    ik = InverseKinematics(setup.robot, setup.tasks, criteria=setup.criteria, strategy=strategy, **build)
    q0 = start_of(ik.robot, document.get("q0"))
    return DocumentProblem(ik, document["target"], {**options, "q0": q0}, setup.obstacles)
