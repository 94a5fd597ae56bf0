"""Why a solve stopped, as a sentence."""

from __future__ import annotations

from enum import Enum


class Status(Enum):
    """Why a solve stopped. The value is the sentence that a Solution prints."""

    CONVERGED = "converged: on target, and the criterion cannot fall further without leaving it"
    REACHED = "reached the target; the criterion could still fall"
    LOCAL_MINIMUM = "out of reach, or a local minimum of the error: this is the closest posture nearby"
    LIMITS = "held by joint limits: the error could fall if the joints at their limits could move on"
    BLOCKED = "held by clearances: the error could fall if bodies might come nearer to the obstacles"
    SINGULAR = "stopped at a singularity: no direction the robot can move in brings the target nearer"
    STALLED = "stalled: no step the strategy tried brought the target nearer"
    ITERATION_LIMIT = "reached the iteration limit before the target"
    UNSOLVED = "a quadratic program of the step has no answer: contradictory rows, not convex, or its solver failed"
    NOT_FINITE = "error or criterion is not a finite number here; q is the last configuration where they were"

    @property
    def on_target(self) -> bool:
        """Whether the errors are within their tolerances."""
        return self in (Status.CONVERGED, Status.REACHED)


def is_success(status: Status, until: str) -> bool:
    """Whether a solve with this ``until`` has achieved what was asked for."""
    return status is Status.CONVERGED or (status is Status.REACHED and until == "reached")
