"""Expands XACRO files by the package xacro."""

from __future__ import annotations

import contextlib
import importlib
import io
from collections.abc import Mapping
from typing import Any

from jtik.errors import ArgumentError, RobotFileError
from jtik.robot.loaders.source import PathOrText, Source


def expand(source: Source, path_or_xml: PathOrText, arguments: Mapping[str, str]) -> str:
    """The XML that a XACRO stands for.

    Args:
        source: the XACRO as read.
        path_or_xml: its path or its text.
        arguments: values for its <xacro:arg> elements.

    Raises:
        RobotFileError: when it cannot be expanded, or the package xacro is not installed.
    """
    if not isinstance(arguments, Mapping):
        raise ArgumentError("xacro_arguments", arguments, "a dict from the names of arguments to their values")
    mappings = {str(name): str(value) for name, value in arguments.items()}
    xacro = _package(source)
    said = io.StringIO()
    try:
        with contextlib.redirect_stderr(said), contextlib.redirect_stdout(said):
            if source.path is not None:
                document = xacro.process_file(str(source.path), mappings=mappings)
            else:
                document = xacro.parse(str(path_or_xml).strip("\ufeff \t\r\n"))
                xacro.process_doc(document, mappings=mappings)
    except (Exception, SystemExit) as error:  # xacro evaluates expressions of the file: any exception may come from it
        said_so = " ".join(f"{type(error).__name__}: {error}".split())
        accepted = "a XACRO whose packages are found; $(find ...) needs a sourced ROS workspace, or a path instead"
        raise RobotFileError(source.label, "", f"xacro cannot expand it: {said_so}; accepted: {accepted}") from error
    return str(document.documentElement.toxml())


def _package(source: Source) -> Any:
    try:
        return importlib.import_module("xacro")
    except ImportError as error:
        problem = "its xacro elements have to be expanded first; install the package with: pip install 'jtik[xacro]'"
        no_link = "not a robot: it has no link; " if source.root.find("link") is None else ""
        raise RobotFileError(source.label, "", no_link + problem) from error
