"""The engine of a solver: its compiled functions, their memory, and what runs on them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from jtik._loop.arguments import ConfigurationReader
from jtik._loop.escapes.criterion import CriterionEscape, Escapes, StepEscape
from jtik._loop.escapes.saddle import SaddleEscape
from jtik._loop.exclusive_use import ExclusiveUse, in_use
from jtik._loop.inspection import Inspector
from jtik._loop.jogging import Jogging
from jtik._loop.lanes.lanes import Lanes
from jtik._loop.minimum_certificate import MinimumCertificate
from jtik._loop.native.compile_ahead import CompileAhead
from jtik._loop.native.search import NativeSearch
from jtik._loop.options import Compiled, read_compiled, read_rate
from jtik._loop.runners import SOLVE, Runners
from jtik._loop.search.attempts import Attempts
from jtik._loop.search.search import Search
from jtik._loop.solving import Solving
from jtik._loop.stepping import Stepping
from jtik._loop.target_memory import TargetMemory
from jtik._step.inputs import InputMemory
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints import Clearance, Limits
from jtik.criterion import CriterionSum, CriterionTerms
from jtik.criterion.trial import check_compiled, check_finite
from jtik.errors import ArgumentError
from jtik.progress import Progress, counted
from jtik.qp import Backend, as_problem, backend_of
from jtik.registry import supporting_clearances
from jtik.result.report import Report
from jtik.robot import Robot, WeightedCoordinates
from jtik.strategy import Strategy
from jtik.strategy.checked_call import CheckedCall
from jtik.symbolic.compilation.several_files import Compilation
from jtik.task import TaskStack
from jtik.types import Array

if TYPE_CHECKING:
    import qpsolvers


class Engine:
    """Assembles what `InverseKinematics` runs.

    Args:
        robot: the robot.
        tasks: the tasks.
        limits: limits of position, velocity and acceleration.
        strategy: the strategy.
        criteria: the criteria.
        clearances: the clearances.
        solver: what solves its QPs, or None for the default.
        compiled: whether the step runs as generated C.
        null_space_rate: rate of the motion in the null space in timed steps [1/s].
        weights: weights of the velocity entries (n,); None for none.
        original: the problem of an engine of the same arguments, whose functions are used; None for a new one.
        compilation: compiles the functions, and reports it.

    Attributes:
        problem: robot, tasks, criteria and clearances.
        memory: the inputs of `solve`.
        runners: the fused step in its variants.
        configurations: reads configurations.
        search: finds the configuration for a target.
        stepping: what ``step`` runs.
        jogging: what ``jog`` runs.
        solving: what ``solve``, ``solve_batch`` and ``track`` run.

    Raises:
        ArgumentError: for clearances that the strategy does not support, a solver that it does not use, or no bool.
    """

    def __init__(
        self,
        robot: Robot,
        tasks: TaskStack,
        limits: Limits,
        strategy: Strategy,
        *,
        criteria: CriterionSum,
        clearances: tuple[Clearance, ...],
        solver: str | Backend | None,
        compiled: Compiled,
        null_space_rate: float,
        weights: Array | None = None,
        original: SymbolicProblem | None = None,
        compilation: Compilation | None = None,
    ) -> None:
        compiled = read_compiled(compiled)
        bounds, terms = limits.of(robot), CriterionTerms.of(robot, criteria, clearances)
        if original is None:
            coordinates = WeightedCoordinates.of(weights)
            problem = SymbolicProblem(robot, tasks, terms, bounds.bounded, clearances, coordinates)
        else:
            problem = original.copied(terms)
        problem.locked, problem.position_limits = bounds.locked, (bounds.lower, bounds.upper)
        if compiled:
            try:
                check_compiled(terms, problem.values)
            except ArgumentError:
                if compiled is True:
                    raise
                compiled = False
        check_finite(terms, problem.values)
        self.problem, self._arguments = problem, (robot, tasks, limits, strategy)
        self._options: dict[str, Any] = {
            "criteria": criteria,
            "clearances": clearances,
            "solver": solver,
            "compiled": compiled,
        }
        self._options |= {"null_space_rate": null_space_rate, "weights": weights}
        self._strategy = strategy
        self._backend: Backend | None = None
        if clearances and not CheckedCall(strategy, strategy, "supports_clearances").flag():
            given = f"{list(clearances)!r} with strategy={strategy!r}"
            raise ArgumentError("clearances", given, supporting_clearances())
        if CheckedCall(strategy, strategy, "uses_qp").flag(problem.has_criterion or bool(clearances)):
            self._backend = backend_of(solver)
        elif solver is not None:
            accepted = f"None, as {type(strategy).__name__} solves no quadratic program here"
            if CheckedCall(strategy, strategy, "uses_qp").flag(True):
                accepted += "; it solves one with a criterion, criteria=..., or with clearances"
            raise ArgumentError("solver", solver, accepted)
        self.memory = InputMemory(tasks.target_size, problem.terms.parameters, bounds.lower, bounds.upper)
        inputs = self.memory.inputs
        self._compilation = compilation or Compilation()
        compiler = self._compilation if compiled is True else None
        certificate = MinimumCertificate(problem, compiler)  # compiled while the step is
        self.runners = Runners(
            problem,
            strategy,
            self._backend,
            bounds=bounds,
            memory=self.memory,
            compilation=compiler,
            null_space_rate=read_rate("null_space_rate", null_space_rate),
        )
        self.configurations = ConfigurationReader(robot, inputs.lower, inputs.upper)
        self._exclusive = ExclusiveUse()
        self._escape = escape = SaddleEscape(problem)
        self._inspector = inspector = Inspector(problem, escape, certificate, self.runners)
        criterion = CriterionEscape(problem, inspector, escape)
        turns, has_criterion = self.runners.turns, problem.has_criterion
        attempts = Attempts(problem, Escapes(escape, criterion), turns, self.runners.search_inputs)
        self._levels = attempts.levels
        by_level = len(problem.levels) > 1 and self.runners.respects_priority
        search_inputs = self.runners.search_inputs
        of_search: dict[str, Any] = {"banks": self.runners.banks, "has_criterion": has_criterion, "by_level": by_level}
        self.search = Search(robot, attempts, turns, search_inputs, **of_search)
        self._search_in_c()
        self._ahead = ahead = CompileAhead(self.runners if compiled == "auto" else None, self._adopted)
        self._targets = targets = TargetMemory(tasks, self.memory.inputs.target)
        self.stepping = Stepping(
            robot,
            tasks,
            targets,
            self.runners,
            self.configurations,
            escape=escape,
            criterion_escape=StepEscape(criterion),
            inspector=inspector,
            exclusive=self._exclusive,
            terms=problem.terms,
            ahead=ahead,
        )
        self.jogging = Jogging(problem, self.runners, self.configurations, escape=escape, exclusive=self._exclusive)
        self.solving = Solving(
            problem,
            self.runners,
            self.search,
            targets,
            self.configurations,
            Lanes(problem, strategy, self.runners),
            inspector=inspector,
            exclusive=self._exclusive,
            ahead=ahead,
        )

    def _adopted(self, name: str) -> None:
        """Let what uses a step use it in C, too."""
        if name == SOLVE:
            self._search_in_c()
            self.solving.adopted()
        self.stepping.adopted()

    def _search_in_c(self) -> None:
        """Let searches run in C where the step of `solve` does."""
        library = self.runners.solve.fused.library
        if library:
            has_criterion = self.problem.has_criterion
            turns = self.runners.turns
            self.search.native = NativeSearch(library, self.runners.solve, turns, has_criterion=has_criterion)

    def copied(self) -> Engine:
        """An engine with the functions of this one, memory of its own, and the parameters as they are."""
        engine = Engine(*self._arguments, **self._options, original=self.problem)
        engine.memory.inputs.parameters[:] = self.memory.inputs.parameters
        return engine

    def warm_up(self, progress: Progress) -> None:
        """Build what is otherwise built when it is first needed, as `InverseKinematics.warm_up` describes it."""
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            builds = [self.stepping.warm_up, lambda: self.runners.track, self._escape.warm_up, self._inspector.warm_up]
            if self.runners.solve.pauses:
                builds.append(self._levels.warm_up)
            if self.runners.solve.explorer:
                builds.append(self.runners.solve.explorer)
            if self.runners.banks:
                builds.append(self.runners.banks.warm_up)
            with counted(progress, "building") as report, self._compilation.shown(report, len(builds)):
                for build in builds:
                    build()
                    self._compilation.part_done()
            if self._backend:
                self._backend.warm_up()
            self._ahead.begin()
        finally:
            exclusive.busy = False

    def report(self, q: Any, target: Any) -> Report:
        """The report of a configuration, as `InverseKinematics.report` describes it."""
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            at = self.configurations.read("q", q)
            self._targets.read(target)
            return self._inspector.snapshot(at, target)()
        finally:
            exclusive.busy = False

    def build(self, q: Any, target: Any, qp: str | None) -> qpsolvers.Problem:
        """A quadratic program of a first step, as `InverseKinematics.build` describes it."""
        runner = self.runners.solve
        parts = runner.fused.parts
        if parts is None:
            accepted = "one that uses quadratic programs, such as 'newton+qp' with a criterion"
            raise ArgumentError("strategy", self._strategy, accepted)
        exclusive = self._exclusive
        if exclusive.busy:
            raise in_use()
        try:
            exclusive.busy = True
            self._targets.read(target)
            start = self.configurations.clamped(self.configurations.read("q", q))
            numbers = parts.numeric_qp(qp, [start, *self.runners.step_inputs, runner.first_state])
            problem: qpsolvers.Problem = as_problem(numbers)[0]
            return problem
        finally:
            exclusive.busy = False
