"""A comparison in the viewer: all contenders on one case, overlaid, with a menu of the cases."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from jtik.study.figures.selection import Selection, choose_case, configurations_of, obstacles_of_case, recorded_cases
from jtik.viewer.subjects import Subject
from jtik.viewer.viewer import Viewer

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison

RATE = 5.0
"""Iterations, or targets of a path, for each second of a motion."""


def view_comparison(comparison: Comparison, obstacles: tuple[Any, ...], **options: Any) -> Viewer:
    """The viewer of a comparison: the way of each contender from the start to its answer, or along the path.

    Args:
        comparison: the results of a study.
        obstacles: the obstacles, in place of those of the study.
        options: show, port and height of the viewer.

    Raises:
        ArgumentError: when nothing was recorded.
    """
    first = choose_case(comparison, None, None)

    def shown(at: Selection) -> tuple[list[Subject], tuple[Any, ...]]:
        found = configurations_of(comparison, at, None)
        subjects = [Subject(name, comparison.robot, q, np.arange(len(q), dtype=float)) for name, q in found.items()]
        return subjects, obstacles or obstacles_of_case(comparison, at)

    viewer = Viewer(*shown(first), unit="iteration or target", rate=RATE, title="jtik compare", **options)
    gui = viewer.gui
    case = gui.add_dropdown("case", tuple(recorded_cases(comparison)), initial_value=first.case)
    criteria = gui.add_dropdown("criteria", comparison.criteria, initial_value=first.criteria)
    criteria.visible = len(comparison.criteria) > 1

    def change(_: Any) -> None:
        viewer.replace(*shown(Selection(criteria.value, case.value)))

    case.on_update(change)
    criteria.on_update(change)
    return viewer
