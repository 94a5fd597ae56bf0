"""Docstrings for Sphinx: plain text with names in backticks, whose other signs stand for themselves."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any

PIECES = re.compile(r"(``.+?``|`[^`]+`|\*\*[^*\s](?:[^*]*[^*\s])?\*\*|:\w+:`[^`]+`)")
"""What keeps its meaning: code, names, bold text."""

NAME = re.compile(r"`([A-Za-z_]\w*(?:\.\w+)*)(\(\))?`")

DERIVATION = re.compile(r"\bformulations/(\w+)\.md\b")

_known: dict[str, str] = {}


def known() -> dict[str, str]:
    """The full name of each public name, by its last part, where that is unique."""
    if not _known:
        from site_pages.reference import entries

        ends: dict[str, set[str]] = {}
        for entry in entries():
            ends.setdefault(entry.name.rpartition(".")[2], set()).add(entry.name)
        _known.update({end: min(names) for end, names in ends.items() if len(names) == 1})
        _known.update({name: name for names in ends.values() for name in names})
    return _known


def escaped(lines: Iterable[str]) -> list[str]:
    """Lines of a docstring as reStructuredText, but for examples, which stay as they are."""
    found, example = [], False
    for line in lines:
        example = bool(line.strip()) and (example or line.lstrip().startswith(">>>"))
        found.append(line if example else _escape(line))
    return found


def _escape(line: str) -> str:
    pieces = PIECES.split(line)
    for index, piece in enumerate(pieces):
        if index % 2 == 0:
            plain = re.sub(r"([*|\\])|(?<=\w)_(?!\w)", lambda match: "\\" + match[0], piece)
            pieces[index] = DERIVATION.sub(r":doc:`\1.md </theory/\1>`", plain)
        elif name := NAME.fullmatch(piece):
            pieces[index] = _reference(name[1], name[2] or "")
    return "".join(pieces)


def _reference(name: str, call: str) -> str:
    first, dot, rest = name.partition(".")
    full = known().get(name)
    if full is None and first in known() and first != "jtik":
        full = known()[first] + dot + rest
    return f":py:obj:`{name}{call} <{full}>`" if full else f":py:obj:`{name}{call} <{name}>`" if call else f"`{name}`"


def process(_app: Any, _what: str, _name: str, _object: Any, _options: Any, lines: list[str]) -> None:
    """Escape a docstring before napoleon reads it."""
    lines[:] = escaped(lines)


def plain_signature(
    _app: Any, _what: str, _name: str, _object: Any, _options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """A signature without what is no Python, such as a default ``<factory>``, and with types as they are written."""
    return _readable(signature), _readable(returned)


def _readable(text: str | None) -> str | None:
    return text and re.sub(r"TypeAliasForwardRef\('(\w+)'\)", r"\1", re.sub(r"= <[^<>]*>", "= ...", text))


def without_fields(_app: Any, _what: str, _name: str, value: Any, _skip: bool, _options: Any) -> bool | None:
    """Leave out what only repeats the fields of a named tuple."""
    return True if (getattr(value, "__doc__", None) or "").startswith("Alias for field number") else None


def check_entries(app: Any, failure: Exception | None) -> None:
    """Fail where a public name has no entry on the site."""
    from site_pages.reference import entries

    if failure is None and app.builder.name == "html":
        there = app.env.domaindata["py"]["objects"]
        if absent := [entry.name for entry in entries() if entry.name not in there]:
            raise ValueError(f"no entry in the reference: {', '.join(absent)}")


def setup(app: Any) -> dict[str, bool]:
    """Register with Sphinx."""
    from sphinx.domains.python import PyObject

    app.connect("autodoc-process-docstring", process, priority=100)
    app.connect("autodoc-process-signature", plain_signature)
    app.connect("autodoc-skip-member", without_fields)
    for kind in PyObject.doc_field_types:
        if kind.name == "variable":
            kind.label = "Attributes"
    app.connect("build-finished", check_entries)
    return {"parallel_read_safe": True}
