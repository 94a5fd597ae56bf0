"""Style of the figures of a study: axes, labels, and colours that colour-blind readers can distinguish."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from jtik.plotting import BACKGROUND, COLORS, INK, MUTED, THIN, Axes, Figure, new_figure
from jtik.types import Array

DASHES = ("-", (0, (5, 2)), (0, (1.2, 1.6)), (0, (6, 1.5, 1.2, 1.5)))
"""Line styles that distinguish lines of the same colour."""

FLOOR = 1e-17
"""Value at which logarithmic axes draw zero."""


def panels(rows: int, columns: int, *, width: float = 4.6, height: float = 3.4, **options: Any) -> tuple[Figure, Any]:
    """A figure and an array of axes (rows, columns), with a light grid.

    Args:
        rows: number of rows.
        columns: number of columns.
        width: width of each axes [inch].
        height: height of each axes [inch].
        options: options of matplotlib's ``Figure.subplots``.

    Raises:
        MissingExtraError: without matplotlib.
    """
    figure = new_figure((width * columns, height * rows), layout="constrained")
    table = figure.subplots(rows, columns, squeeze=False, **options)
    for axes in table.flat:
        axes.set_facecolor(BACKGROUND)
        axes.grid(True, color=THIN, linewidth=0.5, alpha=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(color=THIN, labelcolor=MUTED, labelsize=9)
        for spine in axes.spines.values():
            spine.set(color=THIN)
    return figure, table


def lines(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Colour and line style of each name, by its index."""
    return {
        name: {"color": COLORS[i % len(COLORS)], "linestyle": DASHES[i // len(COLORS) % len(DASHES)], "linewidth": 1.7}
        for i, name in enumerate(names)
    }


def label(axes: Axes, x: str, y: str, title: str = "") -> None:
    """Set axis labels with units, and the title."""
    axes.set_xlabel(x, color=INK, fontsize=10)
    axes.set_ylabel(y, color=INK, fontsize=10)
    if title:
        axes.set_title(title, color=INK, fontsize=10.5, loc="left")


def legend(figure: Figure, axes: Axes) -> None:
    """Add a legend to the right of all axes."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside right upper", frameon=False, fontsize=9, labelcolor=INK)


def padded(series: Sequence[Array]) -> Array:
    """Series as rows of one array; shorter series repeat their last value."""
    length = max(len(each) for each in series)
    return np.array([np.append(each, np.full(length - len(each), each[-1])) for each in series])


def grid(count: int, widest: int = 4) -> tuple[int, int]:
    """Rows and columns for a number of panels."""
    columns = min(count, widest)
    return math.ceil(count / columns), columns
