"""The clearances of a problem at one configuration, for the step and for the escape from a saddle point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from jtik._step.safe_path import figures_of, safe_path
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.clearance import ClearanceModel, RowValues
from jtik.constraints.motion_bound import MotionBound
from jtik.symbolic import MX, SX, Expression, Function, function, identity, numbers, vertcat


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
        measured: distances, their Jacobian and their figures, as `Measurement.clearance` returns them; then what
            follows from them and the state, where it is computed with them.
        parameters: live parameters.
        limits: lower and upper limits of q.
        state: state of the step, with that of the feasibility restoration; None outside a solve.
    """
    state = state or {}
    distance, J, figures, *rows = measured
    safe, aim, influence, gain = (figures[:, i] for i in range(4))
    restored = vertcat(*problem.measured.restored.astype(float).tolist())
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
        path=lambda dq: path(
            q,
            problem.coordinates.to_joints(dq),
            parameters,
            *limits,
            figures_of([distance, safe, aim, figures[:, 4], restored]),
        ),
        restored=problem.measured.restored,
        longest=state.get("longest", 0),
        smallest_violation=state.get("violation", 0),
        rows=RowValues(*rows) if rows else None,
    )


@dataclass(frozen=True)
class Apart:
    """Parts of a local model that are a function of their own, with loops.

    Attributes:
        function: (what is given) -> the parts.
        given: expressions of the step's inputs.
    """

    function: Function
    given: list[Expression]


def measured_apart(
    problem: SymbolicProblem, q: Expression, parameters: Expression, state: Mapping[str, Expression]
) -> Apart | None:
    """What `clearance_model` is given, in the coordinates of the step, as a function with loops; None without any.

    Args:
        problem: the problem.
        q: configuration (nq, 1).
        parameters: live parameters.
        state: state of the step.
    """
    rows, robot = problem.measured.rows, problem.robot
    if rows is None:
        return None
    given = [q, parameters, SX(state.get("longest", 0))]
    at, live, longest = symbols = [MX.sym(f"i{i}", each.shape[0]) for i, each in enumerate(given)]
    distances, J, figures = rows(at, live)
    movable = numbers(problem.movable(identity(robot.n)))
    if movable is not None and (movable != np.eye(robot.n)).any():
        J = J @ MX(movable)
    limits = MX(robot.lower), MX(robot.upper)  # which the figures of the rows do not depend on
    model = clearance_model(problem, at, [distances, J, figures], live, limits, {"longest": longest})
    return Apart(function("jtik_measured", symbols, [distances, J, figures, *model.of_rows], cse=False), given)
