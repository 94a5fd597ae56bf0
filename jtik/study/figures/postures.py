"""Configurations of the robot on one case, for each contender."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from jtik.plotting import INK, Axes, Figure
from jtik.plotting.spatial import fit
from jtik.study.figures.robot_drawing import RobotDrawing
from jtik.study.figures.selection import choose_case, configurations_of, obstacles_of_case
from jtik.study.figures.style import grid, panels

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison


TITLE = 0.25
"""Height of a title [inch]."""


def posture_panels(
    comparison: Comparison,
    *,
    case: str | None = None,
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
) -> Figure:
    """Plot the robot from start (light) to answer (dark) with the end-effector path, one panel for each contender.

    Args:
        comparison: the results of a study.
        case: name of a recorded case; the first by default.
        contenders: names of the contenders; all by default.
        criteria: name of the criteria; the first by default.

    Raises:
        ArgumentError: if nothing was recorded.
        UnknownNameError: for an unknown case, contender or criteria.
    """
    at = choose_case(comparison, criteria, case)
    found = configurations_of(comparison, at, contenders)
    scene = RobotDrawing(comparison.robot, list(found.values()), obstacles_of_case(comparison, at))
    rows, columns = grid(len(found))
    figure, table = panels(rows, columns, width=3.4, height=3.1, **scene.projection)
    for axes, (name, q) in zip(table.flat, found.items(), strict=False):
        scene.draw(axes, q, name)
    for axes in table.flat[len(found) :]:
        axes.remove()
    figure.suptitle(at.case, fontsize=11, x=0.01, ha="left")
    if not scene.is_planar:
        _arrange(figure, list(table.flat[: len(found)]), list(found), columns)
    return figure


def _arrange(figure: Figure, panels: list[Axes], titles: list[str], columns: int) -> None:
    """Fill the figure with panels of 3-D axes, for which matplotlib's layout leaves half of it empty."""
    figure.set_layout_engine("none")
    width, height = figure.get_size_inches()
    rows = -(-len(panels) // columns)
    across, up = width / columns, (height - TITLE) / rows
    for k, (axes, title) in enumerate(zip(panels, titles, strict=True)):
        left, top = k % columns * across, height - TITLE - k // columns * up
        axes.set_title("", loc="left")
        figure.text((left + 0.1) / width, (top - 0.05) / height, title, color=INK, fontsize=10.5, va="top")
        fit(figure, axes, (left, top - up, across, up - TITLE))
