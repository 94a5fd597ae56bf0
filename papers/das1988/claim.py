"""What the scripts of this folder share: expected numbers, how far one may be from them, statements, the command line.

A script computes rows, each a dictionary of text keys and numbers, and states in sentences what they show. Run, it
prints both, writes the rows to ``results/`` and compares them with ``expected/``. The tests run it with ``quick``,
on fewer problems, which has expected numbers of its own in ``expected/quick/`` where it differs.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

HERE = Path(__file__).parent

Row = dict[str, str | float]
"""Columns by name; a row may lack columns that others have."""


@dataclass(frozen=True)
class Within:
    """How far a number may be from the expected one: ``absolute``, or ``relative`` of it, whichever allows more."""

    absolute: float = 0.0
    relative: float = 0.0

    def allows(self, now: float, expected: float, slack: float = 1.0) -> bool:
        """Whether they agree; equal infinities and NaN do."""
        if now == expected or (math.isnan(now) and math.isnan(expected)):
            return True
        if math.isinf(now) or math.isinf(expected):
            return math.isinf(self.absolute)
        return abs(now - expected) <= slack * max(self.absolute, self.relative * abs(expected))


EXACT = Within(relative=1e-6)
"""For what rounding alone can change; csv files keep ten digits."""
MEDIAN = Within(absolute=1.0, relative=0.1)
"""For medians of iterations: mathematical libraries differ in the last place, and long runs amplify that."""
SHARE = Within(absolute=3.0)
"""For percentages of solves, for the same reason."""
ROUNDING = Within(absolute=1e-9)
"""For differences that are rounding and nothing else."""
FEW = 3.0
"""How many times farther a number of the quick run may be: one problem of twenty is worth five percent."""


@dataclass(frozen=True)
class Report:
    """What a run found: its rows, its statements and whether they hold, and every number that is not as expected."""

    rows: list[Row]
    statements: dict[str, bool]
    differing: list[str]

    @property
    def trouble(self) -> list[str]:
        """Statements that do not hold, and numbers that differ."""
        return [f"does not hold: {said}" for said, holds in self.statements.items() if not holds] + self.differing


@dataclass(frozen=True)
class Script:
    """One script: what it computes, what that shows, and how far it may differ.

    Attributes:
        name: of the script and its csv files.
        keys: the columns that tell rows apart; all others are numbers.
        tolerances: of every other column.
        compute: the rows, of fewer problems if told to be quick.
        statements: what the rows show: sentences, and whether they hold.
        quick_differs: whether ``compute(True)`` answers anything but ``compute(False)``.
        draw: writes the figures of these rows into a folder.
        uncompared: rows, by their joined keys, that are shown and not compared, such as times.
        show: the rows as text, where a plain table does not do.
    """

    name: str
    keys: tuple[str, ...]
    tolerances: Mapping[str, Within]
    compute: Callable[[bool], list[Row]]
    statements: Callable[[Sequence[Row]], dict[str, bool]]
    quick_differs: bool = True
    draw: Callable[[Path, Sequence[Row]], None] | None = None
    uncompared: Callable[[str], bool] = lambda key: False
    show: Callable[[Sequence[Row]], str] | None = None

    def expected(self, quick: bool) -> Path:
        """The file of expected numbers."""
        folder = HERE / "expected" / ("quick" if quick and self.quick_differs else "")
        return folder / f"{self.name}.csv"

    def read_expected(self, quick: bool = False) -> list[Row]:
        """The expected rows."""
        return read(self.expected(quick), self.keys)

    def run(self, quick: bool, accept: bool = False) -> Report:
        """Compute, state, and compare with, or replace, the expected numbers."""
        rows = self.compute(quick)
        if accept:
            write(self.expected(quick), rows)
        slack = FEW if quick and self.quick_differs else 1.0
        differing = self.differing(rows, self.read_expected(quick), slack)
        return Report(rows, self.statements(rows), differing)

    def differing(self, rows: Sequence[Row], expected: Sequence[Row], slack: float = 1.0) -> list[str]:
        """Every number that is not as expected, and every row that only one of both has, in words."""
        now, then = by_key(rows, self.keys), by_key(expected, self.keys)
        found = [f"{key}: not expected" for key in now.keys() - then.keys()]
        found += [f"{key}: expected, but not there" for key in then.keys() - now.keys()]
        for key in now.keys() & then.keys():
            if self.uncompared(key):
                continue
            for column, tolerance in self.tolerances.items():
                if (column in now[key]) != (column in then[key]):
                    found.append(f"{key}: {column} is in one of both alone")
                elif column in now[key]:
                    a, b = float(now[key][column]), float(then[key][column])
                    if not tolerance.allows(a, b, slack):
                        found.append(f"{key}: {column} is {a:.7g}, expected {b:.7g}")
        return sorted(found)

    def main(self, description: str | None, arguments: Sequence[str] | None = None) -> int:
        """The command line. Returns the exit status: 1 if a statement does not hold or a number differs."""
        parser = argparse.ArgumentParser(description=(description or "").split("\n\n")[0])
        parser.add_argument("--quick", action="store_true", help="fewer problems, as the tests run it")
        parser.add_argument("--accept", action="store_true", help="make these numbers the expected ones")
        parser.add_argument("--no-figure", action="store_true", help="do not draw")
        parser.add_argument("--out", type=Path, default=HERE / "results", help="where to write (default: results/)")
        options = parser.parse_args(arguments)
        report = self.run(options.quick, options.accept)
        print(self.show(report.rows) if self.show else text(report.rows))
        for said, holds in report.statements.items():
            print(f"{'holds' if holds else 'DOES NOT HOLD'}: {said}")
        write(options.out / f"{self.name}.csv", report.rows)
        if self.draw and not options.no_figure:
            self.draw(options.out, report.rows)
        for line in report.trouble:
            print(f"DIFFERS  {line}", file=sys.stderr)
        if not report.trouble:
            print("as expected")
        return 1 if report.trouble else 0


def by_key(rows: Iterable[Row], keys: Sequence[str]) -> dict[str, Row]:
    """Rows by their keys, joined with " | "."""
    found = {" | ".join(str(row[key]) for key in keys): row for row in rows}
    return found


def columns(rows: Iterable[Row]) -> list[str]:
    """All columns, in the order they first come."""
    return list(dict.fromkeys(name for row in rows for name in row))


def number(value: str | float) -> str:
    """Ten digits; text as it is."""
    return value if isinstance(value, str) else f"{value:.10g}"


def write(path: Path, rows: Sequence[Row]) -> None:
    """Rows as csv."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns(rows), lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: number(value) for name, value in row.items()} for row in rows)


def read(path: Path, keys: Sequence[str]) -> list[Row]:
    """Rows from csv; an empty cell is no cell."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            {name: cell if name in keys else float(cell) for name, cell in line.items() if cell}
            for line in csv.DictReader(file)
        ]


def text(rows: Sequence[Row]) -> str:
    """A table."""
    names = columns(rows)
    cells = [names] + [[_short(row[name]) if name in row else "" for name in names] for row in rows]
    widths = [max(len(line[i]) for line in cells) for i in range(len(names))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in cells)


def _short(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def median(values: Sequence[float]) -> float:
    """The median, where infinite values may stand in the middle."""
    ordered, half = sorted(values), len(values) // 2
    return ordered[half] if len(values) % 2 or math.isinf(ordered[half]) else (ordered[half - 1] + ordered[half]) / 2


def percent(flags: Iterable[bool]) -> float:
    """The share of true ones [%]."""
    listed = [bool(flag) for flag in flags]
    return 100 * sum(listed) / len(listed)
