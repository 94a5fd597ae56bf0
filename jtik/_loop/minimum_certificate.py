"""The certificate of a strict minimum of H at the end of a solve, as a function that is built when it is needed."""

from __future__ import annotations

from concurrent.futures import Future, ThreadPoolExecutor
from functools import cached_property

from jtik._step.inputs import Inputs
from jtik._step.strict_minimum import strict_minimum
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.symbolic import Function
from jtik.symbolic.compile import CompiledFunction, to_c
from jtik.types import Array


class MinimumCertificate:
    """Whether second derivatives exclude that H has a saddle point, a maximum or a valley at a stationary q.

    Args:
        problem: the problem.
        compiled: whether it runs as generated C, which is then built at once, in a thread.
    """

    def __init__(self, problem: SymbolicProblem, *, compiled: bool) -> None:
        self._problem = problem
        self._last = (b"", False)  # a search and the status of its end ask for the same configuration
        self._built: Future[Function] | None = None
        if compiled and problem.has_criterion:
            self._built = problem.once("compiled strict_minimum", self._compiling)

    def _compiling(self) -> Future[Function]:
        """The function, which a thread compiles."""
        compiler = ThreadPoolExecutor(1)
        built = compiler.submit(to_c, strict_minimum(self._problem))
        compiler.shutdown(wait=False)
        return built

    @cached_property
    def _function(self) -> CompiledFunction:
        problem = self._problem
        if self._built:
            return CompiledFunction(self._built.result())
        return CompiledFunction(problem.once("strict_minimum", lambda: strict_minimum(problem)))

    def warm_up(self) -> None:
        """Build the function now."""
        _ = self._function

    def __call__(self, q: Array, inputs: Inputs[Array]) -> bool:
        """Whether H certainly has a strict minimum at q, on target and stationary."""
        key = b"".join([part.tobytes() for part in (q, *inputs)])
        if key != self._last[0]:
            self._last = key, bool(self._function(q, *inputs)[0][0, 0])
        return self._last[1]
