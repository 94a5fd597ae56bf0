"""Strategies of jtik as contenders of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np

from jtik.arguments import flag, several
from jtik.arguments import name as read_name
from jtik.errors import ArgumentError, UnknownNameError
from jtik.qp import Backend
from jtik.registry import secondaries, strategies
from jtik.result.solution import Trace
from jtik.solver import InverseKinematics
from jtik.strategy import Strategy
from jtik.study.contender import Answer, Contender, PreparedContender, Setting
from jtik.types import Array

PEER = "peer:"
"""Prefix of the name of a contender from another library, such as "peer:mink"."""


class StrategyContender(Contender):
    """A strategy of jtik as a contender, for options that a name or a Strategy object does not carry.

    Args:
        strategy: name of a registered strategy, or a Strategy object.
        solver: solver of its quadratic programs, as in `jtik.InverseKinematics`.
        compiled: whether it runs as generated C; None uses the option of the study.
        label: its name in the study; by default the name of the strategy and its non-default options.

    Raises:
        ArgumentError: if strategy is neither a name nor a Strategy.
    """

    def __init__(
        self,
        strategy: str | Strategy,
        *,
        solver: str | Backend | None = None,
        compiled: bool | None = None,
        label: str | None = None,
    ) -> None:
        if not isinstance(strategy, (str, Strategy)) or strategy == "":
            raise ArgumentError("strategy", strategy, "a name, or a jtik.Strategy")
        if not (solver is None or isinstance(solver, Backend)):
            read_name("solver", solver, "the name of a solver of quadratic programs, a jtik.qp.Backend, or None")
        if compiled is not None:
            compiled = flag("compiled", compiled, "whether it runs as generated C; or None")
        if label is not None:
            read_name("label", label, "a name, or None")
        self.strategy, self.solver, self.compiled = strategy, solver, compiled
        own = strategy if isinstance(strategy, str) else described(strategy)
        extra = [f"solver={solver}"] if solver else []
        extra += [] if compiled is None else ["compiled" if compiled else "not compiled"]
        self.label = label or ", ".join([own, *extra])

    def __repr__(self) -> str:
        return f"StrategyContender({self.strategy!r}, label={self.label!r})"

    def prepare(self, setting: Setting) -> PreparedContender:
        """Build the solver. Raises what `jtik.InverseKinematics` raises.

        Args:
            setting: robot, task, criteria and options of the study.
        """
        ik = InverseKinematics(
            setting.robot,
            setting.task,
            criteria=setting.criteria,
            strategy=self.strategy,
            solver=self.solver,
            limits=setting.limits,
            clearances=setting.clearances or None,
            joints=setting.joints,
            at=setting.at,
            compiled=setting.compiled if self.compiled is None else self.compiled,
        )
        return PreparedStrategy(ik, setting)


class PreparedStrategy(PreparedContender):
    """A solver with the options of a setting."""

    def __init__(self, ik: InverseKinematics, setting: Setting) -> None:
        self.ik = ik
        self._solve = ik.solve
        self._first = {name: value.copy() for name, value in ik.parameters.items()}
        self._options: dict[str, Any] = {
            "restarts": setting.restarts,
            "seed": setting.seed,
            "max_iterations": setting.max_iterations,
            "position_tolerance": setting.position_tolerance,
            "orientation_tolerance": setting.orientation_tolerance,
            "optimality_tolerance": setting.optimality_tolerance,
            "until": setting.until,
        }

    def set(self, parameters: Mapping[str, Array]) -> None:
        """Set live parameters; those that are not given return to their first values."""
        for name, value in self._first.items():
            self.ik.parameters[name] = parameters.get(name, value)

    def solve(self, target: Any, q0: Array) -> Answer:
        """Solve by `InverseKinematics.solve`."""
        solution = self._solve(target, q0=q0, **self._options)
        return Answer(solution.q, solution.status.name, solution.converged, solution.iterations)

    def traced(self, target: Any, q0: Array) -> tuple[Answer, Trace | None]:
        """Solve with a trace."""
        solution = self._solve(target, q0=q0, trace=True, **self._options)
        return Answer(solution.q, solution.status.name, solution.converged, solution.iterations), solution.trace


class UnknownContender(Contender):
    """A contender for an unknown name; its rows carry the error."""

    def __init__(self, label: str, error: Exception) -> None:
        self.label, self._error = label, error

    def prepare(self, setting: Setting) -> PreparedContender:
        """Raise the error."""
        raise self._error


def contenders_of(given: Any) -> dict[str, Contender]:
    """The contenders of a study by label.

    Args:
        given: names, Strategy objects, contenders, one or several, or a mapping from label to any of these.

    Raises:
        ArgumentError: for no contender, or an element of another type.
    """
    if isinstance(given, (str, Strategy, Contender)):
        given = [given]
    if isinstance(given, Mapping):
        found = {str(label): _contender(each)[1] for label, each in given.items()}
    else:
        found = {}
        accepted = "names, jtik.Strategy objects or jtik.study.Contender objects"
        for each in several("strategies", given, accepted):
            own, contender = _contender(each)
            label, number = own, 1
            while label in found:
                number += 1
                label = f"{own} #{number}"
            found[label] = contender
    if not found:
        raise ArgumentError("strategies", "none", f"at least one, such as {', '.join(strategies.names())}")
    return found


def _contender(given: Any) -> tuple[str, Contender]:
    """A contender and its label."""
    if isinstance(given, Contender):
        return given.label, given
    if isinstance(given, str) and given.startswith(PEER):
        from jtik.study import peers

        try:
            return given, peers.named(given.removeprefix(PEER))
        except UnknownNameError as error:
            return given, UnknownContender(given, error)
    if not isinstance(given, (str, Strategy)) or given == "":
        raise ArgumentError("strategies", given, "a name, a jtik.Strategy, or a jtik.study.Contender")
    contender = StrategyContender(given)
    return contender.label, contender


def described(strategy: Strategy) -> str:
    """The registered name of a strategy with its non-default options, such as "damped(damping=0.3)"."""
    name = _registered(type(strategy))
    if not is_dataclass(strategy):
        return name
    options = []
    for each in fields(strategy):
        value = getattr(strategy, each.name)
        default = each.default if each.default_factory is MISSING else each.default_factory()
        if each.repr and not _same(value, default):
            options.append(f"{each.name}={_short(value)}")
    return f"{name}({', '.join(options)})" if options else name


def _registered(kind: type[Any]) -> str:
    for registry in (strategies, secondaries):
        for name, plugin in registry.loaded().items():
            if plugin is kind:
                return name
    return kind.__name__


def _short(value: Any) -> str:
    if type(value) in set(secondaries.loaded().values()) and is_dataclass(value):
        return described(value)  # type: ignore[arg-type]
    return f"{value:g}" if isinstance(value, float) else str(value)


def _same(value: Any, default: Any) -> bool:
    if isinstance(value, np.ndarray) or isinstance(default, np.ndarray):
        return np.array_equal(value, default)
    return bool(value == default)
