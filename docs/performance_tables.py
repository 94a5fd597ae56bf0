"""Write the tables of docs/performance.md from the recorded runs of benchmarks/native.py and benchmarks/growth.py.

python docs/performance_tables.py
"""

from __future__ import annotations

import json
from datetime import date
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "docs" / "performance.md"

LIBRARIES = {
    "weighted_qp": "`weighted_qp`",
    "hybrid+qp": "`hybrid+qp`",
    "placo (C++)": "placo",
    "mink (DAQP)": "mink",
    "pink (DAQP)": "pink",
}
"""Columns of the table of steps, and their headings; ratios are those to the first."""

PROBLEMS = {
    "at limits": "Panda at velocity limits",
    "tracking": "Panda, tracking",
    "ten links, four circles": "ten links, four circles, 40 clearances",
}
"""Rows of the table of steps."""

SWEEPS = {"links": "links", "obstacles": "obstacles, as a criterion", "clearances": "obstacles, as clearances"}
"""What the table of growth calls a sweep."""


def short(value: float) -> str:
    """A number with two or three digits."""
    return f"{value:.0f}" if value >= 100 else f"{value:.3g}"


def recorded(name: str) -> dict[str, Any]:
    """The recorded run of a benchmark."""
    found: dict[str, Any] = json.loads((ROOT / "benchmarks" / f"{name}.json").read_text(encoding="utf-8"))
    return found


def day(run: dict[str, Any]) -> str:
    """The date of a recorded run in words."""
    on = date.fromisoformat(run["date"])
    return f"{on.day} {on:%B %Y}"


def steps() -> dict[tuple[str, str, str], dict[str, Any]]:
    """The rows of steps by problem, library and state of the caches."""
    rows = [row for row in recorded("native")["steps"] if isinstance(row, dict)]
    return {(row["problem"], row["name"], row["caches"]): row for row in rows}


def table_of_steps() -> list[str]:
    """Times of a step, and their ratios to those of `weighted_qp`."""
    rows, (first, *_) = steps(), LIBRARIES
    lines = [f"| step | caches | {' | '.join(LIBRARIES.values())} |", f"| --- | --- |{' ---: |' * len(LIBRARIES)}"]
    for problem, heading in PROBLEMS.items():
        for caches in ("hot", "cold"):
            cells = []
            for name in LIBRARIES:
                row = rows.get((problem, name, caches))
                if row is None:
                    cells.append("")
                    continue
                (time, *_), (ratio, low, high) = row["microseconds"], row["ratio"]
                more = "" if name == first else f": {ratio:.1f} ({low:.1f} to {high:.1f})"
                cells.append(f"{short(time)} µs{more}")
            lines.append(f"| {heading} | {caches} | {' | '.join(cells)} |")
    return [*lines, "", f"Recorded on {day(recorded('native'))}."]


def table_of_growth() -> list[str]:
    """Exponents, and the figures of the smallest and the largest size."""
    run = recorded("growth")
    names = list(run["units"])
    headings = " | ".join(f"{name} [{run['units'][name]}]" for name in names)
    lines = [f"| what grows | strategy | sizes | {headings} |", f"| --- | --- | --- |{' ---: |' * len(names)}"]
    for row in run["rows"]:
        cells = []
        for name in names:
            values, above = row["figures"][name], "" if row["judged"][name] else " (!)"
            cells.append(f"{short(values[0])} to {short(values[-1])}: {row['exponents'][name]:.2f}{above}")
        sizes = f"{row['sizes'][0]} to {row['sizes'][-1]}"
        if row["left_out"]:
            sizes += f", without {', '.join(map(str, row['left_out']))}"
        what = SWEEPS.get(row["what"], row["what"])
        lines.append(f"| {what} | `{row['strategy']}` | {sizes} | {' | '.join(cells)} |")
    return [*lines, "", f"Recorded on {day(run)}."]


TABLES = {"steps": table_of_steps, "growth": table_of_growth}
"""The tables by their marks in the page."""


def written(page: str) -> str:
    """The page with its tables as they are recorded."""
    for name, table in TABLES.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- /{name} -->"
        before, rest = page.split(begin)
        page = before + begin + "\n".join(["", *table(), "", end]) + rest.split(end)[1]
    return page


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
