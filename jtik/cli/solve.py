"""``jtik solve``: solve for one target, given by options, by a file, or by a file that options override."""

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

from jtik.cli.checks import InputError
from jtik.cli.document import DocumentProblem, read
from jtik.cli.problem_options import add_problem_options, override, problem_document
from jtik.result.solution import Solution, Trace


def add_arguments(commands: Any) -> None:
    """Add the command ``solve`` to argparse's subparsers."""
    command = commands.add_parser(
        "solve",
        help="joint positions for a target",
        description="Find joint positions for a target. Options override the values of a --file.",
        epilog="Exit code: 0 converged, 1 ended otherwise, 2 wrong input. Lengths in m, angles in rad.",
    )
    add_problem_options(command, kind="position")
    command.add_argument("--target", nargs="+", type=float, metavar="NUMBER", help="such as X Y, or X Y Z")
    command.add_argument("--q0", nargs="+", type=float, metavar="NUMBER", help="where to start (default: home)")
    command.add_argument(
        "--strategy",
        metavar="NAME",
        help="a name or a pair such as newton+qp (default: hybrid)",
    )
    command.add_argument("--until", choices=("stationary", "reached"), help="when to stop (default: stationary)")
    command.add_argument("--max-iterations", type=int, metavar="N", help="maximum number of iterations")
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
    "evaluations",
    "alternatives",
    "cost",
    "criteria",
    "jacobian",
    "gradient",
    "null_space_residual",
    "multipliers",
    "second_order",
    "condition",
    "active_limits",
    "active_clearances",
    "relaxed",
    "unused",
    "seconds",
)
"""Attributes of a Solution that the JSON has."""


def as_json(problem: DocumentProblem, solution: Solution) -> dict[str, Any]:
    """A solution without its trace, as a JSON document. Numbers that are not finite become null."""
    robot = problem.ik.robot
    document = {
        "robot": robot.name,
        "joint_names": list(robot.joint_names),
        "strategy": repr(problem.ik.strategy),
        "why": solution.status.value,
    }
    return document | {name: _json_value(getattr(solution, name)) for name in SHOWN}


def _json_value(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(key): _json_value(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return _json_value(value.tolist())
    if isinstance(value, np.generic):
        return _json_value(value.item())
    if isinstance(value, (list, tuple)):
        return [_json_value(item) for item in value]
    if isinstance(value, Solution):
        return {"q": _json_value(value.q), "status": value.status.name, "cost": _json_value(value.cost)}
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else repr(value)


def _document(arguments: argparse.Namespace) -> dict[str, Any]:
    """The document of the file, overridden by the options."""
    document = problem_document(arguments)
    for key in ("target", "q0", "strategy"):
        if getattr(arguments, key) is not None:
            document[key] = getattr(arguments, key)
    override(
        document,
        "solve",
        arguments,
        ("until", "max_iterations", "position_tolerance", "orientation_tolerance", "limits"),
    )
    return document


def _write_trace(path: Path, trace: Trace) -> None:
    """Write one row an iteration: q, the error, and the figures of the step from there. The last row has no step."""
    steps, columns = len(trace), trace.q.shape[1]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["iteration", *(f"q{i}" for i in range(columns)), "error", *trace.figures])
        for k, (q, error) in enumerate(zip(trace.q, trace.error, strict=True)):
            figures = (
                [float(figure[k]) for figure in trace.figures.values()] if k < steps else [""] * len(trace.figures)
            )
            writer.writerow([k, *q.tolist(), float(error), *figures])
