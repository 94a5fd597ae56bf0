"""What the figures of a study share: paper, colours that colour-blind readers tell apart, and choosing what to draw."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from jtik.errors import ArgumentError, UnknownNameError
from jtik.plotting.planar import BACKGROUND, INK, MUTED, THIN, Axes, Figure, new_figure
from jtik.result.solution import Trace
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison

COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", INK)
"""Okabe and Ito (2008) without yellow, which is lost on white."""

DASHES = ("-", (0, (5, 2)), (0, (1.2, 1.6)), (0, (6, 1.5, 1.2, 1.5)))
"""What tells apart lines of the same colour, and all of them on a copy in grey."""

FLOOR = 1e-17
"""Logarithmic axes draw a zero here."""


class Chosen(NamedTuple):
    """Which case of which criteria a figure shows."""

    criteria: str
    case: str


def panels(rows: int, columns: int, *, width: float = 4.6, height: float = 3.4, **options: Any) -> tuple[Figure, Any]:
    """A figure and an array of axes (rows, columns), with a light grid.

    Args:
        rows, columns: how many axes.
        width, height: of each [inch].
        options: of matplotlib's ``Figure.subplots``.

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
    """Colour and dashes of each name, by its place."""
    return {
        name: {"color": COLORS[i % len(COLORS)], "linestyle": DASHES[i // len(COLORS) % len(DASHES)], "linewidth": 1.7}
        for i, name in enumerate(names)
    }


def label(axes: Axes, x: str, y: str, title: str = "") -> None:
    """What the axes are, with units."""
    axes.set_xlabel(x, color=INK, fontsize=10)
    axes.set_ylabel(y, color=INK, fontsize=10)
    if title:
        axes.set_title(title, color=INK, fontsize=10.5, loc="left")


def legend(figure: Figure, axes: Axes) -> None:
    """To the right of everything, where it hides nothing."""
    handles, labels = axes.get_legend_handles_labels()
    if handles:
        figure.legend(handles, labels, loc="outside right upper", frameon=False, fontsize=9, labelcolor=INK)


def who(comparison: Comparison, contenders: Iterable[str] | None) -> tuple[str, ...]:
    """The contenders to draw, all by default. Raises UnknownNameError for one that took no part."""
    if contenders is None:
        return comparison.contenders
    names = (contenders,) if isinstance(contenders, str) else tuple(contenders)
    for name in names:
        if name not in comparison.contenders:
            raise UnknownNameError("contender", name, comparison.contenders)
    return names


def which(comparison: Comparison, criteria: str | None) -> str:
    """The label of the criteria to draw, the first by default. Raises UnknownNameError for another."""
    if criteria is None:
        return comparison.criteria[0]
    if criteria not in comparison.criteria:
        raise UnknownNameError("criteria", criteria, comparison.criteria)
    return criteria


def kept(comparison: Comparison, kind: str | None = None) -> list[str]:
    """Names of the cases whose iterations or postures the study kept, perhaps of one kind.

    Raises:
        UnknownNameError: for a kind that the study has not.
        ArgumentError: when there are none.
    """
    if kind is not None and kind not in comparison.problems.kinds:
        raise UnknownNameError("kind", kind, comparison.problems.kinds)
    seen = {case for _, _, case in [*comparison.traces, *comparison.paths]}
    names = [case.name for case in comparison.problems if case.name in seen and kind in (None, case.kind)]
    if not names:
        raise ArgumentError("traces", "none kept", "a study with compare(..., traces=1) or more")
    return names


def chosen(comparison: Comparison, criteria: str | None, case: str | None) -> Chosen:
    """One case, the first that was kept by default. Raises UnknownNameError for one that was not."""
    names = kept(comparison)
    if case is not None and case not in names:
        raise UnknownNameError("case", case, names)
    return Chosen(which(comparison, criteria), case or names[0])


def of_case(comparison: Comparison, at: Chosen, contenders: Iterable[str] | None) -> dict[str, Trace]:
    """The iterations on a case, of the contenders that have them. Raises ArgumentError when none has."""
    keys = {name: (name, at.criteria, at.case) for name in who(comparison, contenders)}
    found = {name: comparison.traces[key] for name, key in keys.items() if key in comparison.traces}
    if not found:
        raise ArgumentError("case", at.case, "a case of one target, solved by strategies that tell their iterations")
    return found


def postures(comparison: Comparison, key: tuple[str, str, str]) -> Array | None:
    """Configurations along a path, or from the start to the answer, (k, nq); None where they were not kept."""
    if key in comparison.paths:
        return np.asarray(comparison.paths[key])
    trace = comparison.traces.get(key)
    return None if trace is None else np.asarray(trace.q)


def stretched(series: Sequence[Array]) -> Array:
    """Series as rows of one table, the shorter ones staying at their last entry."""
    length = max(len(each) for each in series)
    return np.array([np.append(each, np.full(length - len(each), each[-1])) for each in series])


def grid(count: int, widest: int = 4) -> tuple[int, int]:
    """Rows and columns for so many panels."""
    columns = min(count, widest)
    return math.ceil(count / columns), columns
