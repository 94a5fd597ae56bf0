"""What a law asks for on its way: programs and computations, in their order, and the symbols of their answers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from jtik.qp.quadratic_program import QPSolution, QuadraticProgram
from jtik.symbolic import Expression, logic_and, logic_or, symbol
from jtik.types import Array

Compute: TypeAlias = Callable[[Sequence[Array]], "Sequence[Any] | None"]
"""What Python does in the middle of a step: flat arrays (columns first) to arrays; None where there is no answer."""


@dataclass(frozen=True)
class Recorded:
    """A program and the symbols that stand for its answer."""

    program: QuadraticProgram
    solution: QPSolution

    @property
    def name(self) -> str:
        """The program's."""
        return self.program.name

    def data(self) -> list[Expression]:
        """What the solver is given."""
        return self.program.data()

    @property
    def answers(self) -> list[Expression]:
        """What it answers."""
        return [self.solution.x, self.solution.row_multipliers, self.solution.box_multipliers]

    def solved(self, accuracy: float) -> Expression:
        """1 where the answer holds."""
        return self.solution.solved(accuracy)


@dataclass(frozen=True)
class Computation:
    """Something that Python computes from numbers of the step, and the symbols that stand for what comes out."""

    name: str
    compute: Compute
    inputs: list[Expression]
    answers: list[Expression]

    def data(self) -> list[Expression]:
        """What it is given."""
        return self.inputs

    def solved(self, accuracy: float) -> Expression:
        """1 where there is an answer without NaN."""
        good: Expression = 1
        for answer in self.answers:
            for i in range(answer.numel()):
                # every number is on one side of zero, NaN on neither
                good = logic_and(good, logic_or(answer[i] <= 0, answer[i] >= 0))
        return good


@dataclass(frozen=True)
class Preparation:
    """A program before the step: when it is needed, its solution, what is made of it, and the symbols for that."""

    needed: Expression
    solution: QPSolution
    results: list[Expression]
    answers: list[Expression]


@dataclass
class QPRecorder:
    """Takes programs and computations in the order in which a strategy asks for answers."""

    accuracy: float
    solver: str = "daqp"
    programs: list[Recorded | Computation] = field(default_factory=list)
    preparations: list[Preparation] = field(default_factory=list)

    def compute(
        self, name: str, compute: Compute, inputs: Sequence[Expression], shapes: Sequence[tuple[int, int]]
    ) -> list[Expression]:
        """What Python will answer, as symbols of these shapes."""
        k = len(self.programs)
        answers = [symbol(f"c{k}_{i}", *shape) for i, shape in enumerate(shapes)]
        self.programs.append(Computation(name, compute, list(inputs), answers))
        return answers

    def solve(self, program: QuadraticProgram) -> QPSolution:
        """The answer, as symbols."""
        solution = _symbols(program, str(len(self.programs)))
        self.programs.append(Recorded(program, solution))
        return solution

    def solutions(self) -> list[tuple[QuadraticProgram, QPSolution]]:
        """The programs so far, with their answers."""
        return [(each.program, each.solution) for each in self.programs if isinstance(each, Recorded)]

    def prepare(
        self,
        needed: Expression,
        program: QuadraticProgram,
        results: Callable[[QPSolution], Sequence[Expression]],
    ) -> list[Expression]:
        """What a program of the local model alone has to say where it is ``needed``, before the step; else zeros.

        Where it is not, nothing of it is evaluated. ``results`` makes columns of its solution, which nobody checks: a
        step must be able to do without.
        """
        name = f"prepared{len(self.preparations)}"
        solution = _symbols(program, name)
        made = list(results(solution))
        answers = [symbol(f"{name}_{i}", each.shape[0]) for i, each in enumerate(made)]
        self.preparations.append(Preparation(needed, solution, made, answers))
        return answers

    def solved(self) -> Expression:
        """1 where every program so far was answered rightly."""
        good: Expression = 1
        for recorded in self.programs:
            good = logic_and(good, recorded.solved(self.accuracy))
        return good


def _symbols(program: QuadraticProgram, name: str) -> QPSolution:
    n, rows = program.size, program.row_count
    return QPSolution(symbol(f"x{name}", n), symbol(f"y{name}", rows), symbol(f"z{name}", n), program)
