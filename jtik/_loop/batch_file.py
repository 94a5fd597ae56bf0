"""The file of a batch that runs: the solves that are done, from which the same batch goes on."""

from __future__ import annotations

import time
import warnings
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from jtik._loop.fingerprint import fingerprint
from jtik._loop.options import callers_level
from jtik.errors import ArgumentError
from jtik.result.archive import checked_path, read_archive, write_archive
from jtik.result.status import Status

if TYPE_CHECKING:
    from jtik._loop.batch import BatchEntry

KIND = "jtik batch 1"
"""What the header of a file says that it is."""

PAUSE = 2.0
"""Smallest time between two writes [s]."""

SHARE = 0.05
"""Largest share of the time that is spent on writing."""

ACCEPTED = "a new file, or one that solve_batch(save=...) wrote for the same solver, targets and options"

COLUMNS = ("indices", "q", "status", "converged", "errors", "iterations", "escapes", "restarts", "seconds")


class BatchFile:
    """The file of one batch. On a disk that is full the batch goes on, and a warning says so at its end.

    Args:
        path: a ``.npz`` file; None for no file.
        identity: everything that the numbers of the batch depend on.
        count: number of targets.
        nq: length of a configuration.

    Raises:
        ArgumentError: for a file that holds something else.
    """

    def __init__(self, path: str | Path | None, identity: Any, count: int, nq: int) -> None:
        self._path = None if path is None else checked_path(path, "save")
        self._count, self._nq = count, nq
        self._fingerprint = "" if path is None else fingerprint(identity)
        self._written, self._pause, self._rows = time.monotonic(), PAUSE, 0
        self._known = self._read(self._path) if self._path is not None and self._path.exists() else {}
        self._rows = len(self._known)

    def entries(self) -> dict[int, BatchEntry]:
        """The entries that the file already had, by the number of their target."""
        return dict(self._known)

    def add(self, entries: dict[int, BatchEntry]) -> None:
        """Write all entries, unless the last write was recent."""
        if self._path is None or time.monotonic() - self._written < self._pause:
            return
        begin = time.monotonic()
        with suppress(OSError):  # perhaps there is room later; the last write reports it
            self._write(self._path, entries)
        self._written = time.monotonic()
        self._pause = max(PAUSE, (self._written - begin) / SHARE)

    def write(self, entries: dict[int, BatchEntry]) -> None:
        """Write all entries; a warning says why where that is not possible."""
        if self._path is None or (self._rows == len(entries) and self._path.exists()):
            return
        try:
            self._write(self._path, entries)
        except OSError as error:
            warnings.warn(f"the batch was not saved: {error}", RuntimeWarning, stacklevel=callers_level())

    def _write(self, path: Path, entries: dict[int, BatchEntry]) -> None:
        for i, entry in entries.items():
            entries[i] = entry.settled()
        rows = [entries[i] for i in sorted(entries)]
        header = {"kind": KIND, "fingerprint": self._fingerprint, "targets": self._count}
        arrays = {
            "indices": np.array(sorted(entries), dtype=np.int64),
            "q": np.array([row.q for row in rows], dtype=np.float64).reshape(len(rows), self._nq),
            "status": np.array([row.diagnose().name for row in rows], dtype=str),
            "converged": np.array([row.converged for row in rows], dtype=bool),
            "errors": np.array([row.errors for row in rows], dtype=np.float64).reshape(len(rows), 2),
            "iterations": np.array([row.iterations for row in rows], dtype=np.int64),
            "escapes": np.array([row.escapes for row in rows], dtype=np.int64),
            "restarts": np.array([row.restarts for row in rows], dtype=np.int64),
            "seconds": np.array([row.seconds for row in rows], dtype=np.float64),
        }
        write_archive(path, header, arrays)
        self._rows = len(rows)

    def _read(self, path: Path) -> dict[int, BatchEntry]:
        from jtik._loop.batch import BatchEntry

        header, arrays = read_archive(path, "save", ACCEPTED)
        if header.get("kind") != KIND:
            raise ArgumentError("save", f"{path}, which holds no batch", ACCEPTED)
        if header.get("fingerprint") != self._fingerprint:
            raise ArgumentError("save", f"{path}, which holds another batch", ACCEPTED)
        try:
            columns = {name: arrays[name] for name in COLUMNS}
            rows = len(columns["indices"])
            if columns["q"].shape != (rows, self._nq) or columns["errors"].shape != (rows, 2):
                raise ValueError("shape")
            values = [columns[name].tolist() for name in COLUMNS]
            entries = {}
            for k, (i, _, status, converged, errors, *counts, seconds) in enumerate(zip(*values, strict=True)):
                iterations, escapes, restarts = counts
                diagnose, q = partial(Status, Status[status]), columns["q"][k].astype(np.float64)
                pair = float(errors[0]), float(errors[1])
                entries[int(i)] = BatchEntry(
                    q, diagnose, bool(converged), pair, int(iterations), int(escapes), int(restarts), float(seconds)
                )
            if entries and not 0 <= min(entries) <= max(entries) < self._count:
                raise ValueError("indices")
        except (KeyError, TypeError, ValueError) as error:
            raise ArgumentError("save", f"{path}, whose columns do not fit together", ACCEPTED) from error
        return entries
