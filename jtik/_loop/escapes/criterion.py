"""The criterion escape: a move along the self-motion from a pose on target where H has a saddle point or a maximum.

There the gradient of H vanishes over the self-motion, and no step of a strategy moves the robot. Along the direction of
most negative curvature of the Lagrangian H falls to second order. The escape is deterministic, ends on target, and
keeps limits and clearances. See formulations/criterion_escape.md.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from jtik._loop.escapes.saddle import FIRST_STEP, HALVINGS, SaddleEscape
from jtik._loop.inspection import Inspector
from jtik._step.inputs import SETTING, Inputs
from jtik._step.stopping import Code
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.result.report import Report
from jtik.types import Array

SUFFICIENT = 0.1
"""Smallest fall of H, relative to that of the quadratic model, for which an escape is made."""

RESOLVED = 1e-9
"""A fall of H below this fraction of H is measured by the gradient: the difference of the values is rounding."""

TIE = 1e-6
"""Relative difference of the falls in both directions below which the sign is fixed by convention."""

CORRECTIONS = 10
"""Newton steps that lead an escape back to the target."""

EXACT = 1e-12
"""Change of the residual, relative to |J|, below which it counts as none."""

SHORT = 0.5
"""Largest correction, relative to the displacement that it corrects."""

STEP_LENGTH = 1e-3
"""Longest escape of `InverseKinematics.step` [rad]: the steps that follow make it longer."""

STEP_SHARE = 0.1
"""Longest escape of a timed step [rad], for the share 1 of the null-space displacement."""


class CriterionEscape:
    """The escape from saddle points and maxima of H on the self-motion."""

    def __init__(self, problem: SymbolicProblem, inspector: Inspector, escape: SaddleEscape) -> None:
        self._robot, self._bounded = problem.robot, problem.scalar
        self._inspector, self._clear = inspector, escape.clear
        self.possible = problem.has_criterion

    def needed(self, q: Array, inputs: Inputs[Array]) -> Report | None:
        """The report of q, on target, where H is stationary and not minimal; else None."""
        if not self.possible or inputs.settings[SETTING.until_stationary] == 0.0:
            return None
        return self._inspector.saddle(q, inputs)

    def escape(self, q: Array, inputs: Inputs[Array], longest: float = FIRST_STEP) -> bool:
        """Move q, which is on target, away from a saddle point or a maximum of H.

        Args:
            q: configuration, (nq,), changed in place.
            inputs: target, parameters, limits and settings.
            longest: length of the first displacement tried [rad].

        Returns:
            Whether ``q`` was changed.
        """
        before = self.needed(q, inputs)
        if before is None or before.lowest_curvature is None:
            return False
        curvature, z = before.lowest_curvature.value, before.lowest_curvature.direction
        if z[np.argmax(np.abs(z))] < 0:
            z = -z
        moving = z != 0
        moving |= ~np.isin(np.arange(len(z)), [*before.at_upper, *before.at_lower])
        length = longest
        for _ in range(HALVINGS):
            model = -curvature * length**2 / 2
            found = []
            for sign in (1.0, -1.0):
                end = self._on_target(before, q, sign * length * z, moving, inputs)
                if end is not None:
                    fall = self._fall(before, q, end, moving, inputs, model)
                    found += [(fall, end)] if fall >= SUFFICIENT * model else []
            if found:
                q[:] = found[-1][1] if found[-1][0] > (1 + TIE) * found[0][0] else found[0][1]
                return True
            length /= 2
        return False

    def _on_target(
        self, before: Report, q: Array, v: Array, moving: NDArray[np.bool_], inputs: Inputs[Array]
    ) -> Array | None:
        """The configuration after the displacement v, with the residual of q; None where there is no such allowed one.

        Args:
            before: the report of q.
            q: where the displacement begins, (nq,).
            v: the displacement, (n,).
            moving: the joints that may move, (n,).
            inputs: target, parameters, limits and settings.
        """
        robot, exact = self._robot, EXACT * float(np.linalg.norm(before.weighted))
        end, correction = np.asarray(robot.integrate(q, v)), np.zeros(len(v))
        for _ in range(CORRECTIONS):
            here = self._inspector.evaluated(end, inputs)
            if not here.finite:
                return None
            off = here.residual - before.residual
            if np.linalg.norm(off) <= exact:
                break
            correction[moving] = -np.linalg.pinv(here.weighted[:, moving], rcond=here.rank_threshold) @ off
            end = np.asarray(robot.integrate(end, correction))
            if np.linalg.norm(np.asarray(robot.difference(q, end)) - v) > SHORT * np.linalg.norm(v):
                return None
        else:
            return None
        allowed = here.reached and all(inputs.lower[i] <= end[i] <= inputs.upper[i] for i, _ in self._bounded)
        return end if allowed and self._clear(q, np.asarray(robot.difference(q, end)), inputs) else None

    def _fall(
        self, before: Report, q: Array, end: Array, moving: NDArray[np.bool_], inputs: Inputs[Array], model: float
    ) -> float:
        """By how much H falls from q to ``end``; ``model`` is the fall of the quadratic model."""
        after = self._inspector.evaluated(end, inputs)
        if model > RESOLVED * sum(map(abs, before.values.values())):
            return sum(before.values.values()) - sum(after.values.values())
        J, way = after.weighted[:, moving], np.asarray(self._robot.difference(q, end))[moving]
        along = way - np.linalg.pinv(J, rcond=after.rank_threshold) @ (J @ way)
        return -float(after.gradient[moving] @ along) / 2


class Escapes:
    """The escapes of an attempt, by the code of the call that ended it.

    Attributes:
        saddle: from saddle points of V, off the target.
        criterion: from saddle points and maxima of H, on target.
    """

    def __init__(self, saddle: SaddleEscape, criterion: CriterionEscape) -> None:
        self.saddle, self.criterion = saddle, criterion

    def escape(self, code: Code, q: Array, inputs: Inputs[Array]) -> bool:
        """Move q away from a saddle point where an attempt has ended with this code; whether it was moved."""
        if code is Code.STALLED:
            return self.saddle.escape(q, inputs)
        return code is Code.DONE and self.criterion.escape(q, inputs)


class StepEscape:
    """The criterion escape of `InverseKinematics.step`: short, and tested only where the arm has newly come to rest.

    While every call is done and begins where the last one ended, with the same target and parameters, the arm is at
    rest at the minimum that was found first.

    Attributes:
        possible: whether there is a criterion.
        resting: whether the arm is at rest, (1,); assign 0 where a call was not done.
    """

    def __init__(self, criterion: CriterionEscape) -> None:
        self.possible, self._criterion = criterion.possible, criterion
        self.resting, self._rest = np.zeros(1, dtype=np.int64), b""

    def escape(self, started: bytes, q: Array, inputs: Inputs[Array]) -> bool:
        """Move q, where a call that is done has ended, away from a saddle point or a maximum of H.

        Args:
            started: the bytes of the configuration with which the call was made.
            q: where it ended, (nq,), changed in place.
            inputs: target, parameters, limits and settings of the call.

        Returns:
            Whether ``q`` was changed.
        """
        same = inputs.target.tobytes() + inputs.parameters.tobytes()
        if not self.resting[0] or started + same != self._rest:
            share = float(inputs.settings[SETTING.null_space_share])
            if self._criterion.escape(q, inputs, min(STEP_LENGTH, STEP_SHARE * share)):
                self.resting[0] = 0
                return True
        self.resting[0], self._rest = 1, q.tobytes() + same
        return False
