"""Base class of strategies: the symbolic update of one step, and the state carried from one step to the next."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from jtik.constructors import Constructed
from jtik.strategy.evaluation import Evaluation
from jtik.strategy.model import LocalModel
from jtik.strategy.options import read_options
from jtik.symbolic import Expression
from jtik.types import Array

State = Mapping[str, Expression]
"""Named state of a strategy, each entry a column of expressions."""


@dataclass(frozen=True)
class Shape:
    """Sizes of a problem, on which the state of a strategy may depend.

    Attributes:
        n: number of velocity entries.
        nq: number of configuration entries.
        m: number of rows of the residual.
        has_criterion: whether there is a criterion.
        has_clearance: whether there is a clearance.
        timed: whether the step has a duration.
    """

    n: int
    nq: int
    m: int
    has_criterion: bool
    has_clearance: bool = False
    timed: bool = False


@dataclass(frozen=True)
class Update:
    """One update of the configuration. Only ``dq`` is needed.

    Attributes:
        dq: displacement that is added to q (n, 1).
        accepted: 1 if the step is taken, 0 if the configuration stays and only the state changes.
        state: the state after the update, with the names of the state before; by default the state stays.
        candidate: what ``model.candidate(dq)`` returned, for a strategy that has evaluated it already.
        wanted: the displacement before limits shortened it (n, 1); ``dq`` by default.
        null_space: the part of ``dq`` meant to move only the null space (n, 1); zeros by default.
        figures: scalars for the trace, by name, such as the gains alpha and beta.
        stationarity_residual: stationarity residual of H, by the joints themselves; ``model.stationarity_residual`` by
            default.
        compromise_residual: norm of the projected gradient of what a strategy with ``is_soft`` minimises, by the joints
            themselves and in the unit of H's gradient; where it is within the optimality tolerance the solve ends.
        progress: relative decrease of what the strategy minimises, if that is not V.
        relaxed: amount by which each constraint is relaxed, non-negative, by (name, unit).
    """

    dq: Expression
    accepted: Expression = 1
    state: State | None = None
    candidate: Evaluation | None = None
    wanted: Expression = None
    null_space: Expression = None
    figures: Mapping[str, Expression] = field(default_factory=dict)
    stationarity_residual: Expression | None = None
    compromise_residual: Expression | None = None
    progress: Expression | None = None
    relaxed: Mapping[tuple[str, str], Expression] = field(default_factory=dict)


class Strategy(metaclass=Constructed):
    """A strategy of redundancy resolution. Subclasses are frozen, keyword-only dataclasses.

    Most strategies derive from `Composition` (a task displacement and a null-space displacement) or from `Programmed`
    (one displacement from quadratic programs), which write `update`. A registry name stands for the object with its
    defaults.

    Attributes:
        name: the registry name.
        summary: one line for listings.
        source: author and year of the paper.
        bibtex: BibTeX entries of the source, for `jtik.citations`.
        is_soft: whether a criterion keeps the task from being met exactly: the strategy minimises a weighted sum of
            both, and a solve ends at its stationary point with `jtik.Status.COMPROMISE`.
    """

    name: ClassVar[str] = ""
    summary: ClassVar[str] = ""
    source: ClassVar[str] = ""
    bibtex: ClassVar[str] = ""
    is_soft: ClassVar[bool] = False

    def __init_subclass__(cls, **options: Any) -> None:
        super().__init_subclass__(**options)
        take_renamed(
            cls,
            {
                "judges": "evaluates_candidate",
                "solves_programs": "uses_qp",
                "keeps_clear": "supports_clearances",
                "compromises": "is_soft",
            },
        )

    def __post_init__(self) -> None:
        """Read the options of a dataclass by their annotations, see `jtik.strategy.options`."""
        read_options(self)

    def initial_state(self, shape: Shape) -> Mapping[str, Array]:
        """The state a solve starts from: one-dimensional arrays by name.

        Args:
            shape: sizes of the problem.
        """
        return {}

    def evaluates_candidate(self, has_criterion: bool) -> bool:
        """Whether acceptance depends on task or criterion where the step ends.

        If not, the engine does not evaluate them there.

        Args:
            has_criterion: whether there is a criterion.
        """
        return True

    def uses_qp(self, has_criterion: bool) -> bool:
        """Whether the strategy solves quadratic programs, by ``model.solve``.

        Args:
            has_criterion: whether there is a criterion, or a clearance.
        """
        return False

    def explores(self, has_criterion: bool) -> bool:
        """Whether it has exploring steps, which `solve` takes where V has stopped falling off the target.

        Args:
            has_criterion: whether there is a criterion.
        """
        return False

    def damps_stagnation(self) -> bool:
        """Whether `step` without a time adds ``model.stagnation_damping``, to come to rest at a target out of reach."""
        return False

    def in_lanes(self) -> Strategy:
        """The strategy whose steps ``lanes=True`` takes with restarts and without a criterion.

        This one by default. There an attempt that does not reach the target soon is replaced by the next start, so a
        step need not lower V, and a cheaper one is better.
        """
        return self

    def fits_limits(self) -> bool:
        """Whether it uses ``model.fitted``, which in a timed step needs a solver of quadratic programs."""
        return False

    def respects_priority(self) -> bool:
        """Whether it keeps each level of priority from the levels below it; others treat all tasks alike."""
        return False

    def supports_clearances(self) -> bool:
        """Whether its quadratic programs have the rows of clearances. No step that violates one is then accepted."""
        return False

    @abstractmethod
    def update(self, model: LocalModel, state: State) -> Update:
        """The update: from the local model and the state to the displacement and the next state.

        Args:
            model: the local model at q, in symbols.
            state: the state before the update, each entry a column of symbols.
        """


def take_renamed(cls: type, renamed: Mapping[str, str]) -> None:
    """Give what a class defines under a former name its present name, with a DeprecationWarning."""
    for old, new in renamed.items():
        if old in vars(cls) and new not in vars(cls):
            message = f"{cls.__name__}.{old} is now called {new}; the old name goes with the next release"
            warnings.warn(message, DeprecationWarning, stacklevel=3)
            setattr(cls, new, vars(cls)[old])
