"""``jtik plan``: the interactive planner, served as a page on this machine."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import gc
import os
import signal
import sys
import threading
import time
import webbrowser
from pathlib import Path
from typing import Any

from jtik.cli.robots import read_robot

PATIENCE = 0.3
"""Time for threads without work to end [s]."""

EPILOG = "Without options: a ten-link arm in a field of discs. Ctrl-C ends it; what was recorded is kept. Exit code: 0."


def add_arguments(commands: Any) -> None:
    """Add the command ``plan`` to argparse's subparsers."""
    what = "guide an arm through obstacles by hand, in the browser"
    command = commands.add_parser("plan", help=what, description=f"The planner: {what}.", epilog=EPILOG)
    robots = "a file (.urdf, .xacro, .xml of MuJoCo), a built-in robot, planar:10, planar:1,0.8,0.5 or vehicle:3"
    command.add_argument("--robot", metavar="SPEC", help=robots)
    command.add_argument("--scene", metavar="FILE", help="obstacles, a scene in TOML or JSON (see jtik.Scene)")
    command.add_argument("--strategy", metavar="NAME", default="hybrid", help="(default: hybrid)")
    command.add_argument("--criterion", action="append", metavar="NAME", help="a registered criterion; may be repeated")
    command.add_argument("--compiled", action="store_true", help="the step as C, by a C compiler")
    command.add_argument("--port", type=int, metavar="N", help="port on 127.0.0.1; 0: any free one (default: 8731)")
    command.add_argument("--no-browser", action="store_true", help="print the address only")
    command.add_argument("--folder", metavar="DIR", help="where what is recorded is kept (default: the user's own)")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Serve the page until Ctrl-C, and return 0.

    A solver that is being built, or a file that is being drawn, is given up: where such work goes on in a thread, the
    process ends here.
    """
    from jtik.geometry import Scene
    from jtik.planner import Planner
    from jtik.planner.web.desk import Desk
    from jtik.planner.web.server import PORT, Server, check_port

    others = set(threading.enumerate())
    port = check_port(PORT if arguments.port is None else arguments.port)
    robot = None if arguments.robot is None else read_robot(arguments.robot)
    scene = None if arguments.scene is None else Scene.load(Path(arguments.scene))
    chosen = {} if arguments.criterion is None else {"criteria": arguments.criterion}
    print("building the solver ...", flush=True)
    planner = Planner(
        robot,
        scene=scene,
        strategy=arguments.strategy,
        compiled=arguments.compiled,
        folder=arguments.folder,
        **chosen,
    )
    server = Server(Desk(planner.loop), port=port)
    leave_alone()

    def ready() -> None:
        print(f"the planner is at {server.url} (Ctrl-C ends it)", flush=True)
        if not arguments.no_browser:
            webbrowser.open(server.url)

    with planner, contextlib.suppress(KeyboardInterrupt, asyncio.CancelledError):
        asyncio.run(_serve(server, ready))
    print("the planner is closed", file=sys.stderr)
    if _work_goes_on(others):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)  # the interpreter would wait for the threads
    return 0


def leave_alone() -> None:
    """Have the garbage collector leave alone what there is: to look at all of it takes longer than a period."""
    gc.collect()
    gc.freeze()


def _work_goes_on(others: set[threading.Thread]) -> bool:
    """Whether threads are still at work, apart from some others; the interpreter waits for daemons, too."""
    own = [each for each in threading.enumerate() if each not in others]
    end = time.monotonic() + PATIENCE
    for thread in own:
        thread.join(max(0.0, end - time.monotonic()))
    return any(thread.is_alive() for thread in own)


async def _serve(server: Any, ready: Any) -> None:
    """Serve until Ctrl-C, or until the process is asked to end."""
    task = asyncio.current_task()
    assert task is not None
    with contextlib.suppress(NotImplementedError):  # Windows has no such handlers
        asyncio.get_running_loop().add_signal_handler(signal.SIGTERM, task.cancel)
    await server.serve(ready)
