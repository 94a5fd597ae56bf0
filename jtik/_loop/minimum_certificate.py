"""The certificate of a strict minimum of H at the end of a solve, as a function that is built when it is needed."""

from __future__ import annotations

from concurrent.futures import CancelledError, Future
from functools import cached_property

import numpy as np

from jtik._step.inputs import Inputs
from jtik._step.strict_minimum import UNROLLED, strict_minimum
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.symbolic import Function
from jtik.symbolic.compilation.several_files import Compilation
from jtik.symbolic.compile import CompiledFunction, CompilerError, Library, to_c
from jtik.types import Array


class MinimumCertificate:
    """Whether second derivatives exclude that H has a saddle point, a maximum or a valley at a stationary q.

    Args:
        problem: the problem.
        compilation: compiles it as generated C, from now on, where H is minimised; None for the virtual machine. That
            of many joints stays there: it has as many entries as their number squared, and is evaluated once a solve.
    """

    def __init__(self, problem: SymbolicProblem, compilation: Compilation | None) -> None:
        self._problem = problem
        self._last = (b"", False)  # a search and the status of its end ask for the same configuration
        self._built: Future[Library] | None = None
        if compilation and problem.has_criterion and problem.robot.n <= UNROLLED:
            self._built = problem.once("compiled strict_minimum", lambda: compilation.begun(self._symbolic))

    @property
    def _symbolic(self) -> Function:
        return self._problem.once("strict_minimum", lambda: strict_minimum(self._problem))

    @cached_property
    def _function(self) -> CompiledFunction:
        if self._built is None:
            return CompiledFunction(self._symbolic)
        try:
            return CompiledFunction(self._built.result().function)
        except (CompilerError, CancelledError):  # Ctrl-C has ended the compiler: once more
            return CompiledFunction(to_c(self._symbolic))

    def warm_up(self) -> None:
        """Build the function now."""
        _ = self._function

    def __call__(self, q: Array, inputs: Inputs[Array]) -> bool:
        """Whether H certainly has a strict minimum at q, on target and stationary."""
        key = b"".join([part.tobytes() for part in (q, *inputs)])
        if key != self._last[0]:
            holds, *matrix = self._function(q, *inputs)
            self._last = key, bool(holds[0, 0]) and all(map(_is_positive_definite, matrix))
        return self._last[1]


def _is_positive_definite(M: Array) -> bool:
    """Whether a symmetric matrix (n, n) is positive definite; one that is not finite is not."""
    try:
        np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        return False
    return bool(np.isfinite(M).all())
