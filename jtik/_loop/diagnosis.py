"""Why a solve stopped: what the fused function's code and the last configuration say, as a Status."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property, partial

import numpy as np

from jtik._loop.saddle_escape import FLAT, NEGATIVE, SaddleEscape
from jtik._step.inputs import Inputs, Settings
from jtik._step.relaxation import Relaxation
from jtik._step.stopping import Code
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import AT_LIMIT
from jtik.result.report import Report
from jtik.result.solution import Status
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array


class Diagnosis:
    """Looks at where a solve ended."""

    def __init__(
        self,
        problem: SymbolicProblem,
        rescue: SaddleEscape,
        yielded: Callable[[Array, Inputs[Array]], tuple[Relaxation, ...]] | None = None,
    ) -> None:
        self._problem, self._rescue, self._yielded = problem, rescue, yielded
        self._evaluate = CompiledFunction(problem.report())
        self._error = CompiledFunction(problem.error)
        self._linear = np.array(problem.linear, dtype=bool)
        self._q_index = np.array([i for i, _ in problem.bounded], dtype=int)
        self._v_index = np.array([j for _, j in problem.bounded], dtype=int)
        self._criteria = [name for name, _, _ in problem.terms.named]
        robot = problem.robot
        self._joints = {robot.v_slice(name).start: name for name in robot.joint_names}

    @cached_property
    def _clearance(self) -> CompiledFunction:
        return CompiledFunction(self._problem.clearance)

    @cached_property
    def _hessian(self) -> CompiledFunction:
        return CompiledFunction(self._problem.hessian())

    def _curvature(self, q: Array, inputs: Inputs[Array], multipliers: Array) -> Array:
        """The Hessian of the Lagrangian, compiled when first asked for, (n, n)."""
        return self._hessian(q, inputs.target, inputs.parameters, multipliers)[0]

    def report(self, q: Array, inputs: Inputs[Array]) -> Report:
        """Everything a Solution tells of the configuration q."""
        tolerances = Settings(*inputs.settings.tolist())[:3]
        error, jacobian, values, gradient, residual, weighted = self._evaluate(q, inputs.target, inputs.parameters)
        at_upper: tuple[int, ...] = ()
        at_lower: tuple[int, ...] = ()
        if self._q_index.size:
            own = q[self._q_index]
            at_upper = tuple(self._v_index[own >= inputs.upper[self._q_index] - AT_LIMIT].tolist())
            at_lower = tuple(self._v_index[own <= inputs.lower[self._q_index] + AT_LIMIT].tolist())
        return Report(
            error=error[:, 0],
            jacobian=jacobian,
            linear=self._linear,
            residual=residual[:, 0],
            weighted=weighted,
            values=dict(zip(self._criteria, values[:, 0].tolist(), strict=True)),
            gradient=gradient[:, 0],
            at_upper=at_upper,
            at_lower=at_lower,
            active_limits=tuple(self._joints[j] for j in sorted({*at_upper, *at_lower})),
            tolerances=(float(tolerances[0]), float(tolerances[1]), float(tolerances[2])),
            curvature=partial(self._curvature, q, inputs) if self._criteria else None,
            yielded=partial(self._yielded, q, inputs) if self._yielded else None,
        )

    def errors(self, q: Array, inputs: Inputs[Array]) -> tuple[float, float]:
        """Norms of the position rows [m] and of the orientation rows [rad] at q."""
        error = self.error(q, inputs)
        return float(np.linalg.norm(error[self._linear])), float(np.linalg.norm(error[~self._linear]))

    def error(self, q: Array, inputs: Inputs[Array]) -> Array:
        """The task error at q, (m,)."""
        return self._error(q, inputs.target)[0][:, 0]

    def _blocked(self, q: Array, inputs: Inputs[Array]) -> bool:
        """Whether a clearance is as small as its rows let it become."""
        if not self._problem.clearances:
            return False
        distance, _, figures = self._clearance(q, inputs.parameters)
        margin = figures[:, 1] - figures[:, 0]
        return bool((distance[:, 0] < figures[:, 1] + margin).any())

    def status(self, q: Array, code: Code, look: Callable[[], Report], inputs: Inputs[Array]) -> Status:
        """The reason, in the order a user would ask for it."""
        if code is Code.DONE and not self._criteria:
            return Status.CONVERGED  # the step has tested it
        report = look()
        if code is Code.NOT_FINITE or not report.finite:
            return Status.NOT_FINITE
        if code is Code.UNSOLVED and not report.reached:
            return Status.UNSOLVED
        if report.reached:
            # what clearances hold back is in the step's own test, not in the report
            stationary = code is Code.DONE if self._problem.clearances else report.stationary
            return Status.CONVERGED if not self._criteria or stationary else Status.REACHED
        if code is Code.GO_ON:
            return Status.ITERATION_LIMIT
        if self._blocked(q, inputs):
            return Status.BLOCKED
        everything, free = report.flatness
        if everything > FLAT:
            return Status.LIMITS if free <= FLAT else Status.STALLED
        lowest = self._rescue.lowest_curvature(q, inputs)[0]
        # beside a minimum curvatures that are zero on it can be as far below zero as the slope is from it
        return Status.LOCAL_MINIMUM if lowest > -max(NEGATIVE, everything) else Status.SINGULAR
