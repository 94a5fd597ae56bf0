"""QP solvers inside the fused step, by CasADi's conic interface: a call of the step stays one call."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from jtik.arguments import name as read_name
from jtik.qp.backend import EXCLUDED, PLUGINS, BackendError, FusedBackend, accuracy_of
from jtik.qp.qpsolvers_backend import QPSolversBackend
from jtik.symbolic import Function, conic, has_conic
from jtik.symbolic.compilation.archives import archive_of

_DEFAULTS: Mapping[str, Mapping[str, Any]] = {
    "daqp": {"daqp": {"primal_tol": 1e-8}},
    "osqp": {"osqp": {"verbose": False, "eps_abs": 1e-8, "eps_rel": 1e-8, "max_iter": 20000, "polish": True}},
    "proxqp": {"proxqp": {"eps_abs": 1e-9, "verbose": False}},
    "piqp": {},
    "qpoases": {"printLevel": "none", "sparse": False},
    "highs": {"highs": {"output_flag": False}},
}
"""Default options: no output, and tolerances small enough for a step to converge."""


class Conic(FusedBackend):
    """A conic plugin of CasADi as the back end. Prefer it where there is a plugin: no Python runs inside a step.

    Args:
        name: name of the plugin, such as "daqp".
        accuracy: what solutions are checked against; a default for each plugin.
        **options: options of the plugin, passed through to it.

    Raises:
        ArgumentError: if ``accuracy`` is not finite and positive.
        BackendError: if CasADi came without the plugin; from `function` if the plugin cannot solve dense QPs with rows
            and bounds, or refuses the options.
    """

    def __init__(self, name: str = "daqp", *, accuracy: float | None = None, **options: Any) -> None:
        read_name("name", name, "the name of a conic plugin of CasADi")
        if name in EXCLUDED or not has_conic(name):
            usable = [plugin for plugin in PLUGINS if plugin not in EXCLUDED and has_conic(plugin)]
            raise BackendError(name, f"is no usable plugin of this CasADi; use one of {', '.join(usable)}")
        self.name = name
        self.accuracy = accuracy_of(accuracy, PLUGINS.get(name, 1e-5))
        self.archive = archive_of(name)
        self._options = {**_DEFAULTS.get(name, {}), **options}
        if name == "daqp" and not options:  # CasADi's own copy fails on one QP in some thousands that this one solves
            self.fallback = _RequiredDAQP()

    def __repr__(self) -> str:
        return f"Conic({self.name!r})"

    def function(self, n: int, rows: int) -> Function:
        """The plugin for dense QPs of this size.

        Raises:
            BackendError: when the plugin refuses the QP or an option.
        """
        try:
            return conic(f"qp_{self.name}", self.name, n, rows, {"error_on_fail": False, **self._options})
        except RuntimeError as error:
            raise BackendError(self.name, _reason(error, self._options)) from error


class _RequiredDAQP(QPSolversBackend):
    """DAQP of its own package, which jtik requires, so that nothing is loaded before it solves a QP."""

    def __init__(self) -> None:
        self.name, self.accuracy, self._options = "daqp", PLUGINS["daqp"], {"primal_tol": 1e-8}


def _reason(error: RuntimeError, options: Mapping[str, Any]) -> str:
    """The plugin's own message about a QP or an option that it refuses, without CasADi's stack of source positions."""
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    unknown = [line for line in lines if "nknown option" in line]
    if unknown:
        return f"{unknown[-1].split('] ')[-1].split(': ', 1)[-1]} of the options {dict(options)}"
    return f"cannot do dense quadratic programs with a box and rows, {dict(options)}: {lines[-1]}"
