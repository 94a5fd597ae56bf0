"""Panels of curves above each other, with one horizontal axis."""

from __future__ import annotations

from typing import Any

from jtik.plotting.figure import Axes, Figure, new_figure
from jtik.plotting.style import BACKGROUND, INK, MUTED, THIN

PANEL = 1.55
"""Height of a panel [inch]."""


def panels_above_each_other(count: int, width: float, label: str) -> tuple[Figure, Any]:
    """A figure and the axes of its panels, from the top.

    Args:
        count: number of panels.
        width: width of the figure [inch].
        label: label of the horizontal axis.
    """
    figure = new_figure((width, PANEL * count + 0.35), layout="constrained")
    table = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
    for axes in table:
        axes.set_facecolor(BACKGROUND)
        axes.grid(True, color=THIN, linewidth=0.5, alpha=0.6)
        axes.set_axisbelow(True)
        axes.tick_params(color=THIN, labelcolor=MUTED, labelsize=8)
        for spine in axes.spines.values():
            spine.set(color=THIN)
    table[-1].set_xlabel(label, color=INK, fontsize=9)
    figure.align_ylabels(table)
    return figure, table


def decimal_axes(axes: Axes) -> None:
    """Few ticks on a logarithmic axis, at powers of ten."""
    from matplotlib.ticker import LogLocator

    axes.yaxis.set_major_locator(LogLocator(numticks=5))
    axes.minorticks_off()
