"""Attempts in lanes: a solve for one target from several starts, side by side in the registers of one processor.

The caller's start and the restarts, in the order of their distance from the target, are tried at the same time
(formulations/restarts.md). Which attempt wins depends on the numbers of their iterations alone, neither on time nor on
the width of the registers. What is unusual, and a target that none of them reaches, is left to the search in Python,
which begins anew; so is a search of very many steps: Ctrl-C is obeyed then.
"""

from __future__ import annotations

import ctypes
import math
from functools import partial

import numpy as np

from jtik._loop.lanes.attempts_source import work_size
from jtik._loop.lanes.search import LaneLibrary, SearchMemory
from jtik._loop.native.search import NativeBatch, PreparedSearch
from jtik._loop.runner import Runner
from jtik._loop.search.full_turns import FullTurns
from jtik._loop.search.restarts import RestartConfigurations
from jtik._loop.search.search import IN_LANES, PATIENCE, SearchOptions
from jtik._loop.search.start_bank import StartBanks, aligned
from jtik._loop.search.starts import Starts
from jtik.types import Array


class LaneAttempts:
    """The attempts in lanes on memory of their own, with the inputs of a runner.

    Args:
        library: the search.
        runner: the runner of solves, whose target, parameters, limits and settings are read where they are.
        turns: the joints that can turn all the way round.
        starts: the restarts: by their distance from the target, or, where they depend on where a search begins, those
            of all searches.
        has_criterion: whether there is a criterion.

    Attributes:
        found: where the last search ended, one row.
        library: the search.
        prepared: what a native solve reads, after `prepare`.
    """

    def __init__(
        self,
        library: LaneLibrary,
        runner: Runner,
        turns: FullTurns,
        starts: StartBanks | RestartConfigurations,
        *,
        has_criterion: bool,
    ) -> None:
        self._has_criterion, self.library = has_criterion, library
        self._starts, self._memory = starts, SearchMemory(library, runner, turns, has_criterion=has_criterion)
        self.found = NativeBatch.of(1, len(self._memory.q0))
        self._work = aligned(work_size(library.function, library.level))
        self._table = np.zeros(5, dtype=np.uintp)
        found = self.found.q, self.found.errors, self.found.tallies, self._work
        self._table[:4] = [each.ctypes.data for each in found]
        self._call = getattr(library.loaded, f"{library.name}_attempts")
        integer, pointer = ctypes.c_longlong, ctypes.c_void_p
        self._call.argtypes = [pointer, pointer, integer, integer, integer, ctypes.c_double, pointer]
        self._call.restype = integer
        memory = self._memory
        self.prepared = PreparedSearch.of(memory.addresses, memory.q0, runner.inputs.target, self._table)
        self._options, self._restarts = SearchOptions(0, 0, 0), Starts(np.zeros((0, len(memory.q0))), 1, 0)
        self._run = partial(self._call, self._memory.address, None, 1, 0, 0, math.inf, self._table.ctypes.data)

    @property
    def depend_on_start(self) -> bool:
        """Whether the restarts depend on where a search begins: they are not known before `run`."""
        return isinstance(self._starts, RestartConfigurations)

    def prepare(self, options: SearchOptions, *, nearest: bool) -> None:
        """Set the options of `run`.

        Args:
            options: the options, with restarts.
            nearest: whether the attempt from q0 goes on where another one arrives before it, and wins if it arrives.
        """
        self._table[4] = nearest
        if self._options is not options:
            if isinstance(self._starts, StartBanks):
                bank = self._starts.of(options.seed)
                self._set(options, Starts(*bank.starts, bank))
            self._options = options

    def run(self, q0: Array) -> int:
        """Search from ``q0`` (nq,) for the target in memory; the result and what it returns are in `found`."""
        self._memory.q0[:] = q0
        if isinstance(self._starts, RestartConfigurations):
            self._set(self._options, Starts(*self._starts.block(self._options.seed, 1, q0)))
        return int(self._run())

    def _set(self, options: SearchOptions, restarts: Starts) -> None:
        """Set the restarts."""
        self._restarts = restarts  # kept alive
        patience = PATIENCE if self._has_criterion else IN_LANES
        order = restarts.address, restarts.first, min(restarts.last, options.restarts), options.limit, patience
        self._run = partial(self._call, self._memory.address, *order, self._table.ctypes.data)
        self.prepared.prepare(*order)
