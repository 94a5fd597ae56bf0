"""The Lyapunov function V by iteration."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from jtik.errors import ArgumentError
from jtik.plotting import Figure
from jtik.study.figures.selection import choose_case, traces_of_case
from jtik.study.figures.style import FLOOR, label, legend, lines, panels

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison


def lyapunov(
    comparison: Comparison,
    *,
    case: str | None = None,
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
) -> Figure:
    """Plot V = 1/2 e' Kp e for one case, the first recorded one by default. Circles mark iterations at which V rose.

    Of a solve with restarts the attempt that led to the answer is drawn.

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
    traces = traces_of_case(comparison, at, contenders)
    figure, table = panels(1, 1, width=6.4, height=4.0)
    axes, style = table[0, 0], lines(comparison.contenders)
    drawn = 0
    for name, trace in traces.items():
        V = trace.figures.get("V")
        if V is None or not len(V):
            continue
        drawn += 1
        V = np.maximum(V[trace.answer_rows], FLOOR)
        axes.plot(np.arange(len(V)), V, label=name, **style[name])
        rises = np.flatnonzero(V[1:] > V[:-1] * (1 + 1e-12)) + 1
        rises = rises[V[rises] > 1e-14]  # below this, a rise is rounding on target
        axes.plot(rises, V[rises], "o", color=style[name]["color"], markersize=5, markerfacecolor="none")
    if not drawn:
        raise ArgumentError("case", at.case, "a case that a strategy of jtik solved in at least one iteration")
    axes.set(yscale="log")
    label(axes, "iteration", "V = ½ e'Kp e [m², rad²]", f"{at.case}; circles where V rose")
    legend(figure, axes)
    return figure
