"""SNS, saturation in the null space: the task keeps its direction within the limits (formulations/sns.md)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from jtik import register_strategy
from jtik.strategy import LocalModel, PositiveInteger
from jtik.symbolic import Expression
from jtik_formulations.bibliography import FLACCO_2015
from jtik_formulations.strategies._parts.basic_saturation import BasicSaturation
from jtik_formulations.strategies._parts.saturation import Saturation
from jtik_formulations.strategies._parts.task_scaling import ScaledDisplacement, TaskScaling

Rule = Literal["optimal", "basic"]

ROUNDS_PER_JOINT = 2
"""Default rounds of the rule "optimal": enough in 5,000 random problems with a third of the joints at limits."""


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
        xdot: wanted task displacement (m, 1), in the range of J.
        lower: lower bounds of dq (n, 1), at most 0.
        upper: upper bounds of dq (n, 1), at least 0.
        rule: "optimal": the largest s, and of all dq that reach it the shortest. "basic": joints that have been put at
            a bound stay there; s may be smaller.
        rounds: how many joints the rule "optimal" may put at a bound or take off it; 2 n by default.
    """
    n = J.shape[1]
    here: ScaledDisplacement = BasicSaturation.initial(lower, upper)
    if rule == "optimal":
        here = Saturation.initial(lower, upper, rounds=rounds or ROUNDS_PER_JOINT * n)
    here = here.with_task(J, xdot)
    return here.x, here.scale


@register_strategy("sns")
@dataclass(frozen=True, kw_only=True)
class SNS(TaskScaling):
    """J dq = -s r within the limits of positions and steps, with the largest s; of these the closest to -beta grad H.

    The end effector moves straight towards its target. The other joints compensate for a joint that reaches a limit,
    and the step gets shorter only where they cannot. Without a criterion dq is the shortest. Levels of priority follow
    one another, each with a scale of its own. No QP solver is needed.

    Attributes:
        rule: "optimal", or "basic": as first published, where joints once at a limit stay there for the step.
        rounds: how many joints may reach or leave a limit in a step of the rule "optimal", for each level and for the
            criterion; 2 n by default. If more would have to, the step is shorter than it could be. n rounds halve the
            work of a step.
        gain: share of the error to remove in a step, in (0, 1].
        damping: damping of the task near singular poses, mu / V [1 / rad^2]; 0 for none.
        q_limit: largest motion of each rotational joint in a step [rad]; math.inf for no limit.
        backtracking: halve the step until V falls, or the penalty function of several levels.
        secondary: rule of beta.

    Source: Flacco, De Luca and Khatib (2012, 2015).
    """

    rule: Rule = "optimal"
    rounds: PositiveInteger | None = None

    summary = "saturation in the null space: tasks scaled in their direction to fit into the limits"
    source = "Flacco, De Luca and Khatib 2015"
    bibtex = FLACCO_2015

    def releases(self) -> bool:
        """The rule "optimal" does."""
        return self.rule == "optimal"

    def initial(self, model: LocalModel, lower: Expression, upper: Expression) -> ScaledDisplacement:
        """By the rule."""
        if self.rule == "basic":
            return BasicSaturation.initial(lower, upper)
        return Saturation.initial(lower, upper, rounds=self.rounds or ROUNDS_PER_JOINT * model.robot.n)
