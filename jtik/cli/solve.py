"""``jtik solve``: one target, from options, from a file, or from a file changed by options."""

from __future__ import annotations

import argparse
import csv
import json
import math
from collections.abc import Mapping
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from jtik.cli.document import InputError, Problem, load, read, robot_table
from jtik.solution import Solution, Trace

_SHAPES = {"circle": ("X", "Y", "RADIUS"), "sphere": ("X", "Y", "Z", "RADIUS"), "point": ("X",)}


def add_arguments(commands: Any) -> None:
    """Add the command ``solve`` to argparse's subparsers."""
    command = commands.add_parser(
        "solve",
        help="joint positions for a target",
        description="Find joint positions for a target. Options override what a --file says.",
        epilog="Exit code: 0 converged, 1 ended otherwise, 2 wrong input. Lengths in m, angles in rad.",
    )
    command.add_argument("--file", metavar="PROBLEM", help="a problem in TOML or JSON")
    command.add_argument("--robot", metavar="SPEC", help="planar:10, planar:1,0.8,0.5, vehicle:3 or a built-in robot")
    command.add_argument("--frame", help="frame to bring to the target (default: tip)")
    command.add_argument("--kind", help="position, orientation or pose (default: position)")
    command.add_argument("--axes", nargs="+", metavar="AXIS", help="rows of the task to keep: x y z rx ry rz")
    command.add_argument("--target", nargs="+", type=float, metavar="NUMBER", help="such as X Y, or X Y Z")
    command.add_argument("--q0", nargs="+", type=float, metavar="NUMBER", help="configuration to start from")
    command.add_argument("--strategy", metavar="NAME", help="a name that `jtik list` shows (default: hybrid)")
    command.add_argument(
        "--criterion",
        action="append",
        metavar="NAME[=WEIGHT]",
        help="a criterion to minimise; may be repeated",
    )
    for shape, names in _SHAPES.items():
        count: Any = len(names) if shape != "point" else "+"
        command.add_argument(
            f"--{shape}",
            action="append",
            nargs=count,
            type=float,
            metavar=names if shape != "point" else "NUMBER",
            help=f"a {shape} to keep away from; may be repeated",
        )
    command.add_argument("--until", choices=("steady", "reached"), help="when to stop (default: steady)")
    command.add_argument("--max-iterations", type=int, metavar="N", help="most steps to try")
    command.add_argument("--position-tolerance", type=float, metavar="METRES")
    command.add_argument("--orientation-tolerance", type=float, metavar="RADIANS")
    command.add_argument("--no-limits", dest="limits", action="store_false", default=None, help="ignore joint limits")
    command.add_argument("--trace", metavar="CSV", help="write every iteration to this file")
    command.add_argument("--json", action="store_true", help="print the solution as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Solve, print the solution, and return 0 when it converged, else 1."""
    problem = read(_document(arguments))
    if arguments.trace and not Path(arguments.trace).absolute().parent.is_dir():
        raise InputError(f"{arguments.trace}: no such folder")
    solution = problem.ik.solve(problem.target, trace=bool(arguments.trace), **problem.options)
    if arguments.trace:
        assert solution.trace is not None
        _write_trace(Path(arguments.trace), solution.trace)
    print(json.dumps(as_json(problem, solution), indent=1) if arguments.json else solution)
    return 0 if solution.converged else 1


SHOWN = (
    "q",
    "status",
    "converged",
    "error",
    "position_error",
    "orientation_error",
    "iterations",
    "escapes",
    "restarts",
    "cost",
    "criteria",
    "jacobian",
    "gradient",
    "null_space_residual",
    "second_order",
    "condition",
    "active_limits",
    "seconds",
)
"""What of a Solution the JSON holds."""


def as_json(problem: Problem, solution: Solution) -> dict[str, Any]:
    """Everything a solution holds but its trace; a number that is not finite becomes null."""
    robot = problem.ik.robot
    document = {
        "robot": robot.name,
        "joint_names": list(robot.joint_names),
        "strategy": repr(problem.ik.strategy),
        "why": solution.status.value,
    }
    return document | {name: _plain(getattr(solution, name)) for name in SHOWN}


def _plain(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _plain(value.tolist())
    if isinstance(value, np.generic):
        return _plain(value.item())
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else repr(value)


def _document(arguments: argparse.Namespace) -> dict[str, Any]:
    """The file's document with the options laid over it."""
    document = load(arguments.file) if arguments.file else {}
    if arguments.robot is not None:
        document["robot"] = robot_table(arguments.robot)
    for key in ("target", "q0", "strategy"):
        if getattr(arguments, key) is not None:
            document[key] = getattr(arguments, key)
    if arguments.criterion is not None:
        document["criteria"] = [_weighted(text) for text in arguments.criterion]
    obstacles = {f"{shape}s": rows for shape in _SHAPES if (rows := getattr(arguments, shape)) is not None}
    if obstacles:
        document["obstacles"] = obstacles
    for section, names in (
        ("task", ("frame", "kind", "axes")),
        ("solve", ("until", "max_iterations", "position_tolerance", "orientation_tolerance", "limits")),
    ):
        given = {name: value for name in names if (value := getattr(arguments, name)) is not None}
        if given:
            below = document.get(section, {})
            if section == "task" and isinstance(below, list):
                raise InputError("--frame, --kind and --axes change a single [task]; the file has several")
            document[section] = {**below, **given} if isinstance(below, dict) else below
    return document


def _weighted(text: str) -> dict[str, Any]:
    name, equals, weight = text.partition("=")
    try:
        return {"name": name, "weight": float(weight) if equals else 1.0}
    except ValueError:
        raise InputError(f"--criterion {text}: accepted: NAME or NAME=WEIGHT, a number from 0") from None


def _write_trace(path: Path, trace: Trace) -> None:
    """A row an iteration: q, the error, and the figures of the step from there; the last row has no step."""
    steps, columns = len(trace), trace.q.shape[1]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["iteration", *(f"q{i}" for i in range(columns)), "error", *trace.figures])
        for k, (q, error) in enumerate(zip(trace.q, trace.error, strict=True)):
            figures = (
                [float(figure[k]) for figure in trace.figures.values()] if k < steps else [""] * len(trace.figures)
            )
            writer.writerow([k, *q.tolist(), float(error), *figures])
