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
    from jtik._loop.batch.rows import BatchRows

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

    Attributes:
        known: the rows that the file already had.

    Raises:
        ArgumentError: for a file that holds something else.
    """

    def __init__(self, path: str | Path | None, identity: Any, count: int, nq: int) -> None:
        self._path = None if path is None else checked_path(path, "save")
        self._count, self._nq = count, nq
        self._fingerprint = "" if path is None else fingerprint(identity)
        self._written, self._pause, self._rows = time.monotonic(), PAUSE, 0
        self.known = self._read()
        self._rows = len(self.known.numbers)

    def add(self, parts: list[BatchRows]) -> None:
        """Write all rows, unless the last write was recent. ``parts`` is then one part, whose statuses are known."""
        if self._path is None or time.monotonic() - self._written < self._pause:
            return
        begin = time.monotonic()
        with suppress(OSError):  # perhaps there is room later; the last write reports it
            self._write(self._path, parts)
        self._written = time.monotonic()
        self._pause = max(PAUSE, (self._written - begin) / SHARE)

    def write(self, parts: list[BatchRows]) -> None:
        """Write all rows, as `add` does; a warning says why where that is not possible."""
        if self._path is None or (self._rows == sum(len(part.numbers) for part in parts) and self._path.exists()):
            return
        try:
            self._write(self._path, parts)
        except OSError as error:
            warnings.warn(f"the batch was not saved: {error}", RuntimeWarning, stacklevel=callers_level())

    def _write(self, path: Path, parts: list[BatchRows]) -> None:
        from jtik._loop.batch.rows import BatchRows

        rows = BatchRows.joined(parts, self._nq).settled()
        parts[:] = [rows]
        names = [rows.diagnose[i]().name if i in rows.diagnose else "CONVERGED" for i in rows.numbers.tolist()]
        header = {"kind": KIND, "fingerprint": self._fingerprint, "targets": self._count}
        arrays = {
            "indices": rows.numbers,
            "q": rows.q,
            "status": np.array(names, dtype=str),
            "converged": rows.converged,
            "errors": rows.errors,
            "iterations": rows.counts[:, 0],
            "escapes": rows.counts[:, 1],
            "restarts": rows.counts[:, 2],
            "seconds": rows.seconds,
        }
        write_archive(path, header, arrays)
        self._rows = len(names)

    def _read(self) -> BatchRows:
        from jtik._loop.batch.rows import BatchRows

        path = self._path
        if path is None or not path.exists():
            return BatchRows.joined([], self._nq)
        header, arrays = read_archive(path, "save", ACCEPTED)
        if header.get("kind") != KIND:
            raise ArgumentError("save", f"{path}, which holds no batch", ACCEPTED)
        if header.get("fingerprint") != self._fingerprint:
            raise ArgumentError("save", f"{path}, which holds another batch", ACCEPTED)
        try:
            columns = {name: arrays[name] for name in COLUMNS}
            numbers = columns["indices"].astype(np.int64)
            rows = len(numbers)
            if columns["q"].shape != (rows, self._nq) or columns["errors"].shape != (rows, 2):
                raise ValueError("shape")
            if any(column.shape[:1] != (rows,) for column in columns.values()):
                raise ValueError("length")
            statuses = [Status[name] for name in columns["status"].tolist()]
            if rows and not 0 <= numbers.min() <= numbers.max() < self._count:
                raise ValueError("indices")
            counts = [columns[name].astype(np.int64) for name in ("iterations", "escapes", "restarts")]
            return BatchRows(
                numbers,
                columns["q"].astype(np.float64),
                columns["converged"].astype(bool),
                columns["errors"].astype(np.float64),
                np.stack(counts, axis=1),
                columns["seconds"].astype(np.float64),
                {i: partial(Status, status) for i, status in zip(numbers.tolist(), statuses, strict=True)},
            )
        except (KeyError, TypeError, ValueError) as error:
            raise ArgumentError("save", f"{path}, whose columns do not fit together", ACCEPTED) from error
