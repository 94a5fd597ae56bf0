"""``jtik list``: what can be named on the command line, as tables or as JSON."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from importlib import metadata
from typing import Any

from jtik.problems import collection
from jtik.qp import available
from jtik.qp.backend import PLUGINS
from jtik.registry import criteria, secondaries, strategies
from jtik.registry.table import HEADINGS, TableRow, rows, text_table
from jtik.robot import gallery
from jtik.study import peers
from jtik.study.selection import KINDS


def _robots() -> list[TableRow]:
    described = [gallery.describe(name) for name in gallery.names()]
    return [TableRow(robot.name, robot.summary, robot.source) for robot in described]


def _solvers() -> list[TableRow]:
    fused = "solves quadratic programs, fused into the step"
    called = "solves quadratic programs, called between two parts of the step"
    return [
        TableRow(name, fused if name in PLUGINS else called, "CasADi" if name in PLUGINS else "qpsolvers")
        for name in available()
    ]


def _problems() -> list[TableRow]:
    drawn = [TableRow(name, _first_line(make), "drawn for any robot") for name, make in KINDS.items()]
    found = [collection.named(name) for name in collection.names()]
    return [*drawn, *(TableRow(f"named:{entry.name}", entry.summary, entry.origin) for entry in found)]


def _peers() -> list[TableRow]:
    made = [peers.named(name) for name in peers.names()]
    return [TableRow(f"peer:{peer.label}", _first_line(type(peer)), _installed(peer.package)) for peer in made]


def _first_line(described: Any) -> str:
    return rows({"": described})[0].summary.replace("`", "").removesuffix(".")


def _installed(package: str) -> str:
    try:
        return f"{package} {metadata.version(package)}"
    except metadata.PackageNotFoundError:
        return f"not installed: python -m pip install {package}"


SECTIONS: Mapping[str, tuple[str, Callable[[], Sequence[TableRow]]]] = {
    "robots": ("Robots", _robots),
    "criteria": ("Criteria", lambda: criteria.rows()),
    "strategies": ("Strategies", lambda: strategies.rows()),
    "secondaries": ("Secondary terms, for pairs such as newton+qp", lambda: secondaries.rows()),
    "solvers": ("Solvers of quadratic programs", _solvers),
    "problems": ("Problems", _problems),
    "peers": ("Other libraries, for comparisons", _peers),
}
"""Title and rows of each section."""

TOGETHER = {"strategies": ("strategies", "secondaries")}
"""Sections that are shown with another one."""

BRIEF = ("strategies", "secondaries", "criteria", "robots")
"""Sections of a list of everything that is registered."""


def add_arguments(commands: Any) -> None:
    """Add the command ``list`` to argparse's subparsers."""
    what = "the registered strategies, secondary terms and criteria, and the built-in robots"
    command = commands.add_parser(
        "list", help=what, description=f"List {what}; or one kind of things. Strategies come with the secondary terms."
    )
    names = ", ".join(SECTIONS)
    command.add_argument("what", nargs="?", choices=tuple(SECTIONS), metavar="WHAT", help=f"one of {names}")
    command.add_argument("--json", action="store_true", help="print an object with a list of rows for each kind")
    command.set_defaults(run=run)


def run(arguments: argparse.Namespace) -> int:
    """Print the tables; as columns of text, one line per row, where rich is not installed."""
    names = BRIEF if arguments.what is None else TOGETHER.get(arguments.what, (arguments.what,))
    sections = {name: (SECTIONS[name][0], SECTIONS[name][1]()) for name in names}
    if arguments.json:
        print(json.dumps({name: [row._asdict() for row in table] for name, (_, table) in sections.items()}, indent=1))
        return 0
    try:
        _print_with_rich(list(sections.values()))
    except ImportError:
        print("\n\n".join(text_table(title, table, width=None) for title, table in sections.values()))
    return 0


def _print_with_rich(sections: Sequence[tuple[str, Sequence[TableRow]]]) -> None:
    from rich import box
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console()
    for title, table in sections:
        shown = Table(title=title, title_justify="left", title_style="bold", box=box.SIMPLE_HEAD, pad_edge=False)
        shown.add_column(HEADINGS.name, no_wrap=True, style="bold cyan")
        shown.add_column(HEADINGS.summary)
        shown.add_column(HEADINGS.source, style="dim")
        for row in table:
            shown.add_row(*(escape(cell) for cell in row))
        console.print(shown)
