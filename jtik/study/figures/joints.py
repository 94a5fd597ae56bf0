"""Joint positions along a solve or a path, with joint limits."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from jtik.plotting import MUTED, Figure, shades
from jtik.study.figures.selection import case_named, choose_case, configurations_of
from jtik.study.figures.style import grid, label, legend, panels

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison


def joint_panels(
    comparison: Comparison,
    *,
    case: str | None = None,
    contenders: Iterable[str] | None = None,
    criteria: str | None = None,
) -> Figure:
    """Plot q by iteration, or by time along a path, in one panel for each contender. Nearby limits are dotted lines.

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
    found, own_case, robot = (
        configurations_of(comparison, at, contenders),
        case_named(comparison, at.case),
        comparison.robot,
    )
    rows, columns = grid(len(found), 3)
    figure, table = panels(rows, columns, width=4.0, height=3.0, sharey=True)
    names = [
        name if length == 1 else f"{name}[{k}]"
        for name in robot.joint_names
        for length in [robot.q_slice(name).stop - robot.q_slice(name).start]
        for k in range(length)
    ]
    along = own_case.is_path and own_case.dt
    spans = [(float(q.min()), float(q.max())) for q in found.values()]
    low, high = min(each[0] for each in spans), max(each[1] for each in spans)
    margin = 0.08 * max(high - low, 1e-3)
    for axes, (contender, q) in zip(table.flat, found.items(), strict=False):
        x = np.arange(len(q)) * (along or 1)
        for k, (name, color) in enumerate(zip(names, shades(len(names), "viridis"), strict=True)):
            axes.plot(x, q[:, k], color=color, linewidth=1.3, label=name)
            for limit in (robot.lower[k], robot.upper[k]):
                if low - margin < limit < high + margin:
                    axes.axhline(limit, color=color, linewidth=0.8, linestyle=":")
        axes.set_ylim(low - margin, high + margin)
        label(axes, "time [s]" if along else "iteration", "", contender)
    unit = "[rad]" if robot.rotational.all() else "[rad, m]"
    for axes in table[:, 0]:
        axes.set_ylabel(f"joint position {unit}", fontsize=10)
    for axes in table.flat[len(found) :]:
        axes.remove()
    figure.suptitle(at.case, fontsize=11, x=0.01, ha="left", color=MUTED)
    legend(figure, table.flat[0])
    return figure
