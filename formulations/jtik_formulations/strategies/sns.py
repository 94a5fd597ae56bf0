"""SNS, saturation in the null space: the task keeps its direction, the limits hold (formulations/sns.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from jtik import register_strategy
from jtik.errors import ArgumentError
from jtik.strategy import LocalModel
from jtik.symbolic import Expression
from jtik_formulations.strategies._parts.basic_saturation import BasicSaturation
from jtik_formulations.strategies._parts.saturation import Saturation
from jtik_formulations.strategies._parts.task_scaling import Scaled, TaskScaling

Rule = Literal["optimal", "basic"]


def sns(
    J: Expression,
    xdot: Expression,
    lower: Expression,
    upper: Expression,
    *,
    rule: Rule = "optimal",
    rounds: int | None = None,
) -> tuple[Expression, Expression]:
    """dq (n, 1) within the bounds with J dq = s xdot, and the scale s, 0 to 1.

    Args:
        J: Jacobian (m, n).
        xdot: what the task asks for (m, 1), in the range of J.
        lower, upper: bounds of dq (n, 1) each, with 0 between them.
        rule: "optimal": the largest s there is, and of all dq that reach it the shortest. "basic": joints that have
            been put at a bound stay there; s may be smaller.
        rounds: how many joints the rule "optimal" may put at a bound or take off it; 2 n by default.
    """
    n = J.shape[1]
    here: Scaled = BasicSaturation.at_rest(lower, upper)
    if rule == "optimal":
        here = Saturation.at_rest(lower, upper, rounds=2 * n if rounds is None else rounds)
    here = here.with_task(J, xdot)
    return here.x, here.scale


@register_strategy("sns")
@dataclass(frozen=True, kw_only=True)
class SNS(TaskScaling):
    """J dq = -s r within the limits of positions and steps, with the largest s; of all such dq the nearest to the wish.

    The tip goes straight towards its target, and a joint that reaches a limit leaves its work to the others: only what
    all of them cannot do together makes the step shorter. The wish is -beta grad H of a criterion, or no motion.
    Several levels of priority come one after the other, each with a scale of its own. Needs no QP solver.

    Attributes:
        rule: "optimal", or "basic": as first published, where joints once at a limit stay there for the step.
        rounds: how many joints may come to or off a limit in a step of the rule "optimal", for each level and for the
            criterion; n by default. Where more had to, the step is shorter than it could be.
        gain: share of the error to remove in a step, in (0, 1].
        damping: of what is asked for near singular poses, lambda / V [1 / rad^2]; 0 for none.
        q_limit: most that each rotational joint moves in a step [rad]; math.inf for no limit.
        backtracking: halve the step until V falls, or the penalty function of several levels.
        secondary: rule of beta.

    Source: Flacco, De Luca and Khatib (2012, 2015).
    """

    rule: Rule = "optimal"
    rounds: int | None = None

    summary = "saturation in the null space: tasks scaled in their direction to fit into the limits"
    source = "Flacco, De Luca and Khatib 2015"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.rule not in ("optimal", "basic"):
            raise ArgumentError("rule", self.rule, "'optimal' or 'basic'")
        if self.rounds is not None and not (isinstance(self.rounds, int) and self.rounds > 0):
            raise ArgumentError("rounds", self.rounds, "a positive integer, or None for one a joint")

    def releases(self) -> bool:
        """The rule "optimal" does."""
        return self.rule == "optimal"

    def at_rest(self, model: LocalModel, lower: Expression, upper: Expression) -> Scaled:
        """By the rule."""
        if self.rule == "basic":
            return BasicSaturation.at_rest(lower, upper)
        return Saturation.at_rest(lower, upper, rounds=self.rounds or model.robot.n)
