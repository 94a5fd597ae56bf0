"""Registered classes as a table of name, summary and source: text and HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

WIDTH = 120
"""Most characters in a line of the text."""

GAP = "  "

MIN_SOURCE = 30
"""Width that the source column has at least, if it needs it; the summaries get the rest."""


class TableRow(NamedTuple):
    """One registered class, as lists show it.

    Attributes:
        name: the name it is registered by.
        summary: what it does, one line; the first line of its docstring where it has no summary.
        source: the paper; empty where it names none.
    """

    name: str
    summary: str
    source: str


HEADINGS = TableRow("name", "what it does", "source")


def rows(registered: Mapping[str, type]) -> list[TableRow]:
    """One row a class, in the mapping's order."""
    found = []
    for name, plugin in registered.items():
        summary = getattr(plugin, "summary", "") or str(plugin.__doc__ or "").strip().partition("\n")[0]
        found.append(TableRow(name, _one_line(summary), _one_line(getattr(plugin, "source", ""))))
    return found


def text_table(title: str, table: Sequence[Sequence[str]], width: int | None = WIDTH) -> str:
    """Aligned columns below a title; cells are wrapped so that no line is longer than ``width``."""
    lines = [HEADINGS, *table]
    widths = [max(len(line[column]) for line in lines) for column in range(len(HEADINGS))]
    if width is not None:
        widths = _narrowed(widths, width)
    return "\n".join([title, *(text for line in lines for text in _wrapped(line, widths))])


def html_table(title: str, table: Sequence[Sequence[str]]) -> str:
    """An HTML table below a title, every text escaped."""
    import html

    head = "".join(f"<th style='text-align:left'>{html.escape(cell)}</th>" for cell in HEADINGS)
    body = "".join(
        "<tr>" + "".join(f"<td style='text-align:left'>{html.escape(cell)}</td>" for cell in line) + "</tr>"
        for line in table
    )
    caption = f"<caption>{html.escape(title)}</caption>"
    return f"<table>{caption}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


def _narrowed(widths: Sequence[int], width: int) -> list[int]:
    """Column widths that fit into ``width``: names are shortened last, summaries before them, sources first."""
    left = width - 2 * len(GAP)
    name = min(widths[0], left // 3)
    source = min(widths[2], max(MIN_SOURCE, left - name - widths[1]))
    return [name, min(widths[1], left - name - source), source]


def _wrapped(line: Sequence[str], widths: Sequence[int]) -> list[str]:
    """The lines of text of one row."""
    import textwrap

    cells = [textwrap.wrap(cell, max(size, 1)) or [""] for cell, size in zip(line, widths, strict=True)]
    height = max(len(cell) for cell in cells)
    return [
        GAP.join(
            (cell[k] if k < len(cell) else "").ljust(size) for cell, size in zip(cells, widths, strict=True)
        ).rstrip()
        for k in range(height)
    ]


def _one_line(text: object) -> str:
    return " ".join(str(text or "").split())
