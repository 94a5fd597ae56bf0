"""The solves in C of one solver: each leaves what is not usual for it to the next, the last one to Python."""

from __future__ import annotations

import ctypes
from typing import Any, Protocol

import numpy as np

from jtik._loop.exclusive_use import ExclusiveUse
from jtik._loop.native.search import PreparedSearch
from jtik._loop.native.solve import Call, NativeSolve
from jtik._loop.solutions import Solutions
from jtik.types import Array


class SearchInC(Protocol):
    """A search that a native solve can run."""

    @property
    def prepared(self) -> PreparedSearch:
        """What it reads."""

    @property
    def library(self) -> SearchLibrary:
        """Its library."""


class SearchLibrary(Protocol):
    """The library of a search, with a native solve."""

    @property
    def loaded(self) -> ctypes.CDLL:
        """The shared library."""

    @property
    def name(self) -> str:
        """The beginning of its names."""


class NativeSolves:
    """The solves in C.

    Args:
        home: where a solve begins without a q0, (nq,).
        solutions: the Solutions of the solver.
        exclusive: the guard of the solver.
        otherwise: solves in Python.
        possible: whether there can be any.

    Attributes:
        call: solves, in C where it can.
    """

    def __init__(
        self, home: Array, solutions: Solutions, exclusive: ExclusiveUse, otherwise: Call, *, possible: bool
    ) -> None:
        self._ended = np.zeros(1, dtype=np.int64), np.zeros(1)
        self._of_all, self._otherwise, self._possible = (home, solutions, exclusive, self._ended), otherwise, possible
        self._search: NativeSolve | None = None
        self._lanes: NativeSolve | None = None
        self.call = otherwise

    @property
    def ended(self) -> tuple[int, float]:
        """What a search has returned that has not converged, and the time since the call [s]."""
        returned, elapsed = self._ended
        return int(returned[0]), float(elapsed[0])

    def by_search(self, search: SearchInC | None, go_on: Call) -> None:
        """Solve by a search for one start after the other; None for none.

        Args:
            search: the search.
            go_on: is called after one that has not converged.
        """
        self._search = self._made(search, go_on) if search else None
        self._chain()

    def by_lanes(self, attempts: SearchInC, go_on: Call) -> None:
        """The same by attempts side by side, the first time that it is called."""
        if self._lanes is None:
            self._lanes = self._made(attempts, go_on)
            self._chain()

    def _made(self, search: SearchInC, go_on: Call) -> NativeSolve | None:
        library = search.library
        if not self._possible:
            return None
        return NativeSolve(library.loaded, library.name, search.prepared, *self._of_all, go_on)

    def _chain(self) -> None:
        call = self._otherwise
        for native in (self._lanes, self._search):
            call = native.before(call) if native else call
        self.call = call

    def forget(self) -> None:
        """Leave every call without lanes to Python, until one is known."""
        if self._search:
            self._search.forget()

    def forget_lanes(self) -> None:
        """The same for calls with lanes."""
        if self._lanes:
            self._lanes.forget()

    def know(self, options: tuple[Any, ...]) -> None:
        """The search is prepared for these options, without lanes."""
        if self._search:
            self._search.know((False, False, False, *options))

    def know_lanes(self, options: tuple[Any, ...], nearest: bool) -> None:
        """The attempts are prepared for these options."""
        if self._lanes:
            self._lanes.know((True, nearest, False, *options))
