"""Single steps calculated by hand: the exact result of one update of a strategy."""

from __future__ import annotations

import math

import numpy as np

from jtik.problems.case import Case, ProblemSet
from jtik.problems.collection.named_problem import NamedProblem, centering
from jtik.problems.five_families import tip
from jtik.robot import Robot
from jtik.task import FrameTask

_QUARTER = math.pi / 2


def sns_4r() -> NamedProblem:
    """Four joints with velocity limits, two of which the minimum-norm velocity violates."""
    origin = "Flacco, De Luca and Khatib, ICRA 2012: saturation in the null space, planar 4R"
    q = np.array([1, -1, 1, -1]) * _QUARTER
    solutions = {
        1.0: (1.0, (2.0, -11 / 6, 11 / 6, -11 / 3)),
        1.5: (8 / 11, (2.0, -2.0, 26 / 11, -4.0)),
        2.0: (6 / 11, (2.0, -2.0, 26 / 11, -4.0)),
        3.0: (4 / 11, (2.0, -2.0, 26 / 11, -4.0)),
    }
    cases = []
    for times, (scale, dq) in solutions.items():
        target = tip(q) + times * np.array([-4.0, -1.5])
        error = max(0.0, float(np.hypot(*target)) - 4)
        cases.append(
            Case(
                name=f"sns_4r x{times:g}",
                kind="step",
                q0=q,
                targets=(target,),
                dt=1.0,
                reachable=error == 0,
                known={"error": error, "scale": scale} | {f"dq_{i}": value for i, value in enumerate(dq, 1)},
                origin=origin,
            )
        )
    return NamedProblem(
        name="sns_4r",
        summary="one step of 1 s under velocity limits: the velocity dq_i [rad/s] and the task scale",
        robot=Robot.planar(4, velocity_limit=[2, 2, 4, 4]),
        task=FrameTask("tip"),
        problems=ProblemSet("sns_4r", tuple(cases), origin=origin),
        origin=origin,
    )


def transpose_step_2r() -> NamedProblem:
    """One step of the transpose method with its optimal gain."""
    origin = "Das, Slotine and Sheridan 1988, (A.10) to (A.12), calculated for two unit links"
    q, target = np.array([0.0, _QUARTER]), np.array([0.0, 1.5])
    alpha = 13 / 34
    dq = alpha * np.array([1.5, 1.0])
    known = {
        "alpha": alpha,
        "dq_1": float(dq[0]),
        "dq_2": float(dq[1]),
        "V": 0.625,
        "predicted_V": 1 / 272,
        "V_after": float(((tip(q + dq) - target) ** 2).sum() / 2),
        "error": 0.0,
    }
    case = Case(
        name="transpose_step_2r",
        kind="step",
        q0=q,
        targets=(target,),
        reachable=True,
        known=known,
        origin=origin,
    )
    return NamedProblem(
        name="transpose_step_2r",
        summary="one transpose step: alpha, dq_i [rad], and V [m^2] before, after, and predicted by the linear model",
        robot=Robot.planar(2),
        task=FrameTask("tip"),
        problems=ProblemSet("transpose_step_2r", (case,), origin=origin),
        origin=origin,
    )


def null_projector_3r() -> NamedProblem:
    """Projection of the gradient (1, 1, 1) onto the null space of three links at right angles."""
    origin = "three unit links at right angles: N = (1, -1, 1)' (1, -1, 1) / 3"
    q = np.full(3, _QUARTER)
    known = {"null_1": 1 / 3, "null_2": -1 / 3, "null_3": 1 / 3, "null_norm": 1 / math.sqrt(3), "H_start": 1.5}
    case = Case(
        name="null_projector_3r",
        kind="step",
        q0=q,
        targets=(tip(q),),
        reachable=True,
        known=known | {"error": 0.0},
        origin=origin,
    )
    return NamedProblem(
        name="null_projector_3r",
        summary="a start on its target with dH/dq = (1, 1, 1): its projection null_i onto the null space",
        robot=Robot.planar(3),
        task=FrameTask("tip"),
        criteria=centering(q - 1),
        problems=ProblemSet("null_projector_3r", (case,), origin=origin),
        origin=origin,
    )
