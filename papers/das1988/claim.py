"""Shared code of the scripts in this folder: expected numbers, tolerances, statements, and the command line.

A script computes rows, each a dictionary of text keys and numbers, and checks statements about them. It prints both,
writes the rows to ``results/`` and compares them with ``expected/``. The tests run it with ``quick``, on fewer
problems. If the quick numbers differ, their expected values are in ``expected/quick/``.
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

AS_IT_TURNS = 1e9
"""A ``jump_limit`` [rad] that only keeps a solve from bringing joints back by whole turns: a step is seen as it is."""

Row = dict[str, str | float]
"""Values by column name; a row may lack columns of other rows."""


@dataclass(frozen=True)
class Within:
    """Tolerance of a number; the larger of both tolerances applies.

    Attributes:
        absolute: absolute tolerance.
        relative: tolerance relative to the expected number.
    """

    absolute: float = 0.0
    relative: float = 0.0

    def allows(self, now: float, expected: float, slack: float = 1.0) -> bool:
        """Whether two numbers agree; equal infinities agree, and NaN agrees with NaN."""
        if now == expected or (math.isnan(now) and math.isnan(expected)):
            return True
        if math.isinf(now) or math.isinf(expected):
            return math.isinf(self.absolute)
        return abs(now - expected) <= slack * max(self.absolute, self.relative * abs(expected))


EXACT = Within(relative=1e-6)
"""Tolerance of numbers that depend on rounding only; csv files have ten digits."""
MEDIAN = Within(absolute=1.0, relative=0.1)
"""Tolerance of medians of iterations: mathematical libraries differ in the last digit, and long runs amplify it."""
SHARE = Within(absolute=3.0)
"""Tolerance of percentages of solves, for the same reason."""
ROUNDING = Within(absolute=1e-9)
"""Tolerance of differences that are pure rounding."""
FEW = 3.0
"""Factor on the tolerances in a quick run, where one problem of twenty is five percent."""


@dataclass(frozen=True)
class ScriptReport:
    """Result of a run.

    Attributes:
        rows: the computed rows.
        statements: whether each statement holds.
        differing: descriptions of the numbers that differ from the expected ones.
    """

    rows: list[Row]
    statements: dict[str, bool]
    differing: list[str]

    @property
    def trouble(self) -> list[str]:
        """Statements that do not hold, and numbers that differ."""
        return [
            f"does not hold: {statement}" for statement, holds in self.statements.items() if not holds
        ] + self.differing


@dataclass(frozen=True)
class Script:
    """One script: its computation, its statements, and the tolerances of its numbers.

    Attributes:
        name: name of the script and of its csv files.
        keys: columns that identify a row; all other columns are numbers.
        tolerances: tolerance of each other column.
        compute: computes the rows, with fewer problems if its argument ``quick`` is True.
        statements: rows -> statements, and whether they hold.
        quick_differs: whether the rows of a quick run differ from those of a full run.
        draw: writes the figures to a folder.
        uncompared: whether a row, by its joined keys, is shown without comparison, such as times.
        show: rows -> text, if a plain table is not suitable.
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

    def run(self, quick: bool, accept: bool = False) -> ScriptReport:
        """Compute the rows, check the statements, and compare with the expected numbers or replace them."""
        rows = self.compute(quick)
        if accept:
            write(self.expected(quick), rows)
        slack = FEW if quick and self.quick_differs else 1.0
        differing = self.differing(rows, self.read_expected(quick), slack)
        return ScriptReport(rows, self.statements(rows), differing)

    def differing(self, rows: Sequence[Row], expected: Sequence[Row], slack: float = 1.0) -> list[str]:
        """Descriptions of numbers that differ, and of rows that are missing or not expected."""
        now, then = by_key(rows, self.keys), by_key(expected, self.keys)
        found = [f"{key}: not expected" for key in now.keys() - then.keys()]
        found += [f"{key}: expected, but missing" for key in then.keys() - now.keys()]
        for key in now.keys() & then.keys():
            if self.uncompared(key):
                continue
            for column, tolerance in self.tolerances.items():
                if (column in now[key]) != (column in then[key]):
                    found.append(f"{key}: {column} is in only one of both")
                elif column in now[key]:
                    value, wanted = float(now[key][column]), float(then[key][column])
                    if not tolerance.allows(value, wanted, slack):
                        found.append(f"{key}: {column} is {value:.7g}, expected {wanted:.7g}")
        return sorted(found)

    def main(self, description: str | None, arguments: Sequence[str] | None = None) -> int:
        """Run from the command line. Returns 1 if a statement does not hold or a number differs, else 0."""
        parser = argparse.ArgumentParser(description=(description or "").split("\n\n")[0])
        parser.add_argument("--quick", action="store_true", help="fewer problems, as in the tests")
        parser.add_argument("--accept", action="store_true", help="replace the expected numbers by these")
        parser.add_argument("--no-figure", action="store_true", help="write no figure")
        parser.add_argument("--out", type=Path, default=HERE / "results", help="output folder (default: results/)")
        options = parser.parse_args(arguments)
        report = self.run(options.quick, options.accept)
        print(self.show(report.rows) if self.show else text(report.rows))
        for statement, holds in report.statements.items():
            print(f"{'holds' if holds else 'DOES NOT HOLD'}: {statement}")
        write(options.out / f"{self.name}.csv", report.rows)
        if self.draw and not options.no_figure:
            self.draw(options.out, report.rows)
        for line in report.trouble:
            print(f"DIFFERS  {line}", file=sys.stderr)
        if options.accept:
            print(f"accepted; now run {HERE / 'claims.py'}, which rewrites the tables of README.md")
        elif not report.trouble:
            print("as expected")
        return 1 if report.trouble else 0


def by_key(rows: Iterable[Row], keys: Sequence[str]) -> dict[str, Row]:
    """Rows by their keys, joined with " | "."""
    found = {" | ".join(str(row[key]) for key in keys): row for row in rows}
    return found


def columns(rows: Iterable[Row]) -> list[str]:
    """All columns in order of first appearance."""
    return list(dict.fromkeys(name for row in rows for name in row))


def number(value: str | float) -> str:
    """A number with ten digits; text unchanged."""
    return value if isinstance(value, str) else f"{value:.10g}"


def write(path: Path, rows: Sequence[Row]) -> None:
    """Write rows to a csv file."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, columns(rows), lineterminator="\n")
        writer.writeheader()
        writer.writerows({name: number(value) for name, value in row.items()} for row in rows)


def read(path: Path, keys: Sequence[str]) -> list[Row]:
    """Read rows from a csv file; empty cells are left out."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            {name: cell if name in keys else float(cell) for name, cell in line.items() if cell}
            for line in csv.DictReader(file)
        ]


def text(rows: Sequence[Row]) -> str:
    """Rows as a text table."""
    names = columns(rows)
    cells = [names] + [[_short(row[name]) if name in row else "" for name in names] for row in rows]
    widths = [max(len(line[i]) for line in cells) for i in range(len(names))]
    return "\n".join("  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)) for line in cells)


def _short(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def median(values: Sequence[float]) -> float:
    """The median; values may be infinite."""
    ordered, half = sorted(values), len(values) // 2
    return ordered[half] if len(values) % 2 or math.isinf(ordered[half]) else (ordered[half - 1] + ordered[half]) / 2


def percent(flags: Iterable[bool]) -> float:
    """The share of true values [%]."""
    listed = [bool(flag) for flag in flags]
    return 100 * sum(listed) / len(listed)
