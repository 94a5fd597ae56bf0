"""Animation of the robot along a solve or a path."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from jtik.errors import ArgumentError
from jtik.plotting import write_animation
from jtik.study.figures.robot_drawing import RobotDrawing
from jtik.study.figures.selection import choose_case, chosen_contenders, configurations_of, obstacles_of_case
from jtik.study.figures.style import panels
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison

FRAMES = 60
"""Minimum number of frames."""


def animation(
    comparison: Comparison,
    path: str | Path,
    *,
    contender: str | None = None,
    case: str | None = None,
    criteria: str | None = None,
) -> None:
    """Write a GIF of one contender on one case, interpolated between iterations in joint space.

    Args:
        comparison: the study.
        path: the file, which ends in .gif.
        contender: label of the contender; the first by default.
        case: name of the case; the first with a trace by default.
        criteria: label of the criteria; the first by default.

    Raises:
        ArgumentError: for another suffix, or if nothing was recorded.
        UnknownNameError: for an unknown name.
    """
    if Path(path).suffix.lower() != ".gif":
        raise ArgumentError("path", path, "a file that ends in .gif")
    at = choose_case(comparison, criteria, case)
    name = chosen_contenders(comparison, None if contender is None else [contender])[0]
    q = _smooth(comparison, configurations_of(comparison, at, [name])[name])
    scene = RobotDrawing(comparison.robot, [q], obstacles_of_case(comparison, at))
    figure, table = panels(1, 1, width=5.0, height=4.6, **scene.projection)
    axes = table[0, 0]

    def draw(k: int) -> None:
        axes.clear()
        scene.draw(axes, q[k : k + 1], f"{name}: {at.case}", path=q)

    draw(0)
    figure.canvas.draw()
    figure.set_layout_engine("none")  # the layout is computed once, because it is slow
    write_animation(path, figure, draw, len(q))


def _smooth(comparison: Comparison, q: Array) -> Array:
    """The same motion with more configurations, if there are few."""
    each = max(1, FRAMES // max(1, len(q) - 1))
    robot, frames = comparison.robot, [q[0]]
    for start, end in pairwise(q):
        displacement = robot.difference(start, end)
        frames += [robot.integrate(start, k / each * displacement) for k in range(1, each + 1)]
    return np.array(frames)
