"""A program that is answered before a step, and only where it is needed: else it costs one comparison."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from jtik.qp.backend import Backend, FusedBackend
from jtik.qp.call import Answering, QPCall, called, outputs_of
from jtik.qp.recorder import Preparation
from jtik.symbolic import MX, Expression, Function, either, function
from jtik.symbolic.compile import bind, to_c
from jtik.types import Array


@dataclass(frozen=True)
class PreparedCall:
    """Functions of what is known before the step: whether the program is needed; its data; with its answer the results.

    ``call`` is the program for the back end.
    """

    needed: Function
    data: Function
    finish: Function
    call: QPCall

    @classmethod
    def of(cls, preparation: Preparation, known: Sequence[Expression]) -> PreparedCall:
        """From expressions of ``known``."""
        program, solution = preparation.solution.program, preparation.solution
        name = f"jtik_{program.name}"
        answer = [solution.x, solution.row_multipliers, solution.box_multipliers]
        return cls(
            function(f"{name}_needed", known, [preparation.needed]),
            function(f"{name}_data", known, [*program.data(), *program.prices]),
            function(f"{name}_finish", [*known, *answer], preparation.results),
            QPCall.of(program),
        )

    @property
    def sizes(self) -> list[int]:
        """Of the results."""
        return [self.finish.numel_out(i) for i in range(self.finish.n_out())]

    def compiled(self) -> PreparedCall:
        """The same as generated C; the solver stays as it is."""
        return replace(self, needed=to_c(self.needed), data=to_c(self.data), finish=to_c(self.finish))

    def solved_by(self, backend: FusedBackend) -> Function:
        """known -> results, by a fused back end."""
        known = [MX.sym(f"k{i}", *self.needed.size_in(i)) for i in range(self.needed.n_in())]
        answer = self.call.answered(called(self.data, known), backend)
        far = function("far", known, called(self.finish, [*known, *answer]))
        near = function("near", known, [MX.zeros(size, 1) for size in self.sizes])
        return function(self.call.name, known, called(either(far, near), [*called(self.needed, known), *known]))

    def bind(self, backend: Backend, known: list[Array], results: list[Array]) -> Callable[[], None]:
        """A call without arguments on memory bound once."""
        if isinstance(backend, FusedBackend):
            return bind(self.solved_by(backend), known, results)
        data, needed = outputs_of(self.data), np.zeros(1)
        memory, expand = self.call.plain(data)
        answer = [np.zeros(size) for size in self.call.sizes]
        calls = [bind(self.data, known, data)]
        if expand:
            calls.append(expand)
        calls.append(Answering(backend, self.call.numbers(memory), answer))
        calls.append(bind(self.finish, [*known, *answer], results))
        ask = bind(self.needed, known, [needed])

        def prepare() -> None:
            ask()
            if needed[0] == 0:
                for result in results:
                    result[:] = 0
                return
            for call in calls:
                call()

        return prepare
