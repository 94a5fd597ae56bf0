"""A QP that is solved before the step and only where it is needed; elsewhere it costs one comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from jtik.qp.backend import Backend, FusedBackend
from jtik.qp.call import QPCall, called, output_memory
from jtik.qp.many_rows import PassedRows
from jtik.qp.recorder import Preparation
from jtik.symbolic import MX, Expression, Function, either, function
from jtik.symbolic.compile import bind
from jtik.symbolic.generated_c import SELDOM
from jtik.types import Array


@dataclass(frozen=True)
class PreparationCall:
    """The functions of a preparation, of the values known before the step.

    Attributes:
        needed: known values -> whether the QP is needed.
        data: known values -> the QP's data.
        finish: (known values, solution of the QP) -> results.
        call: the QP for the back end.
    """

    needed: Function
    data: Function
    finish: Function
    call: QPCall

    @classmethod
    def of(cls, preparation: Preparation, known: Sequence[Expression]) -> PreparationCall:
        """From a preparation written in the symbols ``known``."""
        qp, solution = preparation.solution.qp, preparation.solution
        seldom = f"{SELDOM}{qp.name}"
        symbols = [solution.x, solution.row_multipliers, solution.box_multipliers]
        passed = PassedRows.of(qp, known)
        data = function(f"{seldom}_data", known, passed.left(qp) if passed else [*qp.data(), *qp.penalties])
        return cls(
            function(f"jtik_{qp.name}_needed", known, [preparation.needed]),
            passed.whole(data) if passed else data,
            function(f"{seldom}_finish", [*known, *symbols], preparation.results),
            QPCall.of(qp),
        )

    @property
    def sizes(self) -> list[int]:
        """Lengths of the results."""
        return [self.finish.numel_out(i) for i in range(self.finish.n_out())]

    @property
    def functions(self) -> list[Function]:
        """Its functions."""
        return [self.needed, self.data, self.finish]

    def compiled(self, to_c: Callable[[Function], Function]) -> PreparationCall:
        """The same as generated C, all but the solver."""
        return replace(self, needed=to_c(self.needed), data=to_c(self.data), finish=to_c(self.finish))

    def solver_function(self, backend: FusedBackend) -> Function:
        """known values -> results, by a fused back end; zeros where the QP is not needed."""
        known = [MX.sym(f"k{i}", *self.needed.size_in(i)) for i in range(self.needed.n_in())]
        solution = self.call.solution(called(self.data, known), backend)
        solved = function("needed", known, called(self.finish, [*known, *solution]))
        skipped = function("skipped", known, [MX.zeros(size, 1) for size in self.sizes])
        return function(self.call.name, known, called(either(solved, skipped), [*called(self.needed, known), *known]))

    def bind(self, backend: Backend, known: list[Array], results: list[Array]) -> Callable[[], None]:
        """A call without arguments on memory bound once."""
        if isinstance(backend, FusedBackend):
            return bind(self.solver_function(backend), known, results)
        data, needed = output_memory(self.data), np.zeros(1)
        solution = [np.zeros(size) for size in self.call.solution_sizes]
        calls = [bind(self.data, known, data), self.call.bound_solver(backend, data, solution)]
        calls.append(bind(self.finish, [*known, *solution], results))
        evaluate_needed = bind(self.needed, known, [needed])

        def prepare() -> None:
            evaluate_needed()
            if needed[0] == 0:
                for result in results:
                    result[:] = 0
                return
            for call in calls:
                call()

        return prepare
