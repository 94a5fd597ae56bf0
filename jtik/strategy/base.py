"""What a strategy is: the symbolic law of one update, and the state it carries from one update to the next."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import ClassVar

from jtik.strategy.model import LocalModel, Point
from jtik.symbolic import Expression
from jtik.types import Array

State = Mapping[str, Expression]
"""Named state of a strategy, each entry a column of expressions."""


@dataclass(frozen=True)
class Shape:
    """What a state may depend on: numbers of velocities, coordinates and residual rows, a criterion, clearances."""

    n: int
    nq: int
    m: int
    has_criterion: bool
    has_clearance: bool = False


@dataclass(frozen=True)
class Update:
    """One update of the configuration.

    Attributes:
        point: where the update arrives, if it is accepted.
        accepted: 1 if the step is taken, 0 if the configuration stays and only the state changes.
        state: the state after the update, with the names of the state before.
        term: what the step to ``point`` subtracts from q (n, 1), the two terms of the paper's law together.
        wanted: the same before limits shortened it (n, 1).
        null_term: the part of it meant to move only the null space (n, 1).
        figures: what a Trace reports, such as alpha and beta; scalars by name.
        stationarity_residual: how far H is from stationary, where the strategy measures that better than
            ``model.null_length`` does; else None.
        progress: relative decrease of what the law brings down, where that is not V; None where it is.
        relaxed: by how much something falls short of what was asked for, from 0, by its name and unit.
    """

    point: Point
    accepted: Expression
    state: State
    term: Expression
    wanted: Expression
    null_term: Expression
    figures: Mapping[str, Expression] = field(default_factory=dict)
    stationarity_residual: Expression | None = None
    progress: Expression | None = None
    relaxed: Mapping[tuple[str, str], Expression] = field(default_factory=dict)


class Strategy(ABC):
    """An update law. Subclasses are frozen, keyword-only dataclasses; a registry name stands for their defaults.

    ``summary`` is one line for lists; ``source`` names the paper; ``is_soft`` is whether a criterion keeps the task
    from being met exactly.
    """

    name: ClassVar[str] = ""
    summary: ClassVar[str] = ""
    source: ClassVar[str] = ""
    is_soft: ClassVar[bool] = False

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The state a solve starts from: one-dimensional arrays by name."""
        return {}

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Whether acceptance looks at where a step arrives; if not, the engine does not evaluate it there either."""
        return True

    def uses_qp(self, has_criterion: bool) -> bool:
        """Whether the law asks a QP solver, by ``model.solve``, where there is a criterion (or a clearance)."""
        return False

    def supports_clearances(self) -> bool:
        """Whether its programs have the rows of clearances and it takes no step that does not keep them."""
        return False

    @abstractmethod
    def update(self, model: LocalModel, state: State) -> Update:
        """The law: from the local model and the state to the next configuration and state."""
