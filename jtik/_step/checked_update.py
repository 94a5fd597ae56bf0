"""The update of a strategy: its methods called, what they return checked, and defaults filled in."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields

import numpy as np

from jtik.qp.recorder import QPRecorder
from jtik.strategy import Evaluation, LocalModel, Shape, Strategy, Update
from jtik.strategy.checked_call import CheckedCall
from jtik.strategy.errors import KnownState, shown
from jtik.symbolic import Expression, is_equal, zeros
from jtik.types import Array

ENGINE_FIGURES = frozenset(
    {"V", "H", "accepted", "actual_decrease", "relaxed", "too_near", "slack", "dq", "null_space", "J"}
    | {"null_space_image", "q", "error"}
)
"""Names in the record of a step that a strategy cannot give to figures of its own."""


@dataclass(frozen=True)
class CheckedUpdate:
    """An `Update` with every field filled in and of the right shape.

    Attributes:
        dq: displacement that is added to q (n, 1).
        accepted: 1 if the step is taken, else 0.
        state: the strategy's state after the update.
        candidate: task and criterion after the displacement.
        wanted: the displacement before limits shortened it (n, 1).
        null_space: the part of ``dq`` meant to move only the null space (n, 1).
        figures: scalars for the trace, by name.
        stationarity_residual: stationarity residual of H; None for that of the local model.
        compromise_residual: stationarity residual of a weighted sum of V and H; None if the strategy minimises none.
        progress: relative decrease of what the strategy minimises; None for that of V.
        relaxed: amount by which each constraint is relaxed, non-negative, by (name, unit).
    """

    dq: Expression
    accepted: Expression
    state: Mapping[str, Expression]
    candidate: Evaluation
    wanted: Expression
    null_space: Expression
    figures: Mapping[str, Expression]
    stationarity_residual: Expression | None
    compromise_residual: Expression | None
    progress: Expression | None
    relaxed: Mapping[tuple[str, str], Expression]


def first_state(strategy: Strategy, shape: Shape) -> dict[str, Array]:
    """The state a strategy begins with.

    Raises:
        StrategyError: when it is not a mapping from names to finite one-dimensional arrays.
    """
    call = CheckedCall(strategy, strategy, "initial_state")
    state: dict[str, Array] = {}
    for name, value in call(Mapping, shape).items():  # type: ignore[type-abstract]
        try:
            array = np.array(value, dtype=float)
        except (TypeError, ValueError):
            array = np.full((1, 1), np.nan)
        if not isinstance(name, str) or array.ndim != 1 or not np.isfinite(array).all():
            raise call.error(
                f"returned state {shown(name)} = {shown(value)}", "names with finite one-dimensional arrays"
            )
        state[name] = array
    return state


def checked_update(strategy: Strategy, model: LocalModel, state: Mapping[str, Expression]) -> CheckedUpdate:
    """What ``strategy.update`` returns for the local model and its state.

    Raises:
        StrategyError: when it raises, is no `Update`, or a field has the wrong shape or belongs to another step.
    """
    call, n = CheckedCall(strategy, strategy, "update"), model.robot.n
    update = call(Update, model, KnownState(state, strategy))
    dq = call.displacement("dq", update.dq, n)
    candidate = model.candidate(dq) if update.candidate is None else update.candidate
    if not isinstance(candidate, Evaluation):
        raise call.error(f"returned candidate {type(candidate).__name__}", "what model.candidate(dq) returns")
    if candidate.dq is None or not _same(candidate.dq, dq):
        raise call.error("returned a candidate that was evaluated for another displacement", "model.candidate(dq)")
    after = dict(state if update.state is None else call.instance("state", update.state, Mapping))  # type: ignore[type-abstract]
    sizes = {name: _rows(value) for name, value in state.items()}
    if after.keys() != state.keys():
        found = {name: _rows(value) for name, value in after.items()}
        raise call.error(f"returned a state with names and sizes {found}", f"those of initial_state, {sizes}")
    figures = call.figures("figures", update.figures)
    if taken := sorted(figures.keys() & ENGINE_FIGURES):
        raise call.error(f"returned a figure {taken[0]!r}", "names of figures that the engine does not have itself")
    return CheckedUpdate(
        dq=dq,
        accepted=call.column("accepted", update.accepted, 1),
        state=call.state("state", after, state),
        candidate=candidate,
        wanted=dq if update.wanted is None else call.displacement("wanted", update.wanted, n),
        null_space=zeros(n) if update.null_space is None else call.displacement("null_space", update.null_space, n),
        figures=figures,
        stationarity_residual=call.optional("stationarity_residual", update.stationarity_residual),
        compromise_residual=call.optional("compromise_residual", update.compromise_residual),
        progress=call.optional("progress", update.progress),
        relaxed=call.relaxed("relaxed", update.relaxed),
    )


def check_symbols(
    strategy: Strategy, update: CheckedUpdate, known: list[Expression], qps: QPRecorder | None = None
) -> None:
    """Raise StrategyError where an update, or the data of a QP, depends on symbols that are not among ``known``."""
    values = {f.name: getattr(update, f.name) for f in fields(update) if f.name != "candidate"}
    values |= {f"candidate.{name}": getattr(update.candidate, name) for name in ("q", "residual", "H")}
    for group in ("state", "figures", "relaxed"):
        values |= {f"{group}[{name!r}]": value for name, value in values.pop(group).items()}
    for recorded in qps.calls if qps else ():
        what = f"data of {recorded.name!r}"
        values |= {f"{what}, entry {i}": value for i, value in enumerate(recorded.data())}
    given = {what: value for what, value in values.items() if value is not None}
    CheckedCall(strategy, strategy, "update").own_symbols(given, known)


def _same(first: Expression, second: Expression) -> bool:
    """Whether two columns are the same expressions."""
    return first is second or bool(first.shape == second.shape and is_equal(first, second, 2))


def _rows(value: Expression) -> int:
    """Number of entries; 1 for a number."""
    return int(np.prod(value.shape if hasattr(value, "shape") else np.shape(value)))
