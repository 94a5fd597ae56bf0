"""The compiled libraries of the user: where they are kept, and which of them may be loaded.

What is loaded runs as the user. So a library is loaded only from a folder that nobody else can change, and only where
it is the user's own file whose content has the digest that its name ends with. Any other file is built again. A library
is written beside its name and then renamed, so that a process that is killed leaves no part of one.
"""

from __future__ import annotations

import atexit
import logging
import os
import shutil
import stat
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from pathlib import Path
from typing import NamedTuple

from jtik.symbolic.compilation.c_compiler import ZIG_CACHE, CompilerError
from jtik.symbolic.compilation.private_folder import private_folder

LIMIT = 512 * 2**20
"""Size of the cache above which the libraries used least recently are deleted [bytes]."""

ABANDONED = 3600.0
"""Age after which the scratch folder of a compilation is that of a process that was killed [s]."""

SCRATCH = "building-"
"""Beginning of the names of scratch folders."""

SUFFIX = ".so"

_logger = logging.getLogger(__name__)


class CacheInfo(NamedTuple):
    """What the cache holds.

    Attributes:
        folder: where it is.
        libraries: number of libraries.
        size: their size [bytes].
        limit: size above which the libraries used least recently are deleted [bytes].
    """

    folder: Path
    libraries: int
    size: int
    limit: int


def folder() -> Path:
    """The folder of the compiled libraries, which only the user can read and change.

    ``$XDG_CACHE_HOME/jtik`` or ``~/.cache/jtik``. Where that cannot be made, cannot be written or can be changed by
    others, it is a temporary folder of this process, and a warning is logged.
    """
    try:
        wanted = _wanted()
        return private_folder(wanted)
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home folder
        return _temporary(str(error), os.getpid())


def find_or_build(key: str, build: Callable[[Path], Path]) -> Path:
    """The library with this key, which is built where there is none that may be loaded.

    Args:
        key: beginning of its name, which stands for everything that it depends on.
        build: builds it in an empty folder, and returns where.

    Raises:
        CompilerError: when it cannot be built or stored.
    """
    kept = folder()
    for path in _sorted(kept, key):
        if _is_intact(path):
            _touch(path)
            return path
        _logger.warning("%s is not what was stored under this name: it is built again", path)
        _remove(path)
    try:
        with _scratch(kept) as scratch:
            begin = time.perf_counter()
            built = build(scratch)
            data = built.read_bytes()
            path = kept / f"{key}-{_digest(data)}{SUFFIX}"
            built.chmod(0o700)
            with built.open("rb") as file:
                os.fsync(file.fileno())  # a name must not outlive its content when the machine stops
            built.replace(path)
            _logger.info("compiled %s in %.1f s", path, time.perf_counter() - begin)
    except OSError as error:
        raise CompilerError(f"the library cannot be stored in {kept}", str(error)) from error
    _evict(kept, path)
    return path


def forget(path: Path) -> None:
    """Delete a library that cannot be used.

    Args:
        path: path of the library.
    """
    _remove(path)


def info() -> CacheInfo:
    """What the cache holds."""
    kept = folder()
    sizes = [each.stat().st_size for each in _sorted(kept, "")]
    return CacheInfo(kept, len(sizes), sum(sizes), LIMIT)


def clear() -> CacheInfo:
    """Delete all libraries, and what compilers and killed processes have left. Returns what the cache held."""
    held = info()
    for each in held.folder.iterdir():
        if each.name.startswith(SCRATCH) or each.name == ZIG_CACHE:
            shutil.rmtree(each, ignore_errors=True)
        elif each.suffix == SUFFIX:
            _remove(each)
    return held


def _wanted() -> Path:
    given = os.environ.get("XDG_CACHE_HOME", "")
    base = Path(given) if os.path.isabs(given) else Path.home() / ".cache"  # a relative path is to be ignored
    return base / "jtik"


@lru_cache(maxsize=1)
def _temporary(reason: str, process: int) -> Path:
    made = Path(tempfile.mkdtemp(prefix="jtik-"))

    def delete() -> None:
        if os.getpid() == process:  # not a fork of it
            shutil.rmtree(made, ignore_errors=True)

    atexit.register(delete)
    _logger.warning("compiled libraries are kept in %s until this process ends: %s", made, reason)
    return made


def _sorted(kept: Path, key: str) -> list[Path]:
    """The libraries whose name begins with a key."""
    return sorted(each for each in kept.iterdir() if each.name.startswith(key) and each.name.endswith(SUFFIX))


def _digest(data: bytes) -> str:
    import hashlib

    return hashlib.sha256(data).hexdigest()


def _is_intact(path: Path) -> bool:
    """Whether a library is a file of the user that only the user can change, with the content of its digest."""
    try:
        found = path.lstat()
        if not stat.S_ISREG(found.st_mode):
            return False
        if hasattr(os, "getuid") and (found.st_uid != os.getuid() or found.st_mode & 0o022):
            return False
        return _digest(path.read_bytes()) == path.stem.rpartition("-")[2]
    except OSError:
        return False


@contextmanager
def _scratch(kept: Path) -> Iterator[Path]:
    """An empty folder, which is deleted at the end, also that of the process, but not by a fork of it."""
    made, process = Path(tempfile.mkdtemp(prefix=SCRATCH, dir=kept)), os.getpid()

    def delete() -> None:
        if os.getpid() == process:
            shutil.rmtree(made, ignore_errors=True)

    atexit.register(delete)
    try:
        yield made
    finally:
        atexit.unregister(delete)
        delete()


def _touch(path: Path) -> None:
    """Note that a library is used."""
    try:
        os.utime(path)
    except OSError:  # of no consequence: it may be deleted a little too early
        return


def _remove(path: Path) -> None:
    try:
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    except OSError as error:
        raise CompilerError(f"{path} cannot be used and not be deleted", str(error)) from error


def _evict(kept: Path, newest: Path) -> None:
    """Delete the libraries used least recently above `LIMIT`, and what killed processes have left."""
    entries = []
    for each in kept.iterdir():
        try:
            found = each.lstat()
        except FileNotFoundError:
            continue
        if each.name.startswith(SCRATCH):
            if time.time() - found.st_mtime > ABANDONED:
                shutil.rmtree(each, ignore_errors=True)
        elif each.suffix == SUFFIX and each != newest:
            entries.append((found.st_mtime, found.st_size, each))
    left = LIMIT - newest.stat().st_size
    for _, size, each in sorted(entries, reverse=True):
        left -= size
        if left < 0:
            each.unlink(missing_ok=True)  # a process that has loaded it keeps it
