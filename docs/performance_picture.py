"""Draw the times of docs/performance.md from the table of benchmarks/README.md.

python docs/performance_picture.py
"""

from __future__ import annotations

import re
from pathlib import Path

from matplotlib.figure import Figure

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
    axes.set_xlim(20, 9000)
    axes.set_xlabel("mean time to a pose [µs], 1e-5 m and rad")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    draw(ROOT / "docs" / "performance.png")
