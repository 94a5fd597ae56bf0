"""The criterion H by iteration, and its final values."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from jtik.errors import ArgumentError
from jtik.plotting import INK, MUTED, Figure
from jtik.study.figures.selection import choose_case, chosen_contenders, traces_of_case
from jtik.study.figures.style import label, legend, lines, panels

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison

SMALLEST = 1e-12
"""Smaller regret is drawn at this value, because it is rounding."""


def criteria(
    comparison: Comparison,
    *,
    case: str | None = None,
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
) -> Figure:
    """Plot H by iteration for one case (left), and the regret of each contender on all cases (right).

    Of a solve with restarts the attempt that led to the answer is drawn.

    Args:
        comparison: the results of a study.
        case: name of a recorded case; the first by default.
        contenders: names of the contenders; all by default.
        criteria: name of the criteria; the first by default.

    Raises:
        ArgumentError: if nothing was recorded, or no case was solved.
        UnknownNameError: for an unknown case, contender or criteria.
    """
    at = choose_case(comparison, criteria, case)
    names = chosen_contenders(comparison, contenders)
    regrets = {name: _regret(comparison, name, at.criteria) for name in names}
    if not any(len(each) for each in regrets.values()):
        raise ArgumentError("criteria", at.criteria, "criteria of a study in which a contender solved a case")
    figure, table = panels(1, 2, width=5.2, height=3.9)
    style = lines(comparison.contenders)
    left, right = table[0]
    for name, trace in traces_of_case(comparison, at, names).items():
        H = trace.figures.get("H")
        if H is not None and len(H):
            own = H[trace.answer_rows]
            left.plot(np.arange(len(own)), own, label=name, **style[name])
    label(left, "iteration", "criterion H", at.case)
    for index, (name, each) in enumerate(regrets.items()):
        if not len(each):
            continue
        value, color = np.maximum(each, SMALLEST), style[name]["color"]
        spread = np.linspace(-0.16, 0.16, len(value)) if len(value) > 1 else np.zeros(1)
        right.plot(value, index + spread, ".", color=color, markersize=6, alpha=0.6, markeredgewidth=0)
        right.plot(np.median(value), index, "|", color=INK, markersize=16, markeredgewidth=2)
    right.set(xscale="log", yticks=range(len(names)), ylim=(len(names) - 0.5, -0.5))
    right.set_yticklabels(names, color=MUTED)
    label(right, f"regret: H minus the best H of the case (at least {SMALLEST:g})", "", "solved cases, with the median")
    legend(figure, left)
    return figure


def _regret(comparison: Comparison, name: str, criteria: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    values = comparison.columns["regret"][comparison.rows(contender=name, criteria=criteria)].astype(np.float64)
    return np.sort(values[~np.isnan(values)])
