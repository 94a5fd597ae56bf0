"""Performance profiles: share of cases solved within a factor of the best contender (Dolan and More 2002)."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal, TypeAlias

import numpy as np

from jtik.errors import ArgumentError
from jtik.plotting import Figure
from jtik.study.figures.selection import chosen_contenders, chosen_criteria
from jtik.study.figures.style import label, legend, lines, panels
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison

ProfileMeasure: TypeAlias = Literal["seconds", "iterations"]

WIDEST = 1e3
"""Largest factor that is drawn."""


def ratios(comparison: Comparison, measure: ProfileMeasure, criteria: str, names: tuple[str, ...]) -> dict[str, Array]:
    """Ratio to the best contender of each case, (cases,), by contender; infinite for a failure."""
    columns, cases = comparison.columns, {case.name: k for k, case in enumerate(comparison.problems)}
    table = np.full((len(names), len(cases)), np.inf)
    for i, name in enumerate(names):
        rows = comparison.rows(contender=name, criteria=criteria)
        good = rows[columns["success"][rows] & (columns[measure][rows] >= 0)]
        indices = [cases[case] for case in columns["case"][good].tolist()]
        # a solve that starts on target needs no iteration; it counts as one, so that the ratio is defined
        table[i, indices] = np.maximum(columns[measure][good], 1 if measure == "iterations" else 1e-9)
    best = table.min(axis=0)
    table[:, np.isfinite(best)] /= best[np.isfinite(best)]
    return dict(zip(names, table, strict=True))


def profile(
    comparison: Comparison,
    *,
    measure: ProfileMeasure = "seconds",
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
) -> Figure:
    """Plot the share of cases solved within a factor of the fastest contender.

    The value at 1 is the share of cases on which a contender is best. The rightmost value is the share that it solves.

    Args:
        comparison: the results of a study.
        measure: "seconds" or "iterations".
        contenders: names of the contenders; all by default.
        criteria: name of the criteria; the first by default.

    Raises:
        ArgumentError: for any other measure.
        UnknownNameError: for an unknown contender or criteria.
    """
    if measure not in ("seconds", "iterations"):
        raise ArgumentError("measure", measure, "'seconds' or 'iterations'")
    names = chosen_contenders(comparison, contenders)
    found = ratios(comparison, measure, chosen_criteria(comparison, criteria), names)
    finite = [value for each in found.values() for value in each[np.isfinite(each)]]
    widest = min(WIDEST, 1.3 * max(finite, default=1.0))
    figure, table = panels(1, 1, width=6.4, height=4.0)
    axes, style = table[0, 0], lines(comparison.contenders)
    for name, each in found.items():
        steps = np.sort(each[np.isfinite(each)])
        share = np.arange(1, len(steps) + 1) / len(each)
        x, y = (
            np.concatenate([[1.0], steps, [max(widest, 1.0)]]),
            np.concatenate([[0.0], share, share[-1:] if len(share) else [0.0]]),
        )
        axes.step(x, 100 * y, where="post", label=name, **style[name])
    axes.set(xscale="log", xlim=(1, max(widest, 1.1)), ylim=(-2, 102))
    what = "time" if measure == "seconds" else "iterations"
    label(axes, f"{what} relative to the best contender of the same case", "cases solved within this factor [%]")
    legend(figure, axes)
    return figure
