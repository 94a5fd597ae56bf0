"""``jtik robot``: the joints, limits and frames of a robot, and what was ignored when its file was loaded."""

from __future__ import annotations

import argparse
import json
import math
import shutil
import textwrap
import warnings
from collections.abc import Iterable
from typing import Any

from jtik.cli.output import json_value
from jtik.cli.robots import ACCEPTED, read_robot
from jtik.robot import Joint, JointType, Robot
from jtik.study import tables

UNITS = {JointType.REVOLUTE: "rad", JointType.PRISMATIC: "m"}
"""Unit of a position of a joint with limits."""

DROPPED_FIRST = ("moves", "speed [1/s]", "follows")
"""Columns that a narrow terminal leaves out, in this order."""


def add_arguments(commands: Any) -> None:
    """Add the command ``robot`` to argparse's subparsers."""
    command = commands.add_parser(
        "robot",
        help="joints, limits and frames of a robot, and what was ignored in its file",
        description="Show the joints, limits, frames and tip of a robot, and what was ignored in its file.",
        epilog="Exit code: 0 loaded, 1 with --check if there were warnings, 2 wrong input.",
    )
    command.add_argument("robot", metavar="ROBOT", help=ACCEPTED)
    command.add_argument("--check", action="store_true", help="end with exit code 1 if there were warnings")
    command.add_argument("--json", action="store_true", help="print the robot as JSON")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Load the robot, print it, and return 1 for warnings with ``--check``, else 0."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", UserWarning)
        robot = read_robot(arguments.robot)
    ignored = [str(each.message) for each in caught]
    if arguments.json:
        print(json.dumps(json_value(as_json(robot, ignored)), indent=1))
    else:
        print(as_text(robot, ignored, shutil.get_terminal_size().columns))
    return 1 if ignored and arguments.check else 0


def as_json(robot: Robot, ignored: list[str]) -> dict[str, Any]:
    """The robot as a JSON document; a limit that there is not is null."""
    return {
        "name": robot.name,
        "nq": robot.nq,
        "n": robot.n,
        "dimension": robot.dimension,
        "base": robot.base,
        "tip": robot.tip,
        "joints": [_joint(joint) for joint in robot.joints],
        "frames": list(robot.frame_names),
        "home": robot.home,
        "keyframes": dict(robot.keyframes),
        "ignored": ignored,
    }


def _joint(joint: Joint) -> dict[str, Any]:
    follows = joint.mimic and {name: getattr(joint.mimic, name) for name in ("joint", "multiplier", "offset")}
    names = ("name", "parent", "child", "lower", "upper", "velocity_limit")
    return {**{name: getattr(joint, name) for name in names}, "type": joint.type.value, "mimic": follows}


def as_text(robot: Robot, ignored: list[str], width: int) -> str:
    """The robot as text with lines of at most ``width`` characters, where the names allow it."""
    moving = [joint for joint in robot.joints if joint.is_moving]
    fixed = len(robot.joints) - len(moving)
    count = f"{len(moving)} moving joints" if len(moving) != 1 else "1 moving joint"
    size = f"n = {robot.n}" if robot.nq == robot.n else f"n = {robot.n}, nq = {robot.nq}"
    table, _ = tables.fitted(_table(moving), width, DROPPED_FIRST)
    parts = [
        f"{robot.name}: {count}, {fixed} fixed, {size}",
        f"base {robot.base}, tip {robot.tip}",
        "",
        tables.text(table),
        "",
        f"frames: {', '.join(robot.frame_names)}",
    ]
    if robot.keyframes:
        parts.append(f"keyframes: {', '.join(robot.keyframes)}")
    parts += ["ignored:", *(f"  {each}" for each in ignored)] if ignored else ["ignored: nothing"]
    folded = (line if "\n" in line else textwrap.fill(line, width, subsequent_indent="    ") for line in parts)
    return "\n".join(folded)


def _table(joints: list[Joint]) -> dict[str, list[str]]:
    """The columns of the moving joints; those that say nothing are left out."""
    columns = {
        "joint": [joint.name for joint in joints],
        "type": [joint.type.value for joint in joints],
        "unit": [UNITS.get(joint.type, "") for joint in joints],
        "lower": _numbers(joint.lower for joint in joints),
        "upper": _numbers(joint.upper for joint in joints),
        "speed [1/s]": _numbers(joint.velocity_limit for joint in joints),
        "follows": [_followed(joint) for joint in joints],
        "moves": [joint.child for joint in joints],
    }
    return {title: column for title, column in columns.items() if any(cell.strip() for cell in column)}


def _numbers(values: Iterable[float]) -> list[str]:
    """Numbers with five digits, right-aligned; nothing for what is infinite."""
    cells = [f"{value:.5g}" if math.isfinite(value) else "" for value in values]
    return [cell.rjust(max(map(len, cells))) for cell in cells]


def _followed(joint: Joint) -> str:
    if joint.mimic is None:
        return ""
    offset = f" {joint.mimic.offset:+g}" if joint.mimic.offset else ""
    return f"{joint.mimic.multiplier:g} {joint.mimic.joint}{offset}"
