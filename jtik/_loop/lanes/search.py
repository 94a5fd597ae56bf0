"""The search in lanes: several targets of a batch at the same time, side by side in the registers of one processor.

Each lane follows the rules of `jtik._loop.search.search` with a target, a state and restarts of its own; where its
search ends it takes the next target. What a lane holds does not change what the others compute. Sine and cosine are not
those of the C library, so that results differ from those of the other searches by rounding. What is unusual is left to
the search in Python, as by the native search, and so is a search that goes on for more than a tenth of a second after
all others of its call: Ctrl-C is obeyed then.

Restarts come in the order of their distance from the target (`jtik._loop.search.start_bank`, formulations/restarts.md).
With restarts, and without a criterion, the steps are those of `Strategy.in_lanes`; where none of the attempts reaches
the target, the search in Python begins anew. The search is then made in single precision first, which ends close to the
target, and continued in double precision; where single precision does not come close, double precision begins anew.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache, partial
from typing import NamedTuple, cast

import numpy as np

from jtik._loop.lanes.search_source import source, work_size
from jtik._loop.native.search import NativeBatch
from jtik._loop.runner import Runner
from jtik._loop.search.full_turns import FullTurns
from jtik._loop.search.start_bank import SIZE, StartBank, StartBanks, aligned
from jtik._step.fused_step import FusedStep
from jtik.symbolic import Function
from jtik.symbolic.compile import NOTHING, Beside, plain_library
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.lane_maths import EXACT, LEVELS, PROBE, Level
from jtik.symbolic.lane_source import has_lanes
from jtik.types import Array

MOST_ROWS = 16384
"""Most targets of one call: at its end some lanes have nothing to do."""


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


def lane_library(fused: FusedStep, level: Level, beside: Beside = NOTHING, *, single: bool) -> LaneLibrary | None:
    """The search in lanes, compiled now; None for a step that calls a solver or Python, or cannot be written so.

    Args:
        fused: the step.
        level: the instructions that it uses.
        beside: what is compiled with it.
        single: whether to have the search in single precision, too.

    Raises:
        CompilerError: without a compiler.
    """
    function = fused.expressions
    if function is None or not has_lanes(function):
        return None
    called = c_source(*beside.functions) if beside.functions else ""
    codes = [called + source(function, fused.state, level) + beside.source]
    codes += [source(function, fused.state, level, single=True)] if single else []
    with ThreadPoolExecutor(len(codes)) as pool:
        first, *others = pool.map(partial(plain_library, more=EXACT), codes)
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

    def beside(self) -> LaneSearch:
        """A search on memory of its own, for another thread."""
        return LaneSearch(*self._arguments, has_criterion=self._has_criterion, banks=self.banks)

    def batch(
        self,
        targets: Array,
        q0: Array,
        starts: Array | None,
        first: int,
        last: int,
        limit: int,
        patience: float,
        bank: StartBank | None = None,
    ) -> NativeBatch:
        """As `jtik._loop.native.search.NativeSearch.batch`; ``starts`` are those of ``bank``, where there is one."""
        found = NativeBatch.of(min(len(targets), MOST_ROWS), self._nq)
        count = len(found.q)
        arrays = [np.ascontiguousarray(targets[:count]), np.ascontiguousarray(q0), *found]
        sizes = [targets.shape[1], self._nq if len(q0) > 1 else 0, self._work.ctypes.data]
        order = [bank.coefficients.ctypes.data, len(bank.configurations)] if bank else [0, 0]
        table = np.array([*(each.ctypes.data for each in arrays), count, *sizes, *order, 0], dtype=np.uintp)
        options = first, max(last, 0), limit, patience, table.ctypes.data
        starts_at = None if starts is None else starts.ctypes.data
        if self._call_in_single and starts_at:
            arrived_after = np.empty(count, dtype=np.int64)
            coefficients = bank.in_single_precision() if bank else np.empty(0)
            table[10], table[12] = coefficients.ctypes.data, arrived_after.ctypes.data
            table[6] = self._call_in_single(self._memory.address, starts_at, *options)
            table[10] = order[0]
        done = self._call(self._memory.address, starts_at, *options)
        return found.first(done)


def _search_of(loaded: ctypes.CDLL, name: str) -> Callable[..., int]:
    """The search in C."""
    call = getattr(loaded, f"{name}_lanes")
    integer, pointer = ctypes.c_longlong, ctypes.c_void_p
    call.argtypes = [pointer, pointer, integer, integer, integer, ctypes.c_double, pointer]
    call.restype = integer
    return cast(Callable[..., int], call)
