"""The search in lanes: several targets of a batch at the same time, side by side in the registers of one processor.

Each lane follows the rules of `jtik._loop.search.search` with a target, a state and restarts of its own; where its
search ends it takes the next target. What a lane holds does not change what the others compute. Sine and cosine are not
those of the C library, so that results differ from those of the other searches by rounding. What is unusual is left to
the search in Python, as by the native search, and so is a search of very many steps. After a tenth of a second a call
begins no more searches, and returns when those that it has begun have ended: Ctrl-C is obeyed then. What it finds does
not depend on time.

Restarts come in the order of their distance from the target (`jtik._loop.search.start_bank`, formulations/restarts.md).
With restarts, and without a criterion, the steps are those of `Strategy.in_lanes`; where none of the attempts reaches
the target, the search in Python begins anew. The search is then made in single precision first, which ends close to the
target, and continued in double precision; where single precision does not come close, double precision begins anew.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from jtik._loop.lanes import matrices_source
from jtik._loop.lanes.search_source import COARSE, source, work_size
from jtik._loop.native.search import NativeBatch
from jtik._loop.runner import Runner
from jtik._loop.search.full_turns import FullTurns
from jtik._loop.search.start_bank import SIZE, StartBank, StartBanks, aligned
from jtik._loop.search.starts import Starts
from jtik._step.fused_step import FusedStep
from jtik.symbolic import Function
from jtik.symbolic.compile import Beside, plain_libraries, plain_library
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.lanes.maths import EXACT, LEVELS, PROBE, Level
from jtik.symbolic.lanes.source import has_lanes
from jtik.types import Array

MOST_ROWS = 65536
"""Most targets of one call: at its end some lanes have nothing to do."""

BLOCKS = 2
"""Number of blocks a thread: searches in lanes take about as long as each other, and what is in Python waits for it."""

ROUNDING = 0.25
"""Largest rounding with which a search begins in single precision, relative to the errors with which it ends."""


class LaneLibrary(NamedTuple):
    """The search in lanes for one step.

    Attributes:
        function: the step.
        first_state: the state that a search begins with.
        level: the instructions that it uses.
        loaded: its shared library.
        name: the beginning of its names.
        single: the same of the search in single precision, with which searches that have restarts begin; None without.
    """

    function: Function
    first_state: Array
    level: Level
    loaded: ctypes.CDLL
    name: str
    single: tuple[ctypes.CDLL, str] | None


def lane_library(
    fused: FusedStep, level: Level, beside: Beside, *, single: bool, reader: Function | None
) -> LaneLibrary | None:
    """The search in lanes, compiled now; None for a step that calls a solver or Python, or cannot be written so.

    Args:
        fused: the step.
        level: the instructions that it uses.
        beside: what is compiled with it.
        single: whether to have the search in single precision, too.
        reader: reads a matrix as a target; None without.

    Raises:
        CompilerError: without a compiler.
    """
    function = fused.expressions
    if function is None or not has_lanes(function):
        return None
    called = c_source(*beside.functions) if beside.functions else ""
    own = source(function, fused.state, level, refines=single) + matrices_source.source(reader)
    codes = [called + own + beside.source]
    codes += [source(function, fused.state, level, single=True)] if single else []
    first, *others = plain_libraries(codes, EXACT)
    return LaneLibrary(function, fused.first_state, level, *first, others[0] if others else None)


def highest_with(lanes: float) -> Level:
    """The highest of `LEVELS` that this machine has, with so many lanes at most.

    Raises:
        CompilerError: without a compiler.
    """
    return [level for level in LEVELS[: highest_level() + 1] if level.lanes <= lanes][-1]


@cache
def highest_level() -> int:
    """The number of the highest of `LEVELS` that this machine has.

    Raises:
        CompilerError: without a compiler.
    """
    loaded, name = plain_library(PROBE)
    return int(getattr(loaded, f"{name}_level")())


class SearchMemory:
    """What every search in lanes reads: the inputs of a runner, and where it begins.

    Args:
        library: the search.
        runner: the runner of solves, whose parameters, limits and settings are read where they are.
        turns: the joints that can turn all the way round.
        has_criterion: whether there is a criterion.

    Attributes:
        q0: where a search begins, (nq,).
        addresses: of all it reads, in the order of `jtik._loop.native.search.NativeSearch`.
        address: the address of these.
    """

    def __init__(self, library: LaneLibrary, runner: Runner, turns: FullTurns, *, has_criterion: bool) -> None:
        inputs, self.q0 = runner.inputs, np.zeros(len(runner.q[0]))
        pointers = np.array([0, *(array.ctypes.data if array.size else 0 for array in inputs)], dtype=np.uintp)
        first_state, limits = library.first_state.copy(), [turns.indices, turns.lower, turns.upper]
        at = np.zeros(20, dtype=np.uintp)
        at[[0, 9, 10, 12]] = [each.ctypes.data for each in (pointers, first_state, inputs.settings, self.q0)]
        at[13:17] = [len(self.q0), len(first_state), len(turns.indices), int(has_criterion)]
        at[17:20] = [each.ctypes.data for each in limits]
        self.addresses, self.address = at, at.ctypes.data
        self._kept = pointers, first_state, limits, inputs


class LaneSearch:
    """The search in lanes on memory of its own, with the inputs of a runner.

    Args:
        library: the search.
        runner: the runner of solves, whose parameters, limits and settings are read where they are.
        turns: the joints that can turn all the way round.
        has_criterion: whether there is a criterion.
        banks: the restarts by their distance from the target; None for those of all searches.

    Attributes:
        runner: the runner.
        banks: as given.
    """

    def __init__(
        self,
        library: LaneLibrary,
        runner: Runner,
        turns: FullTurns,
        *,
        has_criterion: bool,
        banks: StartBanks | None = None,
    ) -> None:
        self.runner, self.banks, self._arguments = runner, banks, (library, runner, turns)
        self._has_criterion = has_criterion
        self._nq = len(runner.q[0])
        self._memory = SearchMemory(library, runner, turns, has_criterion=has_criterion)
        inputs = sum(array.size for array in runner.inputs)
        self._work = aligned(work_size(library.function, library.level) + library.level.lanes * SIZE + inputs)
        self._call = _search_of(library.loaded, library.name)
        self._call_in_single = _search_of(*library.single) if library.single else None
        self._read = getattr(library.loaded, f"{library.name}_matrices", None)
        if self._read is not None:
            self._read.argtypes = [ctypes.c_void_p, ctypes.c_longlong, ctypes.c_void_p]
            self._read.restype = ctypes.c_longlong
        self._latest: tuple[StartBank | None, bool] = None, False

    def read_matrices(self, targets: Array) -> Array | None:
        """As `jtik.Task.read_matrices`, for matrices in one piece of memory."""
        if self._read is None or not targets.flags.c_contiguous:
            return None
        numbers = np.empty((len(targets), self.runner.inputs.target.size))
        return numbers if self._read(targets.ctypes.data, len(targets), numbers.ctypes.data) else None

    def beside(self) -> LaneSearch:
        """A search on memory of its own, for another thread."""
        return LaneSearch(*self._arguments, has_criterion=self._has_criterion, banks=self.banks)

    def batch(
        self,
        targets: Array,
        q0: Array,
        starts: Starts | None,
        last: int,
        limit: int,
        patience: float,
    ) -> NativeBatch:
        """As `jtik._loop.native.search.NativeSearch.batch`."""
        found = NativeBatch.of(min(len(targets), MOST_ROWS), self._nq)
        arguments = self._arguments_of(found, targets[: len(found.q)], q0, starts, (max(last, 0), limit, patience))
        if starts is not None and starts.bank is not None and self._begins_in_single_precision(starts.bank):
            arguments.table[6], _ = self._in_single_precision(arguments)
        return found.first(self._call(*arguments.of_call))

    def _arguments_of(
        self,
        found: NativeBatch,
        targets: Array,
        q0: Array,
        starts: Starts | None,
        order: tuple[int, int, float],
    ) -> _Arguments:
        """Those of `batch` as the search in C takes them, with ``found`` for what it finds.

        ``order`` has the number of the last restart, the limit of iterations and the patience.
        """
        arrays = [np.ascontiguousarray(targets), np.ascontiguousarray(q0), *found]
        sizes = [len(targets), targets.shape[1], self._nq if len(q0) > 1 else 0, self._work.ctypes.data]
        table = np.array([*(each.ctypes.data for each in arrays), *sizes, 0], dtype=np.uintp)
        address, first = (None, 1) if starts is None else (starts.address, starts.first)
        of_call = self._memory.address, address, first, *order, table.ctypes.data
        return _Arguments(table, of_call, [*arrays, starts])

    def _in_single_precision(self, arguments: _Arguments) -> tuple[int, NDArray[np.int64]]:
        """Search in single precision; how many searches have ended, and after how many steps close to the target."""
        assert self._call_in_single is not None
        arrived_after = np.empty(arguments.table[6], dtype=np.int64)
        arguments.kept.append(arrived_after)
        arguments.table[10] = arrived_after.ctypes.data
        return self._call_in_single(*arguments.of_call), arrived_after

    def _begins_in_single_precision(self, bank: StartBank) -> bool:
        """Whether there is a search in single precision, and its rounding is small.

        At each configuration of the bank the error from the target that it meets is rounding alone.
        """
        if self._call_in_single is None:
            return False
        if self._latest[0] is not bank:
            begin, small = 0, True
            while begin < len(bank.numbers) and small:
                numbers, at = bank.numbers[begin:], bank.configurations[begin:]
                found = NativeBatch.of(len(at), self._nq)
                arguments = self._arguments_of(found, numbers, at, Starts(at, 1, 0), (0, 1, math.inf))
                done, arrived_after = self._in_single_precision(arguments)
                at_once, errors = arrived_after[:done] == 0, found.errors[:done]
                small, begin = bool(at_once.all() and (errors <= ROUNDING * COARSE).all()), begin + done
            self._latest = bank, small
        return self._latest[1]


class _Arguments(NamedTuple):
    """Arguments of a search in C.

    Attributes:
        table: of addresses and sizes.
        of_call: the arguments.
        kept: what they point to.
    """

    table: NDArray[np.uintp]
    of_call: tuple[int | float | None, ...]
    kept: list[Any]


def _search_of(loaded: ctypes.CDLL, name: str) -> Callable[..., int]:
    """The search in C."""
    call = getattr(loaded, f"{name}_lanes")
    integer, pointer = ctypes.c_longlong, ctypes.c_void_p
    call.argtypes = [pointer, pointer, integer, integer, integer, ctypes.c_double, pointer]
    call.restype = integer
    return cast(Callable[..., int], call)
