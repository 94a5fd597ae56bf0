"""The source of a description: a file or text, and its XML."""

from __future__ import annotations

import re
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import TypeAlias
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

from jtik.errors import ArgumentError, RobotFileError
from jtik.robot.loaders.reading import read_description

PathOrText: TypeAlias = str | PathLike[str]
"""A path, or XML itself: text that starts with "<"."""

_BLANK = "\ufeff \t\r\n"
_COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)


@dataclass(frozen=True)
class Source:
    """A description as read.

    Attributes:
        label: its name in errors: the path, or "the text given".
        path: the file, or None for text.
        text: the XML, or None for a file.
        root: the outermost element of its XML.
    """

    label: str
    path: Path | None
    text: str | None
    root: Element


def open_source(path_or_xml: PathOrText, *, kind: str, root: str) -> Source:
    """The description at a path, or in text that starts with "<".

    Args:
        path_or_xml: the path or the text.
        kind: "URDF" or "MJCF", for errors.
        root: the name that its outermost element must have.

    Raises:
        ArgumentError: when it is neither a path nor a text.
        RobotFileError: when there is no such file, it is not XML, or its outermost element has another name.
    """
    if not isinstance(path_or_xml, (str, PathLike)):
        raise ArgumentError("path_or_xml", path_or_xml, f"the path of a {kind} file, or {kind} text")
    if isinstance(path_or_xml, str) and path_or_xml.lstrip(_BLANK).startswith("<"):
        text, label = path_or_xml.lstrip(_BLANK), f"the {kind} text given"
        return _checked(Source(label, None, text, _parsed(label, text.encode(), "utf-8")), kind, root)
    path = Path(path_or_xml)
    label = str(path)
    content = read_description(path, kind)
    return _checked(Source(label, path, None, _parsed(label, content)), kind, root)


def _checked(source: Source, kind: str, root: str) -> Source:
    tag = source.root.tag
    if tag != root:
        other = {"robot": "; a URDF is read by Robot.from_urdf", "mujoco": "; an MJCF is read by Robot.from_mjcf"}
        problem = f"not {kind}: its outermost element is <{tag}>, where <{root}> is accepted{other.get(tag, '')}"
        raise RobotFileError(source.label, "", problem)
    return source


def _parsed(label: str, content: bytes, encoding: str | None = None) -> Element:
    # Name spaces and comments are ignored: files with a tag <xacro:...> whose prefix is not declared, or with two
    # hyphens in a comment, are common, and other readers accept them.
    bare = _COMMENT.sub(lambda comment: b"\n" * comment[0].count(b"\n"), content)
    builder = TreeBuilder()
    parser = expat.ParserCreate(encoding)
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    try:
        parser.Parse(bare, True)
    except expat.ExpatError as error:
        problem = f"not XML: {expat.ErrorString(error.code)}"
        raise RobotFileError(label, f"line {error.lineno}", problem) from error
    return builder.close()
