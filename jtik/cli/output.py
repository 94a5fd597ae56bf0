"""What commands print and write: JSON, names of columns, pictures, and files that may fail."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterable, Mapping
from enum import Enum
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jtik.cli.document import DocumentProblem
from jtik.geometry import Ball
from jtik.result.solution import Solution
from jtik.robot import Robot

if TYPE_CHECKING:
    from jtik.plotting import Figure

PICTURES = (".png", ".svg", ".pdf")
"""Suffixes of pictures."""


def write_all(outputs: Iterable[tuple[str | None, Callable[[Path], object]]]) -> bool:
    """Write every file that has a path, each even if another failed. Returns whether all were written.

    A file that cannot be written is one line on stderr.
    """
    complete = True
    for path, write in outputs:
        try:
            if path:
                write(Path(path))
        except OSError as error:
            complete = False
            print(f"jtik: {path}: {error.strerror or error}", file=sys.stderr)
    return complete


def coordinates(robot: Robot) -> list[str]:
    """A name for each entry of q: that of its joint, followed by [0], [1] ... of a ball or free joint."""
    joints = [(joint.name, joint.type.nq) for joint in robot.independent_joints]
    return [name if size == 1 else f"{name}[{i}]" for name, size in joints for i in range(size)]


def shows_progress() -> bool:
    """Whether there is a terminal for a bar, and rich to draw it."""
    return sys.stderr.isatty() and find_spec("rich") is not None


def require_pictures() -> None:
    """Raise MissingExtraError without matplotlib, before anything is computed."""
    from jtik.plotting import new_figure

    new_figure((1, 1))


def draw_solution(problem: DocumentProblem, solution: Solution) -> Figure:
    """The robot from light to dark, with the way of its tip and the obstacles.

    It shows the iterations; with restarts, whose iterations belong to several ways, the start and the solution.
    """
    from jtik.study.figures.robot_drawing import RobotDrawing
    from jtik.study.figures.style import panels

    robot, q0 = problem.ik.robot, problem.options["q0"]
    start = robot.home if q0 is None else robot.configuration(q0, argument="q0")
    iterations = start if solution.restarts or solution.trace is None else solution.trace.q
    q = np.vstack([iterations, solution.q])
    obstacles = [each for each in problem.obstacles if isinstance(each, Ball)]
    drawing = RobotDrawing(robot, [q], obstacles)
    figure, axes = panels(1, 1, width=7.0, height=6.0, **drawing.projection)
    drawing.draw(axes[0, 0], q, f"{robot.name}: {solution.status.name}")
    return figure


def json_value(value: Any) -> Any:
    """The value as JSON has it. Numbers that are not finite become null."""
    if isinstance(value, Mapping):
        return {str(key): json_value(item) for key, item in value.items()}
    if isinstance(value, np.ndarray):
        return json_value(value.tolist())
    if isinstance(value, np.generic):
        return json_value(value.item())
    if isinstance(value, (list, tuple)):
        return [json_value(item) for item in value]
    if isinstance(value, Solution):
        return {"q": json_value(value.q), "status": value.status.name, "cost": json_value(value.cost)}
    if isinstance(value, Enum):
        return value.name
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value if value is None or isinstance(value, (bool, int, str)) else repr(value)
