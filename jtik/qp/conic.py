"""Solvers inside the fused step: CasADi's conic interface, a call of the step stays one call."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jtik.qp.backend import PLUGINS, WRONG, BackendError, FusedBackend, accuracy_of
from jtik.qp.foreign import Foreign
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


class Conic(FusedBackend):
    """A conic plugin of CasADi. Options pass through to it.

    Raises:
        ArgumentError: for an accuracy that is none.
        BackendError: when CasADi came without the plugin; from `function` when the plugin cannot do such programs, or
            refuses the options.
    """

    def __init__(self, name: str = "daqp", *, accuracy: float | None = None, **options: Any) -> None:
        if name in WRONG or not has_conic(name):
            usable = [plugin for plugin in PLUGINS if plugin not in WRONG and has_conic(plugin)]
            raise BackendError(name, f"no plugin of this CasADi that can be used; there are {', '.join(usable)}")
        self.name = name
        self.accuracy = accuracy_of(accuracy, PLUGINS.get(name, 1e-5))
        self._options = {**_QUIET.get(name, {}), **options}
        if name == "daqp" and not options:  # CasADi's own copy gives up on one in some thousands that this one solves
            self.second = Foreign("daqp", primal_tol=1e-8)

    def __repr__(self) -> str:
        return f"Conic({self.name!r})"

    def function(self, n: int, rows: int) -> Function:
        """The plugin for dense programs of this size."""
        try:
            return conic(f"qp_{self.name}", self.name, n, rows, {"error_on_fail": False, **self._options})
        except RuntimeError as error:
            raise BackendError(self.name, _reason(error, self._options)) from error


def _reason(error: RuntimeError, options: Mapping[str, Any]) -> str:
    """What a plugin says of a program or of an option that it cannot do, without the trail that CasADi lays."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    unknown = [line for line in lines if "nknown option" in line]
    if unknown:
        return f"{unknown[-1].split('] ')[-1].split(': ', 1)[-1]} of the options {dict(options)}"
    return f"cannot do dense quadratic programs with a box and rows, {dict(options)}: {lines[-1]}"
