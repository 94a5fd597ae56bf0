"""The arm of one case, contender by contender."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from jtik.errors import ArgumentError
from jtik.plotting.planar import Figure
from jtik.problems import Case
from jtik.study.figures.canvas import Chosen, chosen, grid, panels, postures, who
from jtik.study.figures.scenery import Scenery, balls
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison


def posture_panels(
    comparison: Comparison,
    *,
    case: str | None = None,
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
) -> Figure:
    """The way of the arm, from light (start) to dark (answer), a panel a contender; the line is the way of its tip."""
    at = chosen(comparison, criteria, case)
    found = ways(comparison, at, contenders)
    scene = Scenery(comparison.robot, list(found.values()), balls(one(comparison, at.case)))
    rows, columns = grid(len(found))
    figure, table = panels(rows, columns, width=3.4, height=3.1, **scene.projection)
    for axes, (name, q) in zip(table.flat, found.items(), strict=False):
        scene.draw(axes, q, name)
    for axes in table.flat[len(found) :]:
        axes.remove()
    figure.suptitle(at.case, fontsize=11, x=0.01, ha="left")
    return figure


def ways(comparison: Comparison, at: Chosen, contenders: Iterable[str] | None) -> dict[str, Array]:
    """Configurations of each contender on a case, (k, nq). Raises ArgumentError when none were kept."""
    pairs = ((name, postures(comparison, (name, *at))) for name in who(comparison, contenders))
    found = {name: q for name, q in pairs if q is not None}
    if not found:
        raise ArgumentError("case", at.case, "a case whose postures were kept: compare(..., traces=)")
    return found


def one(comparison: Comparison, name: str) -> Case:
    """The case of that name."""
    return next(case for case in comparison.problems if case.name == name)
