"""Archives of arrays, ``.npz``: written whole or not at all, and read without trust in what they hold."""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import existing_file
from jtik.arguments import path as read_path
from jtik.errors import ArgumentError

LARGEST = 4 * 2**30
"""Largest size of the arrays of an archive when they are unpacked [bytes]."""

RATIO = 200
"""Largest ratio of unpacked to packed size of what is more than `SMALL`: the archives are written without packing."""

SMALL = 2**20
"""Size up to which the ratio does not matter [bytes]."""


def checked_path(path: str | Path, argument: str = "path") -> Path:
    """The path. Raises ArgumentError unless it ends in .npz and its folder exists."""
    path = read_path(argument, path)
    if path.suffix != ".npz" or "\0" in str(path):
        raise ArgumentError(argument, repr(str(path)), "a file name that ends in .npz")
    if not path.parent.is_dir():
        raise ArgumentError(argument, str(path), "a file in an existing folder")
    return path


def write_archive(path: Path, header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write a header and arrays to another file and rename it: a reader finds either the old file or the new one.

    Raises:
        OSError: when the file cannot be written, as on a full disk; nothing of it then stays behind.
    """
    packed = io.BytesIO()  # NumPy raises other errors than OSError where it cannot write
    np.savez(packed, allow_pickle=False, header=np.array(json.dumps(header)), **arrays)
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with temporary.open("wb") as file:
            file.write(packed.getbuffer())
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def read_archive(path: Path, argument: str, accepted: str) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """The header and the arrays of a file of `write_archive`.

    Raises:
        ArgumentError: for any other file, one that is no regular file, and one that would fill the memory.
        OSError: when it cannot be read.
    """
    if path.exists() and not path.is_file():
        raise ArgumentError(argument, f"{path}, which is no regular file", accepted)
    with existing_file(argument, path).open("rb") as file:
        try:
            with zipfile.ZipFile(file) as members:
                _check_sizes(members.infolist(), path, argument, accepted)
            file.seek(0)
            with np.load(file, allow_pickle=False) as archive:
                arrays = dict(archive)
            header = json.loads(str(arrays.pop("header")))
        except ArgumentError:
            raise
        except Exception as error:  # zipfile, zlib, NumPy and JSON raise many kinds for a file that is damaged
            given = f"{path}, which cannot be read ({type(error).__name__})"
            raise ArgumentError(argument, given, accepted) from error
    if not isinstance(header, dict):
        raise ArgumentError(argument, f"{path}, whose header is no mapping", accepted)
    return header, arrays


def _check_sizes(members: list[zipfile.ZipInfo], path: Path, argument: str, accepted: str) -> None:
    size = sum(member.file_size for member in members)
    packed = sum(member.compress_size for member in members)
    if size > LARGEST or size > max(SMALL, RATIO * packed):
        raise ArgumentError(argument, f"{path}, which unpacks from {packed} to {size} bytes", accepted)
