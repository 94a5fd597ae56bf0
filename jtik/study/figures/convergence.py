"""Task error by iteration."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from jtik.plotting import MUTED, Figure
from jtik.study.figures.selection import chosen_contenders, chosen_criteria, recorded_cases
from jtik.study.figures.style import FLOOR, label, legend, lines, padded, panels

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison


LONG = 60
"""Number of iterations above which the axis is logarithmic beyond ten: some strategies need ten times as many."""


def convergence(
    comparison: Comparison,
    *,
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
    kind: str | None = None,
) -> Figure:
    """Plot the task error by iteration for each kind: the median over the recorded cases, and the interquartile range.

    A solve that has ended keeps its last error, so that the median extends to the longest solve.

    Args:
        comparison: the results of a study.
        contenders: names of the contenders; all by default.
        criteria: name of the criteria; the first by default.
        kind: kind of the cases; all kinds by default.

    Raises:
        ArgumentError: if nothing was recorded.
        UnknownNameError: for an unknown contender, criteria or kind.
    """
    criteria, names = chosen_criteria(comparison, criteria), chosen_contenders(comparison, contenders)
    every = recorded_cases(comparison, kind)
    cases = {case.name: case.kind for case in comparison.problems if case.name in every}
    kinds = [each for each in dict.fromkeys(cases.values()) if _has(comparison, cases, each)] or [
        next(iter(cases.values()))
    ]
    figure, table = panels(1, len(kinds), sharey=True)
    style = lines(comparison.contenders)
    for axes, each in zip(table[0], kinds, strict=True):
        longest = 1
        for name in names:
            keys = [(name, criteria, case) for case, of in cases.items() if of == each]
            errors = [np.maximum(comparison.traces[key].error, FLOOR) for key in keys if key in comparison.traces]
            if not errors:
                continue
            rows = padded(errors)
            k = np.arange(rows.shape[1])
            axes.plot(k, np.median(rows, axis=0), label=name, **style[name])
            if len(rows) > 1:
                low, high = np.percentile(rows, [25, 75], axis=0)
                axes.fill_between(k, low, high, color=style[name]["color"], alpha=0.12, linewidth=0)
            longest = max(longest, int(np.median([len(error) for error in errors])))
        axes.set(yscale="log", xlim=(0, 1.05 * longest), ylim=(1e-10, None))
        if longest > LONG:
            axes.set_xscale("symlog", linthresh=10)
            axes.set_xticks([k for k in (0, 5, 10, 100, 1000, 10000) if k <= longest])
            axes.xaxis.set_major_formatter("{x:g}")
        tolerance = comparison.settings.get("position_tolerance")
        if tolerance:
            axes.axhline(tolerance, color=MUTED, linewidth=0.8, linestyle=":")
        label(axes, "iteration", "task error [m, rad]", each.replace("_", " "))
    for axes in table[0, 1:]:
        axes.set_ylabel("")
    legend(figure, max(table[0], key=lambda axes: len(axes.get_lines())))
    return figure


def _has(comparison: Comparison, cases: dict[str, str], kind: str) -> bool:
    return any(cases.get(case) == kind for _, _, case in comparison.traces)
