"""Snapshots of a plan: the file is replaced atomically, and only what is new is turned into text."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import BinaryIO

from jtik.planner.attempts.attempt import Attempt
from jtik.planner.files.plan_file import Plan, attempt_pieces, write_atomically

CHUNK = 2**18
"""Characters that are copied at once."""


WORK = 1e-3
"""Time after which other threads are let run [s]."""


class Snapshots:
    """Writes one plan after the other to a file. Attempts never change: those of the last file are copied from it.

    Args:
        path: the file.
        pause: called often between pieces of work, to let other threads run.
    """

    def __init__(self, path: Path, pause: Callable[[], None]) -> None:
        self._path, self._pause = path, pause
        self._places: dict[int, tuple[Attempt, int, int]] = {}

    def write(self, plan: Plan, number: int) -> None:
        """Write a plan.

        Args:
            plan: the plan.
            number: number of the snapshot in the journal.

        Raises:
            OSError: when it cannot be written; the last one is then left as it is.
        """
        places: dict[int, tuple[Attempt, int, int]] = {}
        with suppress(FileNotFoundError), self._path.open("rb") as last:
            write_atomically(self._path, self._pieces(plan, number, last, places))
            self._places = places
            return
        write_atomically(self._path, self._pieces(plan, number, None, places))
        self._places = places

    def _pieces(
        self, plan: Plan, number: int, last: BinaryIO | None, places: dict[int, tuple[Attempt, int, int]]
    ) -> Iterator[str]:
        """The document; ``places`` gets where each attempt begins in it, and its length."""
        position, rested = 0, time.monotonic()

        def texts(attempt: Attempt) -> Iterator[str]:
            begin = position
            _, start, length = self._places.get(id(attempt), (attempt, 0, 0))
            yield from attempt_pieces(attempt) if last is None or not length else self._copied(last, start, length)
            places[id(attempt)] = attempt, begin, position - begin

        for piece in plan.pieces(texts, journal=number):
            yield piece
            position += len(piece)
            if time.monotonic() - rested > WORK:
                self._pause()
                rested = time.monotonic()

    def _copied(self, file: BinaryIO, start: int, length: int) -> Iterator[str]:
        """A part of an ASCII file. Raises OSError where it is shorter."""
        file.seek(start)
        while length > 0:
            piece = file.read(min(CHUNK, length))
            if not piece:
                self._places = {}  # the next one is written anew
                raise OSError("the last snapshot was cut off by somebody else")
            length -= len(piece)
            yield piece.decode("ascii")
