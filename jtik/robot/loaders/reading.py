"""Reading the file of a description that somebody else may have made."""

from __future__ import annotations

import stat
from pathlib import Path

from jtik.errors import RobotFileError

LARGEST = 64 * 2**20
"""Largest file of a description [bytes]: without its meshes, that of a humanoid has a thousandth."""


def read_description(path: Path, kind: str) -> bytes:
    """The content of a file.

    Args:
        path: the file.
        kind: "URDF", "SRDF" or "MJCF", for errors.

    Raises:
        RobotFileError: when it cannot be read, is larger than `LARGEST`, or is a pipe, a device or a folder.
    """
    label, accepted = str(path), f"the path of a file that can be read, or {kind} text, which starts with '<'"
    if "\0" in label:
        raise RobotFileError(repr(label)[1:-1], "", f"no path: it has a NUL character; accepted: {accepted}")
    try:
        found = path.stat()
        if not (stat.S_ISREG(found.st_mode) or stat.S_ISDIR(found.st_mode)):  # a folder has a reason of its own
            raise RobotFileError(label, "", f"a pipe, a device or a socket; accepted: {accepted}")
        with path.open("rb") as file:
            content = file.read(LARGEST + 1)
    except OSError as error:
        raise RobotFileError(label, "", f"{error.strerror or error}; accepted: {accepted}") from error
    if len(content) > LARGEST:
        raise RobotFileError(label, "", f"larger than {LARGEST // 2**20} MiB, which no {kind} is")
    return content
