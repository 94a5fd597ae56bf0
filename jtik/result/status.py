"""Statuses: why a solve stopped, each as a sentence."""

from __future__ import annotations

from enum import Enum


class Status(Enum):
    """Why a solve stopped. The value is the sentence that a Solution prints.

    Attributes:
        CONVERGED: the target is reached, and the criterion, if any, is stationary.
        REACHED: the target is reached, and the criterion is not stationary.
        SADDLE: the target is reached, and the criterion is stationary and not minimal.
        LOCAL_MINIMUM: the target is not reached, and the error has a local minimum at q.
        LIMITS: the error is stationary only because of active joint limits.
        JUMP_LIMIT: the target is not reached within the largest change of the joints that ``jump_limit`` allows.
        BLOCKED: the target is not reached, and a clearance is as small as it may become.
        SINGULAR: the error is stationary and not minimal, at a singularity of the Jacobian.
        STALLED: the error is not stationary, and no step of the strategy was accepted.
        ITERATION_LIMIT: the solve used all its iterations before it reached the target.
        UNSOLVED: a quadratic program of the step has no valid solution.
        NOT_FINITE: an error or a criterion is infinite or NaN.
    """

    CONVERGED = "converged: on target, and the criterion cannot fall further without leaving it"
    REACHED = "reached the target; the criterion could still fall"
    SADDLE = "on target, at a saddle point or a maximum of the criterion, which could still fall"
    LOCAL_MINIMUM = "out of reach, or a local minimum of the error: this is the closest posture nearby"
    LIMITS = "stopped at joint limits: the error could fall if the joints at their limits could move further"
    JUMP_LIMIT = "stopped at jump_limit: the target is not reached within this change of the joints from q0"
    BLOCKED = "stopped at clearances: the error could fall if bodies could come closer to the obstacles"
    SINGULAR = "stopped at a singularity: no direction in which the robot can move reduces the error"
    STALLED = "stalled: no step that the strategy tried reduced the error"
    ITERATION_LIMIT = "reached the iteration limit before the target"
    UNSOLVED = "a quadratic program of the step has no solution: contradictory rows, not convex, or its solver failed"
    NOT_FINITE = "error or criterion is not a finite number here; q is the last configuration where they were"

    @property
    def on_target(self) -> bool:
        """Whether the errors are within their tolerances."""
        return self in (Status.CONVERGED, Status.REACHED, Status.SADDLE)


def is_success(status: Status, until: str) -> bool:
    """Whether a solve with this ``until`` is a success: "stationary" needs a criterion that cannot fall further."""
    return status is Status.CONVERGED or (status.on_target and until == "reached")
