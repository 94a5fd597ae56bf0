"""Draw the figures of docs/performance.md from benchmarks/README.md and from what the benchmarks have recorded.

python docs/performance_picture.py
"""

from __future__ import annotations

import re
from pathlib import Path

from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter, StrMethodFormatter
from performance_tables import LIBRARIES, PROBLEMS, SWEEPS, recorded, steps

ROOT = Path(__file__).parents[1]
ROWS = {
    "jtik": "jtik, C",
    "jtik batch": "jtik, C, batch",
    "jtik hybrid": "jtik hybrid, C",
    "jtik machine": "jtik, virtual machine",
    "rtb": "Robotics Toolbox (C++)",
    "optik": "optik (Rust)",
    "mink": "mink, loop",
    "pink": "pink, loop",
}
"""Rows of the table, and what the picture calls them."""


def means(column: int) -> dict[str, float]:
    """The mean times of an arm [µs], by row."""
    text = (ROOT / "benchmarks" / "README.md").read_text(encoding="utf-8")
    table = text[text.index("| median / mean [us] |") :].split("\n\n")[0]
    found = {}
    for line in table.splitlines()[2:]:
        name, *cells = (cell.strip() for cell in line.strip("|").split("|"))
        if name in ROWS and (figures := re.match(r"[\d.]+ / ([\d.]+)", cells[column])):
            found[ROWS[name]] = float(figures[1])
    return found


def draw(path: Path) -> None:
    """Write the picture."""
    panda, ur5 = means(0), means(2)
    names = list(panda)[::-1]
    figure = Figure(figsize=(7, 3.4), layout="constrained")
    axes = figure.subplots()
    for offset, label, times, color in ((0.2, "Panda", panda, "#1f4e79"), (-0.2, "UR5", ur5, "#9dbbd6")):
        places = [index + offset for index in range(len(names))]
        axes.barh(places, [times[name] for name in names], height=0.38, color=color, label=label)
    for index, name in enumerate(names):
        axes.text(panda[name] * 1.06, index + 0.2, f"{panda[name]:.0f}", va="center", fontsize=8)
    axes.set_yticks(range(len(names)), names)
    axes.set_xscale("log")
    axes.set_xlim(min(*panda.values(), *ur5.values()) / 2, 4 * max(*panda.values(), *ur5.values()))
    axes.set_xlabel("mean time to a pose [µs], 1e-5 m and rad")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


def draw_steps(path: Path) -> None:
    """Write the picture of cold steps."""
    rows, colors = steps(), ("#1f4e79", "#4f81b0", "#c55a11", "#8c8c8c", "#cfcfcf")
    problems = list(PROBLEMS)[::-1]
    figure = Figure(figsize=(7, 3.2), layout="constrained")
    axes = figure.subplots()
    for k, (name, color) in enumerate(zip(LIBRARIES, colors, strict=True)):
        found = [(place + 0.32 - 0.16 * k, rows.get((problem, name, "cold"))) for place, problem in enumerate(problems)]
        times = {height: row["microseconds"][0] for height, row in found if row}
        axes.barh(list(times), list(times.values()), height=0.15, color=color, label=LIBRARIES[name].strip("`"))
        for height, time in times.items():
            axes.text(time * 1.05, height, f"{time:.0f}", va="center", fontsize=7)
    axes.set_yticks(range(len(problems)), [PROBLEMS[problem].replace(", ", ",\n") for problem in problems])
    axes.set_xscale("log")
    axes.set_xlim(5, 3000)
    axes.set_xlabel("time of a step with cold caches [µs]")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, fontsize=7, loc="upper right")
    figure.savefig(path, dpi=110)


def draw_growth(path: Path) -> None:
    """Write the picture of growth: one line a sweep, those that may be quadratic dashed."""
    run = recorded("growth")
    figure = Figure(figsize=(7, 5.6), layout="constrained")
    colors = ("#1f4e79", "#c55a11", "#4f81b0", "#8c8c8c", "#000000", "#2e7d32", "#7b3fa0", "#d4a017")
    for axes, (name, unit) in zip(figure.subplots(2, 2).flat, run["units"].items(), strict=True):
        for row, color in zip(run["rows"], colors, strict=True):
            known = [(size, value) for size, value in zip(row["sizes"], row["figures"][name], strict=True) if size]
            label = f"{SWEEPS.get(row['what'], row['what'])}, {row['strategy']}"
            line = "-" if row["bound"] == 1 else "--"
            axes.plot(*zip(*known, strict=True), line, color=color, marker="o", markersize=3, linewidth=1, label=label)
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(f"{name} [{unit}]", fontsize=9)
        axes.set_xlabel("links, obstacles or criteria", fontsize=7)
        for axis in (axes.xaxis, axes.yaxis):
            axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
            axis.set_major_formatter(StrMethodFormatter("{x:g}"))
            axis.set_minor_formatter(NullFormatter())
        axes.tick_params(which="both", labelsize=7)
        axes.spines[["top", "right"]].set_visible(False)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False, fontsize=7)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    draw(ROOT / "docs" / "performance.png")
    draw_steps(ROOT / "docs" / "performance_steps.png")
    draw_growth(ROOT / "docs" / "performance_growth.png")
