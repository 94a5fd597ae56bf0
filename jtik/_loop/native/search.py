"""The native search: attempts and restarts of a solve in one call of C, for a step in generated C.

Its results are bitwise equal to those of `jtik._loop.search.search`. Where an attempt stalls at a configuration that
may be singular, or a joint cannot be brought back within its limits by full turns, it stops, and the search in Python
takes over this attempt.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from jtik._loop.native.search_source import EXHAUSTED
from jtik._loop.runner import Runner
from jtik._loop.search.ends import Ends
from jtik._loop.search.full_turns import FullTurns
from jtik._loop.search.start_bank import SIZE
from jtik._loop.search.starts import Starts
from jtik._step.stopping import Code
from jtik.symbolic.compile import Library
from jtik.types import Array

MOST_ROWS = 4096
"""Most targets of one call: memory for all that are left is not needed again and again."""


class Tally(NamedTuple):
    """The counts of a search in C, in their order in memory.

    Attributes:
        iterations: calls that tried a step, of all attempts that ended.
        number: number of the last attempt.
        at: which memory of the runner holds q.
        calls: calls of the last attempt.
        best: number of the attempt with the smallest error, where there is a new one; else -1.
        code: code of the last call.
    """

    iterations: int
    number: int
    at: int
    calls: int
    best: int
    code: int


class NativeEnd(NamedTuple):
    """Where the search in C has stopped.

    Attributes:
        number: number of the last attempt.
        iterations: calls that tried a step, of the attempts before it.
        code: code of its last call; None where all attempts have ended without reaching the target.
        calls: calls of the last attempt.
        finished: whether the last attempt is over; else the search in Python takes it over.
    """

    number: int
    iterations: int
    code: Code | None
    calls: int
    finished: bool


class PreparedSearch(NamedTuple):
    """What a native solve reads of a search.

    Attributes:
        context: addresses of the memory of the search.
        order: address of the restarts, number of the first one, the last attempt, and most calls of an attempt.
        patience: calls without progress after which an attempt that a restart can replace ends, (1,).
        q0: where the search begins, (nq,).
        target: the numbers of its target.
        table: addresses of what else it reads and writes; empty where it has nothing else.
    """

    context: NDArray[np.uintp]
    order: NDArray[np.int64]
    patience: Array
    q0: Array
    target: Array
    table: NDArray[np.uintp]

    @classmethod
    def of(cls, context: NDArray[np.uintp], q0: Array, target: Array, table: NDArray[np.uintp]) -> PreparedSearch:
        """A search that is not prepared yet."""
        return cls(context, np.zeros(4, dtype=np.int64), np.zeros(1), q0, target, table)

    def prepare(self, starts: int | None, first: int, last: int, limit: int, patience: float) -> None:
        """Set the options; ``starts`` is the address of the restarts, None without any."""
        self.order[:], self.patience[0] = (starts or 0, first, last, limit), patience


class NativeSearch:
    """The search in C on the memory of a runner, whose step is in generated C.

    Args:
        library: the step and the search as a shared library.
        runner: the runner.
        turns: the joints that can turn all the way round.
        has_criterion: whether there is a criterion.

    Attributes:
        library: as given.
        runner: the runner.
        q0: where a search begins, (nq,).
        counts: iterations, restarts used, and which memory of the runner holds q, after a search that converged.
        run_prepared: the search that `prepare` has described, without arguments.
        prepared: the same for a native solve.
    """

    def __init__(self, library: Library, runner: Runner, turns: FullTurns, *, has_criterion: bool) -> None:
        self.runner = runner
        self.library, self._turns, self._has_criterion = library, turns, has_criterion
        nq = len(runner.q[0])
        self.q0 = np.zeros(nq)
        self._tally = np.zeros(len(Tally._fields), dtype=np.int64)
        self.counts = self._tally[:3]
        self._best_V, self._best, self._first = np.zeros(1), np.zeros(nq), np.zeros(nq)
        function, inputs = library.function, runner.inputs
        arguments = np.zeros(function.sz_arg(), dtype=np.uintp)
        results = np.zeros(function.sz_res(), dtype=np.uintp)
        integers = np.zeros(max(function.sz_iw(), 1), dtype=np.int64)
        reals = np.zeros(max(function.sz_w(), 1))
        arguments[1 : 1 + len(inputs)] = [array.ctypes.data if array.size else 0 for array in inputs]
        memory = [arguments, results, integers, reals, *runner.q, *runner.state, runner.outcome, runner.first_state]
        memory += [inputs.settings, self._tally, self.q0]
        limits = [turns.indices, turns.lower, turns.upper]
        ends = [self._best_V, self._best, self._first]
        counts = [nq, len(runner.first_state), len(turns.indices), int(has_criterion)]
        self._keys = np.zeros(SIZE, dtype=np.int32)
        order = [inputs.target.size, self._keys.ctypes.data]
        at = [*_addresses(memory), *counts, *_addresses(limits), *_addresses(ends), *order]
        self._context = np.array(at, dtype=np.uintp)
        self._count = len(memory) + 2, len(turns.indices)
        self._kept = (memory, inputs, limits)
        self._call = getattr(library.loaded, f"{library.name}_search")
        integer = ctypes.c_longlong
        self._call.argtypes = [ctypes.c_void_p, ctypes.c_void_p, integer, integer, integer, integer, ctypes.c_double]
        self._call.restype = integer
        self._address = self._context.ctypes.data
        self.prepared = PreparedSearch.of(self._context, self.q0, inputs.target, np.zeros(0, dtype=np.uintp))
        self._prepared_starts: Starts | None = None
        self.run_prepared: Callable[[], int] = partial(self._call, self._address, None, 1, 0, 0, 0, math.inf)
        self._batch = getattr(library.loaded, f"{library.name}_batch")
        self._batch.argtypes = [*self._call.argtypes[:2], integer, integer, integer, ctypes.c_double, ctypes.c_void_p]
        self._batch.restype = integer

    def beside(self) -> NativeSearch:
        """A search on memory of its own, for another thread, with the parameters, limits and settings of this one."""
        inputs = self.runner.inputs._replace(target=self.runner.inputs.target.copy())
        runner = Runner(self.runner.fused, inputs, len(self.q0))
        return NativeSearch(self.library, runner, self._turns, has_criterion=self._has_criterion)

    @property
    def turning(self) -> bool:
        """Whether joints are brought back by full turns."""
        return bool(self._context[self._count[0]])

    @turning.setter
    def turning(self, on: bool) -> None:
        self._context[self._count[0]] = self._count[1] if on else 0

    def prepare(self, starts: Starts | None, last: int, limit: int, patience: float) -> None:
        """Set the options of ``run_prepared()``, which searches from the content of `q0` and returns as `find` does.

        Args:
            starts: the restart configurations; None without restarts.
            last: the last attempt.
            limit: most calls of an attempt.
            patience: calls without progress after which an attempt that a restart can replace ends.
        """
        self._prepared_starts = starts  # kept alive
        self.prepared.prepare(*_of(starts), last, limit, patience)
        self.run_prepared = partial(self._call, self._address, *_of(starts), 0, last, limit, patience)

    def find(
        self,
        q0: Array,
        starts: Starts | None,
        numbers: tuple[int, int],
        ends: Ends,
        limit: int,
        patience: float,
    ) -> int:
        """Search from ``q0``, or from restarts.

        Args:
            q0: where to begin, (nq,).
            starts: the restart configurations; None without restarts.
            numbers: the first attempt to run, and the last.
            ends: where the attempts before have ended.
            limit: most calls of an attempt.
            patience: calls without progress after which an attempt that a restart can replace ends.

        Returns:
            What `end` reads.
        """
        self.q0[:] = q0
        if ends.best is not None:
            self._best_V[0] = ends.best[0][0]
        number, last = numbers
        return int(self._call(self._address, *_of(starts), number, last, limit, patience))

    def end(self, returned: int, ends: Ends) -> NativeEnd:
        """Where the search has stopped that ``returned`` this; the ends of its attempts are added to ``ends``."""
        tally = Tally(*self._tally.tolist())
        self.runner.at = tally.at
        exhausted = returned == EXHAUSTED
        if ends.first is None and (tally.number > 0 or exhausted):
            ends.first = self._first.copy()
        if tally.best >= 0:
            ends.best = (float(self._best_V[0]),), tally.best, self._best.copy()
        finished = returned >= 0
        before = tally.iterations - (tally.calls if finished else 0)
        code = None if exhausted else _CODES[tally.code]
        return NativeEnd(tally.number, before, code, tally.calls, finished)

    def batch(
        self,
        targets: Array,
        q0: Array,
        starts: Starts | None,
        last: int,
        limit: int,
        patience: float,
    ) -> NativeBatch:
        """Search for the first rows of ``targets`` (k, size), from ``q0``: (1, nq) for all, or (k, nq).

        It ends after the target that it is at when a tenth of a second is over; at least one.
        """
        count = min(len(targets), MOST_ROWS)
        found = NativeBatch.of(count, len(self.q0))
        arrays = [np.ascontiguousarray(targets[:count]), np.ascontiguousarray(q0), *found]
        sizes = [count, targets.shape[1], len(self.q0) if len(q0) > 1 else 0]
        table = np.array([*_addresses(arrays), *sizes], dtype=np.uintp)
        done = self._batch(self._address, *_of(starts), last, limit, patience, table.ctypes.data)
        return found.first(done)


def _of(starts: Starts | None) -> tuple[int | None, int]:
    """What the search in C reads of restart configurations, and the number of the first one."""
    return (None, 1) if starts is None else (starts.address, starts.first)


def _addresses(arrays: list[Any]) -> list[int]:
    return [array.ctypes.data for array in arrays]


class NativeBatch(NamedTuple):
    """Where the searches for k targets ended.

    Attributes:
        q: configurations, (k, nq).
        errors: norms of position [m] and orientation [rad] rows, (k, 2).
        seconds: wall time of each, (k,) [s].
        tallies: code, iterations and restarts of each, (k, 3).
    """

    q: Array
    errors: Array
    seconds: Array
    tallies: NDArray[np.int64]

    @classmethod
    def of(cls, count: int, nq: int) -> NativeBatch:
        """Memory for ``count`` searches."""
        return cls(np.zeros((count, nq)), np.zeros((count, 2)), np.zeros(count), np.zeros((count, 3), dtype=np.int64))

    def first(self, count: int) -> NativeBatch:
        """The first ones."""
        return NativeBatch._make(column[:count] for column in self)


_CODES = tuple(Code)
