"""Options for robot, task, criteria and obstacles, which several commands share."""

from __future__ import annotations

import argparse
from typing import Any

from jtik.cli.checks import InputError
from jtik.cli.document import load
from jtik.cli.robots import robot_table

SHAPES = {"circle": ("X", "Y", "RADIUS"), "sphere": ("X", "Y", "Z", "RADIUS"), "point": ("X",)}


def add_problem_options(command: argparse.ArgumentParser, *, kind: str) -> None:
    """Add the options to a command; ``kind`` is the default kind of its task."""
    command.add_argument("--file", metavar="PROBLEM", help="a problem in TOML or JSON")
    what = "a file (.urdf, .xacro, .xml of MuJoCo), a built-in robot, planar:10, planar:1,0.8,0.5 or vehicle:3"
    command.add_argument("--robot", metavar="SPEC", help=what)
    command.add_argument("--frame", help="frame to bring to the target (default: the robot's tip)")
    command.add_argument("--kind", help=f"position, orientation or pose (default: {kind})")
    command.add_argument("--axes", nargs="+", metavar="AXIS", help="rows of the task to keep: x y z rx ry rz")
    command.add_argument(
        "--criterion",
        action="append",
        metavar="NAME[=WEIGHT]",
        help="a criterion to minimise, registered or your own as module.py:name; may be repeated",
    )
    command.add_argument(
        "--obstacle",
        action="append",
        nargs="+",
        type=float,
        metavar="NUMBER",
        help="centre and radius of a circle or sphere to keep away from, for a criterion such as obstacle_avoidance; "
        "without radius a point; may be repeated",
    )
    for shape, names in SHAPES.items():
        count: Any = len(names) if shape != "point" else "+"
        command.add_argument(
            f"--{shape}",
            action="append",
            nargs=count,
            type=float,
            metavar=names if shape != "point" else "NUMBER",
            help=f"a {shape} to keep away from; may be repeated",
        )


def problem_document(arguments: argparse.Namespace) -> dict[str, Any]:
    """The document of the file, overridden by these options."""
    document = load(arguments.file) if arguments.file else {}
    if arguments.robot is not None:
        document["robot"] = robot_table(arguments.robot)
    if arguments.criterion is not None:
        document["criteria"] = [_weighted(text) for text in arguments.criterion]
    obstacles = {f"{shape}s": rows for shape in SHAPES if (rows := getattr(arguments, shape)) is not None}
    if arguments.obstacle is not None:
        obstacles["balls"] = arguments.obstacle
    if obstacles:
        document["obstacles"] = obstacles
    override(document, "task", arguments, ("frame", "kind", "axes"))
    return document


def override(document: dict[str, Any], section: str, arguments: argparse.Namespace, names: tuple[str, ...]) -> None:
    """Override keys of one section of the document by the options that are given."""
    given = {name: value for name in names if (value := getattr(arguments, name)) is not None}
    if not given:
        return
    below = document.get(section, {})
    if isinstance(below, list):
        raise InputError("--frame, --kind and --axes change a single [task]; the file has several")
    document[section] = {**below, **given} if isinstance(below, dict) else below


def _weighted(text: str) -> dict[str, Any]:
    name, equals, weight = text.rpartition("=")
    name = name if equals else text
    try:
        return {"name": name, "weight": float(weight) if equals else 1.0}
    except ValueError:
        raise InputError(f"--criterion {text}: accepted: NAME or NAME=WEIGHT, a finite number") from None
