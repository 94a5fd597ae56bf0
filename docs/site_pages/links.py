"""Links of a page, which lead to files of the repository, as links to pages of the site."""

from __future__ import annotations

import os
import posixpath
import re
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from site_pages.pages import Pages

PICTURES = (".png", ".svg", ".gif")

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(([^()\s]+)\)")
"""A link or a picture: whether it is a picture, its text, its target."""

FENCE = re.compile(r"^( *(`{3,}|~{3,}).*?^ *\2 *$)", flags=re.DOTALL | re.MULTILINE)
"""A block of code, in which nothing is a link."""


def rewrite(pages: Pages, text: str, origin: str, place: str) -> str:
    """The text of the file ``origin`` of the repository, with links as they must be at ``place``.

    A link to a file that is a page leads there; to any other file, to a page that shows it; to a folder without a page,
    it is left out and its text stays.

    Raises:
        FileNotFoundError: for a link to nothing.
    """
    parts = FENCE.split(text)
    # FENCE has two groups: text, block, its fence, text, block, ...
    for index in range(0, len(parts), 3):
        parts[index] = LINK.sub(lambda match: _link(pages, match, origin, place), parts[index])
    return "".join(part for index, part in enumerate(parts) if index % 3 != 2)


def _link(pages: Pages, match: re.Match[str], origin: str, place: str) -> str:
    picture, label, target = match.groups()
    if "](" in label:  # a picture as the text of a link
        label = LINK.sub(lambda inner: _link(pages, inner, origin, place), label)
    if target.startswith("#") or re.match(r"\w+:", target):
        return f"{picture}[{label}]({target})"
    name, _, anchor = target.partition("#")
    found = posixpath.normpath(posixpath.join(posixpath.dirname(origin), name))
    page = _page(pages, found, origin)
    if page is None:
        return label
    relative = posixpath.relpath(page, posixpath.dirname(place) or ".")
    return f"{picture}[{label}]({relative}{'#' + anchor if anchor else ''})"


def _page(pages: Pages, name: str, origin: str) -> str | None:
    if name in pages.of:
        return pages.of[name]
    path = pages.root / name
    if path.is_dir():
        return None
    if not path.is_file():
        raise FileNotFoundError(f"{origin}: the link to {name} leads to nothing")
    if path.suffix in PICTURES:
        place = name.removeprefix("docs/") if name.startswith("docs/") else f"pictures/{name.replace(os.sep, '/')}"
        pages.copy(path, place)
        return place
    return pages.source(name)
