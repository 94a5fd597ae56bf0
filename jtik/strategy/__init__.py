"""The contract of a strategy: the local model it gets, the update it returns, and the two base classes to write one.

`Composition` joins a task displacement and a null-space displacement; `Programmed` takes one displacement from
quadratic programs. Merit functions, backtracking, limits of a step and kinds of options are shared by all strategies.
"""

from typing import Any

from jtik.strategy.acceptance import Acceptance
from jtik.strategy.backtracking import AdaptiveDamping, Backtracking, adapted_fraction
from jtik.strategy.base import Shape, State, Strategy, Update
from jtik.strategy.composition import Composition, SecondaryTerm, TaskStep, acceptance_beside
from jtik.strategy.displacement import NullSpaceDisplacement, Outcome, TaskDisplacement
from jtik.strategy.errors import StrategyError
from jtik.strategy.evaluation import Evaluation
from jtik.strategy.feasibility_restoration import FeasibilityRestoration
from jtik.strategy.level_merit import LevelMerit
from jtik.strategy.merit import Merit, Verdict
from jtik.strategy.model import LocalModel
from jtik.strategy.options import (
    AngleLimit,
    LengthLimit,
    NonNegative,
    Positive,
    PositiveInteger,
    Share,
    StepLimit,
    read_options,
)
from jtik.strategy.programmed import Programmed, Proposal
from jtik.strategy.step_limits import limited_box, not_outward, within_step_limit
from jtik.strategy.weighted_merit import WeightedMerit

__all__ = [
    "Acceptance",
    "AdaptiveDamping",
    "AngleLimit",
    "Backtracking",
    "Composition",
    "Evaluation",
    "FeasibilityRestoration",
    "LengthLimit",
    "LevelMerit",
    "LocalModel",
    "Merit",
    "NonNegative",
    "NullSpaceDisplacement",
    "Outcome",
    "Positive",
    "PositiveInteger",
    "Programmed",
    "Proposal",
    "SecondaryTerm",
    "Shape",
    "Share",
    "State",
    "StepLimit",
    "Strategy",
    "StrategyError",
    "TaskDisplacement",
    "TaskStep",
    "Update",
    "Verdict",
    "WeightedMerit",
    "acceptance_beside",
    "adapted_fraction",
    "limited_box",
    "not_outward",
    "read_options",
    "within_step_limit",
]


def __getattr__(name: str) -> Any:
    from jtik.strategy.renamed import former

    return former(name)
