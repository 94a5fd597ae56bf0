"""The figures of one step for a trace."""

from __future__ import annotations

import math

from jtik._step.checked_update import CheckedUpdate
from jtik._step.relaxation import RelaxationTerms
from jtik._step.vector_layout import VectorLayout
from jtik.strategy import LocalModel
from jtik.symbolic import Expression, vertcat

OPTIONAL = ("alpha", "beta", "V2", "predicted_decrease")
"""Figures of a strategy that every trace has; NaN where a strategy does not give one."""


def figures_of(
    model: LocalModel, update: CheckedUpdate, accepted: Expression, relaxation: RelaxationTerms
) -> tuple[VectorLayout, dict[str, Expression]]:
    """Layout and expressions of the record of a step."""
    here, joints = model.here, model.coordinates
    J_free = joints.jacobian_by_joints(model.J_free)
    figures = {
        "V": here.V_to_target,
        "H": here.H,
        "accepted": accepted,
        "null_residual": model.stationarity_residual if model.has_criterion else 0,
        **dict.fromkeys(OPTIONAL, math.nan),
        "actual_decrease": here.decrease(update.candidate),
        **update.figures,
        **relaxation.figures,
        "dq": joints.to_joints(update.dq),
        "null_space": joints.to_joints(update.null_space),
        "J": vertcat(*[J_free[:, j] for j in range(model.robot.n)]),
        "null_space_image": model.J @ update.null_space,
    }
    return VectorLayout.of({name: _rows(value) for name, value in figures.items()}), figures


def _rows(value: Expression) -> int:
    """Number of rows of a column; 1 for a number."""
    return int(getattr(value, "shape", (1, 1))[0])
