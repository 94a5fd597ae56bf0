"""``jtik view``: a robot, a trajectory or a study in 3-D in the browser."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from jtik.cli.checks import InputError
from jtik.cli.robots import ACCEPTED, read_robot
from jtik.cli.values import read_start, start_of
from jtik.geometry import Scene


def add_arguments(commands: Any) -> None:
    """Add the command ``view`` to argparse's subparsers."""
    command = commands.add_parser(
        "view",
        help="a robot, a trajectory or a study in 3-D in the browser",
        description="Show a robot with sliders and a target to drag, a trajectory, or a study of jtik compare --save, "
        "at an address of this machine that it prints. Ctrl-C ends it.",
        epilog="Exit code: 0 ended, 2 wrong input.",
    )
    command.add_argument("what", metavar="ROBOT|STUDY", help=f"{ACCEPTED}; or the .npz of a study")
    command.add_argument(
        "--q0",
        nargs="+",
        metavar="START",
        help="configuration: numbers, @FILE, home, mid or a keyframe (default: home)",
    )
    command.add_argument("--trajectory", metavar="FILE", help="a trajectory to show: .csv, .json or .npz")
    command.add_argument("--scene", metavar="FILE", help="obstacles to show: a scene in TOML or JSON")
    command.add_argument("--show", choices=("meshes", "shapes", "links"), default="meshes", help="default: %(default)s")
    command.add_argument("--port", type=int, metavar="N", help="port to use (default: any free one)")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Show it until Ctrl-C, and return 0."""
    import jtik

    options: dict[str, Any] = {"show": arguments.show, "port": arguments.port}
    if arguments.scene is not None:
        options["obstacles"] = Scene.load(arguments.scene)
    subjects: list[Any]
    if Path(arguments.what).suffix.lower() == ".npz":
        if arguments.q0 is not None or arguments.trajectory is not None:
            raise InputError("--q0 and --trajectory: accepted: with a robot, not with a study")
        subjects = [jtik.Comparison.load(arguments.what)]
    else:
        robot = read_robot(arguments.what)
        subjects = [robot]
        if arguments.trajectory is not None:
            subjects.append(jtik.Trajectory.load(arguments.trajectory))
        if arguments.q0 is not None:
            q0 = start_of(robot, read_start("--q0", arguments.q0))
            subjects.append(np.ravel(q0) if isinstance(q0, list) else q0)
    with jtik.view(*subjects, **options) as viewer:
        print(f"{viewer}; Ctrl-C ends it", flush=True)
        viewer.wait()
    return 0
