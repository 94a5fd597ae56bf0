"""Quadratic programs as data, the steps that solve one or several, and the back ends that do it."""

from jtik.qp.backend import Backend, BackendError, CalledBackend, FusedBackend, available, backend_of
from jtik.qp.conic import Conic
from jtik.qp.elastic import Elastic
from jtik.qp.foreign import Foreign, as_problem
from jtik.qp.persistent import PersistentOSQP
from jtik.qp.quadratic_program import QPSolution, QuadraticProgram, Rows
from jtik.qp.recorder import QPRecorder, Recorded

__all__ = [
    "Backend",
    "BackendError",
    "CalledBackend",
    "Conic",
    "Elastic",
    "Foreign",
    "FusedBackend",
    "PersistentOSQP",
    "QPRecorder",
    "QPSolution",
    "QuadraticProgram",
    "Recorded",
    "Rows",
    "as_problem",
    "available",
    "backend_of",
]
