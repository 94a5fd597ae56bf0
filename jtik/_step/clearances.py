"""The clearances of a problem at one configuration, for the step and for the escape from a saddle point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from jtik._step.safe_path import figures_of, safe_path
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.clearance import ClearanceModel
from jtik.constraints.motion_bound import MotionBound
from jtik.symbolic import Expression, vertcat


def clearance_model(
    problem: SymbolicProblem,
    q: Expression,
    measured: Sequence[Expression],
    parameters: Expression,
    limits: tuple[Expression, Expression],
    state: Mapping[str, Expression] | None = None,
) -> ClearanceModel:
    """The clearances at q.

    Args:
        problem: the problem.
        q: configuration (nq, 1).
        measured: distances, their Jacobian and their figures, as `SymbolicProblem.clearance` returns them.
        parameters: live parameters.
        limits: lower and upper limits of q.
        state: state of the step, with that of the feasibility restoration; None outside a solve.
    """
    state = state or {}
    distance, J, figures = measured
    safe, aim, influence, gain = (figures[:, i] for i in range(4))
    restored = vertcat(*problem.measured.restored.astype(float).tolist())
    figures_of_path = figures_of([distance, safe, aim, figures[:, 4], restored])
    path = safe_path(problem)
    return ClearanceModel(
        distance=distance,
        jacobian=J,
        safe=safe,
        aim=aim,
        influence=influence,
        gain=gain,
        curvature_radius=figures[:, 4],
        motion=MotionBound(problem.robot, q),
        path=lambda dq: path(q, problem.coordinates.to_joints(dq), parameters, *limits, figures_of_path),
        restored=problem.measured.restored,
        longest=state.get("longest", 0),
        smallest_violation=state.get("violation", 0),
    )
