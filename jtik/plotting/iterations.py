"""A figure of a Trace: what falls from iteration to iteration."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from jtik.arguments import instance, positive_number
from jtik.errors import ArgumentError
from jtik.plotting.curves import decimal_axes, panels_above_each_other
from jtik.plotting.figure import Axes, Figure
from jtik.plotting.style import COLORS, INK, MUTED
from jtik.result import Trace
from jtik.types import Array

FLOOR = 1e-17
"""Value at which logarithmic axes draw zero."""


def trace_figure(trace: Trace, *, width: float = 6.0) -> Figure:
    """Task error, criterion and null-space residual of a solve by iteration.

    Grey lines mark where another attempt began, crosses the steps that were refused.

    Args:
        trace: the trace, of at least one iteration.
        width: width of the figure [inch].

    Raises:
        ArgumentError: for a trace without an iteration.
        MissingExtraError: when matplotlib is not installed.
    """
    instance("trace", trace, Trace, "a jtik.Trace")
    if not len(trace):
        raise ArgumentError("trace", "no iteration", "a trace of at least one iteration")
    H = trace.figures.get("H")
    has_criterion = H is not None and bool(np.any(H != 0))
    figure, table = panels_above_each_other(3 if has_criterion else 1, positive_number("width", width), "iteration")
    _draw(table[0], trace, trace.error, "task error\n[m, rad]", COLORS[0], logarithmic=True)
    if has_criterion and H is not None:
        _draw(table[1], trace, H, "criterion H", COLORS[1], logarithmic=False)
        residual = trace.figures.get("null_residual", np.full(len(trace), np.nan))
        _draw(table[2], trace, residual, "null-space\nresidual", COLORS[2], logarithmic=True)
    table[-1].set_xlim(0, len(trace))
    return figure


def _draw(axes: Axes, trace: Trace, values: Array, label: str, color: str, *, logarithmic: bool) -> None:
    values = np.maximum(values, FLOOR) if logarithmic else values
    attempt = trace.figures.get("attempt", np.zeros(len(trace)))
    begins = [0, *(np.flatnonzero(np.diff(attempt)) + 1), len(values)]
    for first, end in pairwise(begins):  # no line from one attempt to the next
        axes.plot(np.arange(first, end), values[first:end], color=color, linewidth=1.4)
    for first in begins[1:-1]:
        axes.axvline(first - 0.5, color=MUTED, linewidth=0.8, linestyle=":")
    refused = np.flatnonzero(trace.figures.get("accepted", np.ones(len(trace))) == 0)
    axes.plot(refused, values[refused], "x", color=color, markersize=4.5)
    if logarithmic:
        axes.set_yscale("log")
        decimal_axes(axes)
    axes.set_ylabel(label, color=INK, fontsize=9)
