"""The source of a description: a file or text, and its XML."""

from __future__ import annotations

import codecs
import re
from collections.abc import Mapping
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
_DECLARATION = re.compile(r"\s*<\?xml\b[^>]*?\?>")
_ENCODING = re.compile(rb"""<\?xml[^>]{0,200}?encoding\s*=\s*["']([A-Za-z0-9._-]{1,40})["']""")
_UTF8 = ("utf-8", "utf8", "us-ascii", "ascii")
_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}


@dataclass(frozen=True)
class Source:
    """A description as read.

    Attributes:
        label: its name in errors: the path, or "the text given".
        path: the file, or None for text.
        text: the XML without comments and without its declaration.
        root: the outermost element of its XML.
        is_utf8: whether the file has the encoding and the form that MuJoCo reads.
    """

    label: str
    path: Path | None
    text: str
    root: Element
    is_utf8: bool = True


def open_source(
    path_or_xml: PathOrText,
    *,
    kind: str,
    root: str,
    arguments: Mapping[str, str] | None = None,
    argument: str = "path_or_xml",
) -> Source:
    """The description at a path, or in text that starts with "<". A XACRO is expanded.

    Args:
        path_or_xml: the path or the text.
        kind: "URDF", "SRDF" or "MJCF", for errors.
        root: the name that its outermost element must have.
        arguments: the arguments of a XACRO.
        argument: the name of ``path_or_xml`` in errors.

    Raises:
        ArgumentError: when it is neither a path nor a text.
        RobotFileError: when there is no such file, it is not XML, its outermost element has another name, or it is a
            XACRO that cannot be expanded.
    """
    if not isinstance(path_or_xml, (str, PathLike)):
        raise ArgumentError(argument, path_or_xml, f"the path of a {kind} file, or {kind} text")
    if isinstance(path_or_xml, str) and path_or_xml.lstrip(_BLANK).startswith("<"):
        source = _parsed(f"the {kind} text given", None, path_or_xml, is_utf8=True)
    else:
        source = _read(Path(path_or_xml), kind)
    tag = source.root.tag
    if tag != root:
        other = {"robot": "; a URDF is read by Robot.from_urdf", "mujoco": "; an MJCF is read by Robot.from_mjcf"}
        problem = f"not {kind}: its outermost element is <{tag}>, where <{root}> is accepted{other.get(tag, '')}"
        raise RobotFileError(source.label, "", problem)
    if kind in ("URDF", "SRDF") and _is_xacro(source):
        from jtik.robot.loaders.xacro import expand

        text = expand(source, path_or_xml, arguments or {})
        return _parsed(source.label, source.path, text, is_utf8=True)
    if arguments:
        raise ArgumentError("xacro_arguments", dict(arguments), f"arguments of a XACRO; {source.label} is none")
    return source


def _is_xacro(source: Source) -> bool:
    """Whether a file is called so, or has elements of XACRO and no link."""
    if source.path is not None and source.path.suffix.lower() == ".xacro":
        return True
    return source.root.find("link") is None and any(each.tag.startswith("xacro:") for each in source.root.iter())


def _read(path: Path, kind: str) -> Source:
    label = str(path)
    content = read_description(path, kind)
    encoding = next((name for mark, name in _MARKS.items() if content.startswith(mark)), None)
    if encoding is None:
        declared = _ENCODING.search(content[:4096])
        encoding = declared[1].decode() if declared else "utf-8"
    try:
        utf8 = encoding.lower() in _UTF8
        text = content.decode(encoding, "surrogateescape" if utf8 else "strict")  # expat then names the line
    except LookupError as error:
        raise RobotFileError(label, "", f"its encoding {encoding!r} is not known; accepted: such as UTF-8") from error
    except UnicodeError as error:
        problem = f"not XML: not text in the encoding {encoding!r}; accepted: the encoding that its declaration states"
        raise RobotFileError(label, "", problem) from error
    plain = utf8 and not text[:1].isspace() and (text.startswith("<?xml") or "<?xml" not in text)
    return _parsed(label, path, text, is_utf8=plain)


def _parsed(label: str, path: Path | None, content: str, *, is_utf8: bool) -> Source:
    # Name spaces and comments are ignored: files with a tag <xacro:...> whose prefix is not declared, or with two
    # hyphens in a comment, are common, and other readers accept them. So are blank lines before the declaration.
    text = _without_comments(content.lstrip("\ufeff"))
    declaration = _DECLARATION.match(text)
    if declaration is not None:
        text = "\n" * declaration[0].count("\n") + text[declaration.end() :]
    builder = TreeBuilder()
    parser = expat.ParserCreate("utf-8")
    parser.StartElementHandler = builder.start
    parser.EndElementHandler = builder.end
    try:
        parser.Parse(text.encode("utf-8", "surrogateescape"), True)
    except UnicodeEncodeError as error:
        raise RobotFileError(label, f"line {text.count(chr(10), 0, error.start) + 1}", "not XML: not text") from error
    except expat.ExpatError as error:
        problem = f"not XML: {expat.ErrorString(error.code)}"
        raise RobotFileError(label, f"line {error.lineno}", problem) from error
    return Source(label, path, text, builder.close(), is_utf8)


def _without_comments(text: str) -> str:
    """The text without its comments, line by line as before."""
    parts, end = [], 0
    while (start := text.find("<!--", end)) >= 0:
        close = text.find("-->", start + 4)
        if close < 0:
            break
        parts += [text[end:start], "\n" * text.count("\n", start, close)]
        end = close + 3
    return "".join([*parts, text[end:]])
