"""The searches of a solver in lanes, compiled when first used: for several targets, and from several starts."""

from __future__ import annotations

import math

from jtik._loop.lanes import attempts_source
from jtik._loop.lanes.attempts import LaneAttempts
from jtik._loop.lanes.attempts_source import TOGETHER
from jtik._loop.lanes.search import LaneLibrary, LaneSearch, highest_with, lane_library
from jtik._loop.native import solve_source
from jtik._loop.runners import Runners
from jtik._loop.search.restarts import RestartConfigurations
from jtik._step.fused_step import fused_step
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.errors import ArgumentError
from jtik.strategy import Strategy
from jtik.strategy.checked_call import CheckedCall
from jtik.symbolic.compile import NOTHING
from jtik.types import Array


class Lanes:
    """Makes the searches in lanes.

    Without a criterion attempts that a restart can replace take the steps of `Strategy.in_lanes`.

    Args:
        problem: what the solver solves.
        strategy: its strategy.
        runners: its runners.
    """

    def __init__(self, problem: SymbolicProblem, strategy: Strategy, runners: Runners) -> None:
        self._problem, self._strategy, self._runners = problem, strategy, runners
        self._searches: dict[bool, LaneSearch] = {}
        self._attempts: LaneAttempts | None = None

    def search(self, *, restarts: bool) -> LaneSearch:
        """The search for several targets side by side.

        Args:
            restarts: whether it has restarts.

        Raises:
            ArgumentError: where the strategy has none.
            CompilerError: without a compiler.
        """
        if restarts not in self._searches:
            problem, runners = self._problem, self._runners
            banks, has_criterion = runners.banks if restarts else None, problem.has_criterion
            library = self._library(replaceable=banks is not None and not has_criterion, lanes=math.inf, single=True)
            made = LaneSearch(library, runners.solve, runners.turns, has_criterion=has_criterion, banks=banks)
            self._searches[restarts] = made
        return self._searches[restarts]

    def read_matrices(self, targets: Array) -> Array | None:
        """The numbers of many matrices (k, 4, 4) in C, (k, target size); None where no search is compiled that can.

        Args:
            targets: the targets.
        """
        found = (search.read_matrices(targets) for search in self._searches.values())
        return next(found, None)

    @property
    def attempts(self) -> LaneAttempts:
        """The attempts for one target side by side.

        Raises:
            ArgumentError: where the strategy has none.
            CompilerError: without a compiler.
        """
        if self._attempts is None:
            has_criterion, runners = self._problem.has_criterion, self._runners
            library = self._library(replaceable=not has_criterion, lanes=TOGETHER)
            starts = runners.banks or RestartConfigurations(self._problem.robot)
            self._attempts = LaneAttempts(library, runners.solve, runners.turns, starts, has_criterion=has_criterion)
        return self._attempts

    def _library(self, *, replaceable: bool, lanes: float, single: bool = False) -> LaneLibrary:
        """The code for these steps, with so many lanes at most.

        With ``single`` the steps of `Strategy.in_lanes` are there in single precision, too. Those of the strategy
        itself are not, whose result is that of `solve`; nor are quaternions, which rounding makes longer or shorter.
        """
        problem, own, level = self._problem, self._strategy, highest_with(lanes)
        fused = self._runners.of_lanes
        strategy: Strategy = CheckedCall(own, own, "in_lanes")(Strategy) if replaceable else own  # type: ignore[type-abstract]
        differs = strategy is not own and fused.expressions is not None
        single = single and differs and problem.robot.nq == problem.robot.n

        def build() -> LaneLibrary | None:
            beside = NOTHING
            if self._runners.has_native_step:
                beside = solve_source.beside(problem.tasks, attempts_source.RUN)
            step = fused_step(problem, strategy, replaceable=True) if differs else fused
            return lane_library(step, level, beside, single=single, reader=problem.tasks.matrix_reader)

        library = problem.once(f"lanes, {differs=}, {level}, {single=}", build)
        if library is None:
            only = "True where a step is expressions alone: no quadratic program, nothing computed in Python"
            raise ArgumentError("lanes", True, f"False; {only}")
        return library
