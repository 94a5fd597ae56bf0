"""Folders of the user that nobody else can change."""

from __future__ import annotations

import os
import stat
import tempfile
from pathlib import Path


def private_folder(wanted: Path) -> Path:
    """A folder of the user, made with mode 0700 where it does not exist.

    Args:
        wanted: path of the folder.

    Raises:
        OSError: where it belongs to another user, can be changed by others, or cannot be written.
    """
    wanted.parent.mkdir(parents=True, exist_ok=True)
    wanted.mkdir(mode=0o700, exist_ok=True)
    kept = wanted.resolve()
    if hasattr(os, "getuid"):
        found = kept.stat()
        if not stat.S_ISDIR(found.st_mode):
            raise OSError(f"{kept} is no folder")
        if found.st_uid != os.getuid():
            raise OSError(f"{kept} belongs to another user")
        if found.st_mode & 0o022:
            raise OSError(f"{kept} can be changed by other users; correct it with: chmod 700 {kept}")
        if found.st_mode & 0o077:
            kept.chmod(0o700)
    with tempfile.TemporaryFile(dir=kept):  # raises where nothing can be written
        return kept
