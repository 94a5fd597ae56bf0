"""A problem as a document: the keys of a TOML or JSON file, which the options of ``jtik solve`` can override.

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

[obstacles]                               # for every criterion with obstacles
circles = [[4.0, 2.0, 0.6]]               # x, y, radius [m]

[solve]                                   # limits, and arguments of InverseKinematics.solve
until = "stationary"
"""

from __future__ import annotations

import inspect
import json
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jtik.cli.checks import InputError, Table, checked_table
from jtik.cli.document_sections import read_criteria, read_obstacles, read_robot, read_strategy, read_tasks
from jtik.criterion import CriterionSum
from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.solver import InverseKinematics
from jtik.task import Task

KEYS = ("robot", "task", "target", "q0", "strategy", "criteria", "obstacles", "solve")
"""Keys of a document."""

_SOLVE = tuple(
    name
    for name in inspect.signature(InverseKinematics.solve).parameters
    if name not in ("self", "target", "q0", "trace")
)
"""Keys of the section [solve]."""


@dataclass(frozen=True)
class DocumentSetup:
    """Robot, tasks and criteria of a document.

    Attributes:
        robot: the robot.
        tasks: the tasks.
        criteria: the weighted sum of the criteria; without terms where the document has none.
    """

    robot: Robot
    tasks: list[Task]
    criteria: CriterionSum


@dataclass(frozen=True)
class DocumentProblem:
    """A solver, and what it is to solve.

    Attributes:
        ik: the solver.
        target: the target of its task.
        options: the arguments of its ``solve``.
    """

    ik: InverseKinematics
    target: Any
    options: Mapping[str, Any]


def load(path: str | Path) -> dict[str, Any]:
    """The document of a TOML or JSON file. Raises InputError when it is neither, or its syntax is wrong."""
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
    return dict(checked_table(str(file), document, KEYS))


def read_setup(document: Table) -> DocumentSetup:
    """Robot, tasks and criteria that a document describes.

    Raises:
        JtikError: for an unknown or missing key, a name that is not registered, or an argument that is refused.
    """
    checked_table("the problem", document, KEYS)
    if "robot" not in document:
        raise InputError(f"robot is missing; a problem needs one, and accepts {', '.join(KEYS)}")
    return DocumentSetup(
        read_robot(document["robot"]),
        read_tasks(document.get("task", {})),
        read_criteria(document.get("criteria", []), read_obstacles(document.get("obstacles", {}))),
    )


def read(document: Table) -> DocumentProblem:
    """The problem a document describes.

    Raises:
        JtikError: for an unknown or missing key, a name that is not registered, or an argument that is refused.
    """
    if "target" not in document:
        raise InputError(f"target is missing; a problem needs robot and target, and accepts {', '.join(KEYS)}")
    setup = read_setup(document)
    options = dict(checked_table("[solve]", document.get("solve", {}), (*_SOLVE, "limits")))
    limits = options.pop("limits", True)
    if not isinstance(limits, bool):
        raise ArgumentError("limits", limits, "true or false")
    ik = InverseKinematics(
        setup.robot,
        setup.tasks,
        criteria=setup.criteria,
        strategy=read_strategy(document.get("strategy", "hybrid")),
        limits=limits,
    )
    return DocumentProblem(ik, document["target"], {**options, "q0": document.get("q0")})
