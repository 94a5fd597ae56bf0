"""Solvers inside the fused step: CasADi's conic interface, a call of the step stays one call."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from jtik.qp.backend import PLUGINS, WRONG, Backend, BackendError
from jtik.symbolic import Function, conic, has_conic

_QUIET: Mapping[str, Mapping[str, Any]] = {
    "daqp": {"daqp": {"primal_tol": 1e-8}},
    "osqp": {"osqp": {"verbose": False, "eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20000, "polish": True}},
    "proxqp": {"proxqp": {"eps_abs": 1e-9, "verbose": False}},
    "piqp": {},
    "qpoases": {"printLevel": "none", "sparse": False},
    "highs": {"highs": {"output_flag": False}},
}
"""What keeps a plugin silent and exact enough for a step."""


class Conic(Backend):
    """A conic plugin of CasADi. Options pass through to it.

    Raises:
        BackendError: when CasADi came without the plugin.
    """

    fused: ClassVar[bool] = True

    def __init__(self, name: str = "daqp", *, accuracy: float | None = None, **options: Any) -> None:
        if name in WRONG or not has_conic(name):
            usable = [plugin for plugin in PLUGINS if plugin not in WRONG and has_conic(plugin)]
            raise BackendError(name, f"no plugin of this CasADi that can be used; there are {', '.join(usable)}")
        self.name = name
        self.accuracy = PLUGINS.get(name, 1e-5) if accuracy is None else accuracy
        self._options = {**_QUIET.get(name, {}), **options}

    def __repr__(self) -> str:
        return f"Conic({self.name!r})"

    def function(self, n: int, rows: int) -> Function:
        """The plugin for dense programs of this size."""
        try:
            return conic(f"qp_{self.name}", self.name, n, rows, {"error_on_fail": False, **self._options})
        except RuntimeError as error:
            raise BackendError(self.name, str(error).strip().splitlines()[-1]) from error
