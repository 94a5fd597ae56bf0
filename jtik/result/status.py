"""Statuses: why a solve stopped, each as a sentence."""

from __future__ import annotations

from enum import Enum


class Status(Enum):
    """Why a solve stopped. The value is the sentence that a Solution prints.

    Attributes:
        CONVERGED: the target is reached, and the criterion, if any, is stationary.
        REACHED: the target is reached, and the criterion is not stationary.
        SADDLE: the target is reached, and the criterion is stationary and not minimal.
        COMPROMISE: the weighted sum of task error and criterion, which a strategy with ``is_soft`` minimises, is
            stationary, and the criterion's weight keeps the error above the tolerance.
        LOCAL_MINIMUM: the target is not reached, and the error has a local minimum at q.
        PRIORITIES: the highest levels of priority are reached, the others as near as those and the limits allow. It is
            what the priorities ask for, to first order and near q0, of a strategy that respects them. ``converged`` is
            False, as wherever a task is not within its tolerance; `Solution.relaxed` has the errors that remain.
        LIMITS: the error is stationary only because of active joint limits.
        JUMP_LIMIT: the target is not reached within the largest change of the joints that ``jump_limit`` allows.
        BLOCKED: the target is not reached, and a clearance is as small as it may become.
        SINGULAR: the error is stationary and not minimal, at a singularity of the Jacobian.
        STALLED: the error is not stationary, and no step of the strategy was accepted.
        ITERATION_LIMIT: the solve used all its iterations before it reached the target.
        UNSOLVED: a quadratic program of the step has no valid solution.
        NOT_FINITE: an error, a criterion or a derivative is infinite or NaN. Where only the gradient of the criterion
            is, the solve goes on for the task, and ends so if it is still infinite on the target.
    """

    CONVERGED = "converged: on target, and the criterion, if any, cannot fall further without leaving it"
    REACHED = "reached the target; the criterion could still fall"
    SADDLE = "on target, at a saddle point or a maximum of the criterion, which could still fall"
    COMPROMISE = "stationary point of the weighted sum of task error and criterion: the error is what the weight costs"
    LOCAL_MINIMUM = "out of reach, or a local minimum of the error: this is the closest posture nearby"
    PRIORITIES = (
        "as near as the priorities allow: the higher ones are reached, and the lower ones are nearest beside them"
    )
    LIMITS = "stopped at joint limits: the error could fall if the joints at their limits could move further"
    JUMP_LIMIT = "stopped at jump_limit: the target is not reached within this change of the joints from q0"
    BLOCKED = "stopped at clearances: the error could fall if bodies could come closer to the obstacles"
    SINGULAR = "stopped at a singularity: no direction in which the robot can move reduces the error"
    STALLED = "stalled: no step that the strategy tried reduced the error"
    ITERATION_LIMIT = "reached the iteration limit before the target"
    UNSOLVED = "a quadratic program of the step has no solution: contradictory rows, not convex, or its solver failed"
    NOT_FINITE = "error, criterion or a derivative of them is not a finite number here, and the solve cannot go on"

    @property
    def on_target(self) -> bool:
        """Whether the errors are within their tolerances."""
        return self in (Status.CONVERGED, Status.REACHED, Status.SADDLE)

    @property
    def depends_on_start(self) -> bool:
        """Whether restarts or another q0 may lead to the target although this solve has ended off it."""
        return self in (Status.LOCAL_MINIMUM, Status.LIMITS, Status.SINGULAR, Status.STALLED)


def is_success(status: Status, until: str) -> bool:
    """Whether a solve with this ``until`` is a success: "stationary" needs a criterion that cannot fall further."""
    return status is Status.CONVERGED or (status.on_target and until == "reached")
