"""Quadratic programs (QPs) as symbolic data, steps that contain QPs, and the back ends that solve them."""

from __future__ import annotations

import warnings
from typing import Any

from jtik.qp.backend import (
    Backend,
    BackendError,
    CalledBackend,
    FusedBackend,
    NumericQP,
    QPSolver,
    available,
    backend_of,
)
from jtik.qp.conic import Conic
from jtik.qp.elastic import Elastic
from jtik.qp.persistent_osqp import PersistentOSQP
from jtik.qp.qpsolvers_backend import QPSolversBackend, as_problem
from jtik.qp.quadratic_program import QuadraticProgram
from jtik.qp.recorder import QPRecorder, RecordedQP
from jtik.qp.rows import Rows
from jtik.qp.solution import QPSolution

__all__ = [
    "Backend",
    "BackendError",
    "CalledBackend",
    "Conic",
    "Elastic",
    "FusedBackend",
    "NumericQP",
    "PersistentOSQP",
    "QPRecorder",
    "QPSolution",
    "QPSolver",
    "QPSolversBackend",
    "QuadraticProgram",
    "RecordedQP",
    "Rows",
    "as_problem",
    "available",
    "backend_of",
]

_RENAMED: dict[str, Any] = {
    "Foreign": QPSolversBackend,
    "Program": QuadraticProgram,
    "ProgramSolution": QPSolution,
    "Recorded": RecordedQP,
    "Recorder": QPRecorder,
}
"""Deprecated names and the classes that they stand for."""


def __getattr__(name: str) -> Any:
    """The class behind a deprecated name, with a DeprecationWarning."""
    if name not in _RENAMED:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    new = _RENAMED[name]
    warnings.warn(f"jtik.qp.{name} is deprecated; use jtik.qp.{new.__name__}", DeprecationWarning, stacklevel=2)
    return new
