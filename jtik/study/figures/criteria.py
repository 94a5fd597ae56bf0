"""The criterion: as it falls, and what is left of it at the end."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from jtik.errors import ArgumentError
from jtik.plotting.planar import INK, MUTED, Figure
from jtik.study.figures.selection import choose_case, chosen_contenders, traces_of_case
from jtik.study.figures.style import label, legend, lines, panels

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison

LEAST = 1e-12
"""Regret below this is drawn as this: what is left is rounding."""


def criteria(
    comparison: Comparison,
    *,
    case: str | None = None,
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
) -> Figure:
    """Left H by iteration of one case, right for every contender how far above the best it ended, case by case."""
    at = choose_case(comparison, criteria, case)
    names = chosen_contenders(comparison, contenders)
    regrets = {name: _regret(comparison, name, at.criteria) for name in names}
    if not any(len(each) for each in regrets.values()):
        raise ArgumentError("criteria", at.criteria, "criteria: this study has none, or nobody solved a case")
    figure, table = panels(1, 2, width=5.2, height=3.9)
    style = lines(comparison.contenders)
    left, right = table[0]
    for name, trace in traces_of_case(comparison, at, names).items():
        H = trace.figures.get("H")
        if H is not None and len(H):
            left.plot(np.arange(len(H)), H, label=name, **style[name])
    label(left, "iteration", "criterion H", at.case)
    for place, (name, each) in enumerate(regrets.items()):
        if not len(each):
            continue
        value, color = np.maximum(each, LEAST), style[name]["color"]
        spread = np.linspace(-0.16, 0.16, len(value)) if len(value) > 1 else np.zeros(1)
        right.plot(value, place + spread, ".", color=color, markersize=6, alpha=0.6, markeredgewidth=0)
        right.plot(np.median(value), place, "|", color=INK, markersize=16, markeredgewidth=2)
    right.set(xscale="log", yticks=range(len(names)), ylim=(len(names) - 0.5, -0.5))
    right.set_yticklabels(names, color=MUTED)
    label(right, f"H less the best of its case (at least {LEAST:g})", "", "solved cases and their median")
    legend(figure, left)
    return figure


def _regret(comparison: Comparison, name: str, criteria: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    values = comparison.columns["regret"][comparison.rows(contender=name, criteria=criteria)].astype(np.float64)
    return np.sort(values[~np.isnan(values)])
