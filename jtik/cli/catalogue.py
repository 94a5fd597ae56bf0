"""``jtik list``: the registered strategies, secondary terms and criteria, and the built-in robots, one a row."""

from __future__ import annotations

import argparse
from collections.abc import Sequence

from jtik.registry import criteria, secondaries, strategies
from jtik.registry.table import HEADINGS, TableRow, text_table
from jtik.robot import gallery


def run(arguments: argparse.Namespace) -> int:
    """Print the tables; as columns of text, one line per row, where rich is not installed."""
    described = [gallery.describe(name) for name in gallery.names()]
    robots = [TableRow(robot.name, robot.summary, robot.source) for robot in described]
    sections = [
        ("Strategies", strategies.rows()),
        ("Secondary terms, for pairs such as newton+qp", secondaries.rows()),
        ("Criteria", criteria.rows()),
        ("Robots", robots),
    ]
    try:
        _print_with_rich(sections)
    except ImportError:
        print("\n\n".join(text_table(title, rows, width=None) for title, rows in sections))
    return 0


def _print_with_rich(sections: Sequence[tuple[str, Sequence[TableRow]]]) -> None:
    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console()
    for title, rows in sections:
        shown = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
        shown.add_column(HEADINGS.name, no_wrap=True, style="bold cyan")
        shown.add_column(HEADINGS.summary)
        shown.add_column(HEADINGS.source, style="dim")
        for row in rows:
            shown.add_row(*(escape(cell) for cell in row))
        console.print(shown)
