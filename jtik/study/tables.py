"""Tables as text, Markdown and HTML."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

_MARKUP = re.compile(r"([\\`*_\[\]|~])")
"""Characters that Markdown reads as mark-up within a cell."""

_FORMULA = ("=", "+", "-", "@")
"""First characters of what a spreadsheet reads as a formula."""

Table = Mapping[str, Sequence[Any]]


def cell(value: Any) -> str:
    """The text of a cell: numbers with three digits, NaN as an empty cell."""
    if isinstance(value, float):
        if math.isnan(value):
            return ""
        return f"{value:.0f}" if 1000 <= abs(value) < 1e5 else f"{value:.3g}"
    return str(value)


def text(table: Table) -> str:
    """A table for the terminal: text left-aligned, numbers right-aligned, long titles over several lines."""
    titles, rows = list(table), _rows(table)
    heads = [_stacked(title) for title in titles]
    height = max(len(head) for head in heads)
    lines = [[head[i - height + len(head)] if i >= height - len(head) else "" for head in heads] for i in range(height)]
    widths = [max(len(line[i]) for line in [*lines, *rows]) for i in range(len(titles))]
    words = _words(table)

    def aligned(line: Sequence[str]) -> str:
        places = zip(line, widths, words, strict=True)
        return "  ".join(each.ljust(width) if word else each.rjust(width) for each, width, word in places).rstrip()

    return "\n".join(aligned(line) for line in [*lines, *rows])


def fitted(table: Table, width: int, dropped_first: Sequence[str]) -> tuple[Table, list[str]]:
    """A table whose text has lines of at most ``width`` characters, if that can be.

    Args:
        table: the table.
        width: most characters of a line.
        dropped_first: titles of the columns that may be left out, in that order.

    Returns:
        The table, and the titles of the columns that were left out.
    """
    left, dropped = dict(table), []
    for title in dropped_first:
        if max(map(len, text(left).splitlines())) <= width:
            break
        if title in left:
            del left[title]
            dropped.append(title)
    return left, [title for title in table if title in dropped]


def markdown(table: Table) -> str:
    """A Markdown table. What names have of Markdown and HTML is shown as it is written."""
    marks = ["---" if word else "---:" for word in _words(table)]
    lines = [[_as_written(each) for each in line] for line in [list(table), *_rows(table)]]
    return "\n".join(f"| {' | '.join(line)} |" for line in [lines[0], marks, *lines[1:]]) + "\n"


def _as_written(text: str) -> str:
    """Text in which Markdown and HTML see no mark-up."""
    return _MARKUP.sub(r"\\\1", html.escape(" ".join(text.split()), quote=False))


def spreadsheet_text(value: Any) -> Any:
    """A value for a table that a spreadsheet opens: text that it would take for a formula begins with an apostrophe."""
    return f"'{value}" if isinstance(value, str) and value.lstrip().startswith(_FORMULA) else value


def markup(table: Table) -> str:
    """An HTML table."""
    words = _words(table)

    def line(tag: str, cells: Sequence[str]) -> str:
        parts = [
            f'<{tag} style="text-align:{"left" if word else "right"}">{html.escape(each)}</{tag}>'
            for each, word in zip(cells, words, strict=True)
        ]
        return f"<tr>{''.join(parts)}</tr>"

    body = "".join(line("td", row) for row in _rows(table))
    return f"<table><thead>{line('th', list(table))}</thead><tbody>{body}</tbody></table>"


def _rows(table: Table) -> list[list[str]]:
    return [[cell(value) for value in row] for row in zip(*table.values(), strict=True)]


def _words(table: Table) -> list[bool]:
    """Whether each column is text."""
    return [all(isinstance(value, str) for value in column) for column in table.values()]


def _stacked(title: str) -> list[str]:
    """A title over several lines: long titles word by word, and the unit last."""
    name, bracket, unit = title.partition(" [")
    words = name.split(" ")
    lines = [name] if len(name) <= 9 else words
    return [*lines, *([f"[{unit}"] if bracket else [])]
