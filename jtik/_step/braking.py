"""Braking with limits of acceleration: a timed step approaches its target so that the joints can stop there.

Derivation: formulations/motion.md, (Q5) to (Q7).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.symbolic import Expression, fabs, fmax, sqrt
from jtik.symbolic.factorization import damped_multipliers
from jtik.types import Array

IN_TIME = 0.5
"""Share of the accelerations for stopping at the target; the rest follows its motion and the curve of the task."""

LOST = 0.1
"""Share of the motion along weak directions that a step takes back."""


def initial_braking(problem: SymbolicProblem) -> dict[str, Array]:
    """The state of a robot at rest.

    "left" is the residual where the last step ended (m,), "momentum" the displacement from q to where the step starts
    (n,), which the caller writes.
    """
    return {"left": np.zeros(problem.m), "momentum": np.zeros(problem.robot.n)}


@dataclass(frozen=True)
class Braking:
    """What a step with limits of acceleration does so that the joints can stop at the target.

    Attributes:
        shift: the part of the residual that is left for later steps (m, 1).
        weak_motion: the displacement along weak directions that the step takes back from its start (n, 1).
    """

    shift: Expression
    weak_motion: Expression

    @classmethod
    def of(
        cls,
        problem: SymbolicProblem,
        state: Mapping[str, Expression],
        J: Expression,
        *,
        curvature: Expression,
        singular: Expression,
        acceleration: Array,
        time: Expression,
    ) -> Braking:
        """That of a step.

        Args:
            problem: the problem.
            state: the state of the step.
            J: the Jacobian of the residual without the joints whose limit is active (m, n).
            curvature: the damping of the step.
            singular: the smallest damping.
            acceleration: limits of acceleration (n,), infinite where there is none.
            time: duration of the step [s]; infinite for one that does not brake.
        """
        coordinates, left = problem.coordinates, state["left"]
        way = J.T @ damped_multipliers(J, curvature, left)
        steps: Expression = 0  # way of the slowest joint, in those in which it can stop
        for j in map(int, np.flatnonzero(acceleration < math.inf)):
            steps = fmax(steps, fabs(way[j]) / coordinates.entry(j, IN_TIME * acceleration[j] * time**2))
        root = sqrt(1 + 2 * steps)
        image = J @ coordinates.from_joints(state["momentum"])
        independent, damped = (damped_multipliers(J, mu, image) for mu in (singular, curvature))
        return cls((root - 1) / (root + 1) * left, LOST * (J.T @ (independent - damped)))
