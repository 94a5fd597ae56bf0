"""The native solve: one call of `InverseKinematics.solve` in one call of C, for a search in C that has converged.

Its results are bitwise equal to those of `jtik._loop.solving`, which does what is not usual: other forms of a target or
a q0, options that are new, and a search that has not converged.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik._loop.exclusive_use import ExclusiveUse
from jtik._loop.native.python_function import functions, memory_of
from jtik._loop.native.search import PreparedSearch
from jtik._loop.native.solve_source import ATTRIBUTES, MEMORY
from jtik._loop.solutions import Solutions
from jtik.result.solution import Solution
from jtik.result.status import Status
from jtik.types import Array

Call = Callable[..., Solution]
"""(target, q0, lanes, nearest, trace, restarts, ...) -> the Solution."""

OPTIONS = 12
"""Number of the arguments of a call besides target and q0."""


class NativeSolve:
    """A solve in C by a search that is prepared.

    Args:
        loaded: the shared library of the search.
        name: the beginning of its names.
        search: the search.
        home: where it begins without a q0, (nq,).
        solutions: the Solutions of the solver.
        exclusive: the guard of the solver; while it is busy, all is left to Python.
        ended: memory for what a search has returned that has not converged, and for the time since the call [s].
        go_on: what is called with the same arguments after a search that has not converged, within the guard.
    """

    def __init__(
        self,
        loaded: ctypes.CDLL,
        name: str,
        search: PreparedSearch,
        home: Array,
        solutions: Solutions,
        exclusive: ExclusiveUse,
        ended: tuple[NDArray[np.int64], Array],
        go_on: Call,
    ) -> None:
        self._known = np.zeros(OPTIONS, dtype=np.uintp)
        arrays = {
            **search._asdict(),
            "home": np.array(home),
            "numbers": solutions.numbers,
            "returned": ended[0],
            "elapsed": ended[1],
            "known": self._known,
            "attributes": np.array([id(each) for each in ATTRIBUTES], dtype=np.uintp),
        }
        objects = {
            "exclusive": exclusive,
            "otherwise": None,
            "go_on": go_on,
            "report": solutions.report,
            "array_type": np.ndarray,
            "float64": np.dtype(np.float64),
            "float_type": float,
            "integer_type": int,
            "text_type": str,
            "none": None,
            "no": False,
            "yes": True,
            "zero": 0,
            "converged": Status.CONVERGED,
            "solution_type": Solution,
        }
        numbers = {"options": OPTIONS, "number_count": len(solutions.numbers)}
        kept = {"library": loaded, "attribute names": ATTRIBUTES, "options known": ()}
        self._memory = memory_of(MEMORY, arrays=arrays, numbers=numbers, objects=objects, kept=kept)
        self._call: Call
        (self._call,) = functions(loaded, f"{name}_solves", 1, self._memory)

    def before(self, otherwise: Call) -> Call:
        """``solve(target, q0, *options)``, which calls ``otherwise`` with the same arguments for what is not usual."""
        self._memory.kept["otherwise"] = otherwise
        self._memory[list(MEMORY).index("otherwise")] = id(otherwise)
        return self._call

    def know(self, options: tuple[Any, ...]) -> None:
        """Take a call with these options as usual from now on: the search is prepared for them."""
        self._memory.kept["options known"] = options
        self._known[:] = [id(each) for each in options]

    def forget(self) -> None:
        """Leave every call to Python, until `know`."""
        self._known[:] = 0
