"""``jtik solve``: solve for one target, given by options, by a file, or by a file that options override."""

from __future__ import annotations

import argparse
import csv
import json
from pathlib import Path
from typing import Any

from jtik.cli.checks import check_folder, check_suffix
from jtik.cli.document import DocumentProblem, read
from jtik.cli.output import (
    PICTURES,
    coordinates,
    draw_solution,
    json_value,
    require_pictures,
    shows_progress,
    write_all,
)
from jtik.cli.problem_options import add_problem_options, override, problem_document
from jtik.cli.values import read_start, read_values
from jtik.result.solution import Solution

OPTIONS = (
    "until",
    "max_iterations",
    "restarts",
    "best_of",
    "seed",
    "position_tolerance",
    "orientation_tolerance",
    "limits",
    "compiled",
    "solver",
)
"""Options that are keys of the section [solve]."""


def add_arguments(commands: Any) -> None:
    """Add the command ``solve`` to argparse's subparsers."""
    command = commands.add_parser(
        "solve",
        help="joint positions for a target",
        description="Find joint positions for a target. Options override the values of a --file.",
        epilog="Exit code: 0 converged, 1 ended otherwise or a file could not be written, 2 wrong input. Lengths in m, "
        "angles in rad.",
    )
    add_problem_options(command, kind="pose for 7 or 16 numbers, else position")
    command.add_argument(
        "--target",
        nargs="+",
        metavar="NUMBER",
        help="X Y; X Y Z; X Y Z QW QX QY QZ; the 16 numbers of a pose (4, 4) row by row; or @FILE with such numbers",
    )
    command.add_argument(
        "--q0",
        nargs="+",
        metavar="START",
        help="where to start: numbers, @FILE, home, mid (the middle of the limits) or a keyframe (default: home)",
    )
    command.add_argument("--strategy", metavar="NAME", help="a name or a pair such as hybrid+qp (default: hybrid)")
    command.add_argument("--solver", metavar="NAME", help="what solves quadratic programs (default: daqp)")
    command.add_argument("--restarts", type=int, metavar="N", help="number of further starts to try (default: 0)")
    command.add_argument(
        "--best-of", type=int, metavar="N", help="find N configurations, with --restarts; the best is q"
    )
    command.add_argument("--seed", type=int, metavar="N", help="seed of the restarts (default: 0)")
    command.add_argument("--until", choices=("stationary", "reached"), help="when to stop (default: stationary)")
    command.add_argument("--max-iterations", type=int, metavar="N", help="maximum number of iterations")
    command.add_argument("--position-tolerance", type=float, metavar="METRES")
    command.add_argument("--orientation-tolerance", type=float, metavar="RADIANS")
    command.add_argument("--no-limits", dest="limits", action="store_false", default=None, help="ignore joint limits")
    command.add_argument("--compiled", action="store_true", default=None, help="the step as C, by a C compiler")
    command.add_argument("--trace", metavar="CSV", help="write every iteration to this file")
    command.add_argument("--plot", metavar="FILE", help="draw the way to the solution: .png, .svg or .pdf")
    command.add_argument("--out", metavar="FILE", help="write the solution: .json, or .csv with the joints as columns")
    command.add_argument("--json", action="store_true", help="print the solution as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Solve, print the solution, and return 0 when it converged, else 1."""
    check_folder(arguments.trace, arguments.plot, arguments.out)
    check_suffix("--plot", arguments.plot, PICTURES)
    check_suffix("--out", arguments.out, (".json", ".csv"))
    if arguments.plot:
        require_pictures()
    problem = read(_document(arguments), progress=shows_progress())
    traced = bool(arguments.trace or arguments.plot)
    solution = problem.ik.solve(problem.target, trace=traced, **problem.options)
    document = as_json(problem, solution)
    print(json.dumps(document, indent=1) if arguments.json else solution)
    written = write_all(
        [
            (arguments.trace, lambda path: _write_trace(path, problem, solution)),
            (arguments.out, lambda path: _write_solution(path, problem, solution, document)),
            (arguments.plot, lambda path: draw_solution(problem, solution).savefig(path)),
        ]
    )
    return 0 if solution.converged and written else 1


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
    return document | {name: json_value(getattr(solution, name)) for name in SHOWN}


def _document(arguments: argparse.Namespace) -> dict[str, Any]:
    """The document of the file, overridden by the options."""
    document = problem_document(arguments)
    if arguments.strategy is not None:
        document["strategy"] = arguments.strategy
    if arguments.q0 is not None:
        document["q0"] = read_start("--q0", arguments.q0)
    if arguments.target is not None:
        document["target"] = read_values("--target", arguments.target)
    override(document, "solve", arguments, OPTIONS)
    return document


def _write_solution(path: Path, problem: DocumentProblem, solution: Solution, document: dict[str, Any]) -> None:
    """Write the document, or a table: the solution and then its alternatives, with the joints as columns."""
    if path.suffix.lower() == ".json":
        path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
        return
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*coordinates(problem.ik.robot), "status", "position_error", "orientation_error", "cost"])
        for each in (solution, *solution.alternatives):
            figures = (each.position_error, each.orientation_error, each.cost)
            writer.writerow([*each.q.tolist(), each.status.name, *map(float, figures)])


def _write_trace(path: Path, problem: DocumentProblem, solution: Solution) -> None:
    """Write one row an iteration: q, the error, and the figures of the step from there. The last row has no step."""
    trace = solution.trace
    assert trace is not None
    steps, names = len(trace), list(trace.figures)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["iteration", *coordinates(problem.ik.robot), "error", *names])
        for k, (q, error) in enumerate(zip(trace.q, trace.error, strict=True)):
            figures = [float(trace.figures[name][k]) if k < steps else "" for name in names]
            writer.writerow([k, *q.tolist(), float(error), *figures])
