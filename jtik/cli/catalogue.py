"""``jtik list``: what is registered and which robots come along, a line each."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Mapping, Sequence

from jtik.registry import criteria, strategies
from jtik.robot import gallery

HEADINGS = ("name", "what it does", "source")


def rows(registered: Mapping[str, type]) -> list[tuple[str, str, str]]:
    """Name, summary and source of each class; a class without a summary is described by its docstring's first line."""
    found = []
    for name, plugin in registered.items():
        first_line = (plugin.__doc__ or "").strip().partition("\n")[0]
        found.append((name, getattr(plugin, "summary", "") or first_line, getattr(plugin, "source", "")))
    return found


def run(arguments: argparse.Namespace) -> int:
    """Print the tables; plain columns where rich is not installed."""
    described = [gallery.describe(name) for name in gallery.names()]
    robots = [(robot.name, robot.summary, robot.source) for robot in described]
    sections = [("Strategies", rows(strategies)), ("Criteria", rows(criteria)), ("Robots", robots)]
    try:
        from rich import box
        from rich.console import Console
        from rich.markup import escape
        from rich.table import Table
    except ImportError:
        print("\n\n".join(plain_table(title, table) for title, table in sections))
        return 0
    console = Console()
    for title, table in sections:
        shown = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
        shown.add_column(HEADINGS[0], no_wrap=True, style="bold cyan")
        shown.add_column(HEADINGS[1])
        shown.add_column(HEADINGS[2], style="dim")
        for row in table:
            shown.add_row(*(escape(cell) for cell in row))
        console.print(shown)
    return 0


def plain_table(title: str, table: Iterable[Sequence[str]]) -> str:
    """Aligned columns below a title."""
    lines = [HEADINGS, *table]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEADINGS))]
    text = ["  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip() for line in lines]
    return "\n".join([title, *text])
