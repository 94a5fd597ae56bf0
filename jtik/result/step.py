"""One update, for controllers."""

from __future__ import annotations

from typing import NamedTuple

from jtik.types import Array


class Step(NamedTuple):
    """One update, for controllers.

    Where the arm rests off its target a step does not say why; ``ik.solve(target, q0=q)`` does, or goes on.

    Attributes:
        q: configuration after the step, (nq,) [rad] and [m].
        position_error: norm of the position error there [m].
        orientation_error: norm of the orientation error there [rad].
        accepted: whether the step was taken; a refused one leaves q, and the next call tries a smaller one. It can be
            False where `done` is True: there is no step to take.
        done: whether nothing is left to do at the default tolerances.
        escaped: whether the step was an escape from a saddle point, of the error or of the criterion.

    Example:
        >>> ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask("tip"))
        >>> step = ik.step([0.3, 0.2, 0.1], [2.5, 1.0])
        >>> step.accepted
        True
    """

    q: Array
    position_error: float
    orientation_error: float
    accepted: bool
    done: bool
    escaped: bool
