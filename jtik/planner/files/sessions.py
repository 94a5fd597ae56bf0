"""The folders of sessions: where journals lie, and which of them can be recovered."""

from __future__ import annotations

import os
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from jtik.arguments import path as read_path
from jtik.planner.files.journal import JOURNAL, SNAPSHOT, Tell, lock
from jtik.symbolic.compilation.private_folder import private_folder

CLOSED = b'{"closed": true}\n'
"""The last line of the journal of a session that was ended."""


@dataclass(frozen=True)
class Session:
    """A session that can be recovered.

    Attributes:
        folder: its folder, for `jtik.planner.files.recovery.recover`.
        ended: when it was written last, in seconds since 1970.
        closed: whether it was ended, not killed.
        size: size of its files [bytes].
    """

    folder: Path
    ended: float
    closed: bool
    size: int


def default_folder() -> Path:
    """``$XDG_STATE_HOME/jtik`` or ``~/.local/state/jtik``. Raises RuntimeError where there is no home folder."""
    given = os.environ.get("XDG_STATE_HOME", "")
    base = Path(given) if os.path.isabs(given) else Path.home() / ".local" / "state"  # a relative path is ignored
    return base / "jtik"


def new_folder(folder: str | Path | None = None, tell: Tell | None = None) -> Path:
    """The folder of a new session, which the journal makes when it writes first.

    Args:
        folder: where sessions lie; by default a folder of the user that nobody else can read. Where that cannot be
            used, it is a temporary folder, and ``tell`` reports it.
        tell: called with "error" and a sentence.
    """
    if folder is None:
        try:
            base = private_folder(default_folder())
        except (OSError, RuntimeError) as error:
            base = Path(tempfile.mkdtemp(prefix="jtik-"))
            if tell is not None:
                tell("error", f"the journal lies in {base}, where the next start does not look for it: {error}")
    else:
        base = read_path("folder", folder, "the path of a folder")
    stem = f"{time.strftime('%Y-%m-%d-%H%M%S')}-{os.getpid()}"
    names = [stem, *(f"{stem}-{i}" for i in range(2, 1000))]
    return next(base / name for name in names if not (base / name).exists())


def recoverable(folder: str | Path | None = None) -> tuple[Session, ...]:
    """The sessions that have left something and are not running, the latest first.

    Args:
        folder: where sessions lie, as in `new_folder`.
    """
    base = default_folder() if folder is None else read_path("folder", folder, "the path of a folder")
    return tuple(sorted(_sessions(base), key=lambda session: session.ended, reverse=True))


def _sessions(base: Path) -> Iterator[Session]:
    try:
        folders = [each for each in base.iterdir() if each.is_dir() and not each.is_symlink()]
    except OSError:
        return
    for folder in folders:
        try:
            files = [each.stat() for each in (folder / JOURNAL, folder / SNAPSHOT) if each.is_file()]
            if files and _has_something(folder) and not _is_running(folder / JOURNAL):
                ended, size = max(file.st_mtime for file in files), sum(file.st_size for file in files)
                yield Session(folder, ended, _is_closed(folder / JOURNAL), size)
        except OSError:  # removed meanwhile, or of another user
            continue


def _has_something(folder: Path) -> bool:
    """Whether a session has a snapshot, or a journal in which an attempt begins or an edit is noted."""
    if (folder / SNAPSHOT).is_file():
        return True
    with (folder / JOURNAL).open("rb") as file:
        return any(line.startswith((b'{"begin"', b'{"edit"')) for line in file)


def _is_running(journal: Path) -> bool:
    """Whether a process has a journal open."""
    if not journal.is_file():
        return False
    file = os.open(journal, os.O_RDONLY)
    try:
        lock(file)
    except BlockingIOError:
        return True
    finally:
        os.close(file)
    return False


def _is_closed(journal: Path) -> bool:
    """Whether the last line says that the session was ended."""
    if not journal.is_file():
        return False
    with journal.open("rb") as file:
        file.seek(max(journal.stat().st_size - len(CLOSED), 0))
        return file.read() == CLOSED
