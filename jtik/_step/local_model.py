"""The local model of a problem at one configuration, which a strategy works with."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from jtik._step.active_set import ActiveSet, clamped
from jtik._step.braking import Braking
from jtik._step.clearances import Apart, clearance_model, measured_apart
from jtik._step.distant_target import NearerTarget
from jtik._step.inputs import Inputs, Settings
from jtik._step.stagnation import Stagnation
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.qp.recorder import QPRecorder
from jtik.robot import WeightedCoordinates
from jtik.strategy import Evaluation, LocalModel
from jtik.symbolic import (
    TINY,
    Expression,
    Function,
    fmax,
    if_else,
    is_finite,
    norm,
    ratio,
    sqrt,
    substitute,
    sumsqr,
    symbol,
)
from jtik.symbolic.factorization import squared_length
from jtik.types import Array

NEIGHBOURHOOD = 0.02
"""Radius of the neighbourhood of the target relative to |J|: the error that a motion of this many rad (or m) makes."""


LEFT_OUT = 1.5
"""Curvature that J' J leaves out, relative to the error times the root mean square of the columns of J."""

RETURN = 0.1
"""Damping of a timed step relative to V [1 / rad^2]: negligible beside J J' on a path that is followed."""

SINGULAR = 1e-12
"""Smallest damping of a timed step relative to |J|^2: what is left of an error outside the range stays rounding."""


@dataclass(frozen=True)
class Linearized:
    """A problem linearised at one configuration.

    Attributes:
        parts: q, residual, Jacobian, H and its gradient as expressions of the inputs, the last two only with a
            criterion where several stages share them; the unshifted residual where the problem has one; with clearances
            distances, their Jacobian and their figures.
        at: the same as the strategy gets them: symbols where several stages of a step share them.
        model: the local model, written in ``at``.
        active_set: the active set; None without limits.
        gradient_finite: 1 where the gradient of the criterion is finite. Where it is not, the model has a gradient of
            zero, and the task goes on without the criterion.
        stagnation: whether the error has stopped falling; None for a step that does not ask.
        apart: the last of the parts, those of clearances, where they are a function of their own, which has what
            follows from them, too. They are not among ``parts`` then.
    """

    parts: list[Expression]
    at: list[Expression]
    model: LocalModel
    active_set: ActiveSet | None
    gradient_finite: Expression = 1
    stagnation: Stagnation | None = None
    apart: Apart | None = None


def linearized(
    problem: SymbolicProblem,
    start: Expression,
    inputs: Inputs[Expression],
    state: Mapping[str, Expression],
    qps: QPRecorder | None,
    *,
    uses_qp: bool = False,
    timed: bool = False,
    by_level: bool = False,
    acceleration: Array | None = None,
    explores: bool = False,
    replaceable: bool = False,
    rests: bool = False,
) -> Linearized:
    """The problem at ``start`` (nq, 1), clamped to the limits.

    Args:
        problem: the problem.
        start: configuration at the start of the step (nq, 1).
        inputs: inputs of the step.
        state: state of the step.
        qps: records the quadratic programs; None for a strategy without any.
        uses_qp: whether the strategy's own quadratic programs find the active limits.
        timed: whether the step has a duration.
        by_level: whether the strategy respects levels of priority.
        acceleration: limits of acceleration of a timed step (n,); None without any.
        explores: whether it is the step that takes over where V has stopped falling.
        replaceable: whether a restart replaces what does not soon reach the target: a cheaper model is enough.
        rests: whether it is damped where the error has stopped falling, if the settings ask for it.
    """
    limits, settings = (inputs.lower, inputs.upper), Settings.of(inputs.settings)
    of_residual = problem.near_jacobian() if replaceable else problem.residual_jacobian
    at_limits, apart = clamped(start, *limits, problem.bounded), None
    if qps and problem.clearances:
        apart = measured_apart(problem, at_limits, inputs.parameters, state)
    parts = _parts(problem, of_residual, at_limits, inputs.target, inputs.parameters, clearances=apart is None)
    local = at = parts
    if qps:  # without a criterion H and its gradient stay zeros in all stages, from which nothing is computed
        fixed = range(3, 3 if problem.has_criterion else 5)
        local = [part if k in fixed else symbol(f"at{k}", *part.shape) for k, part in enumerate(parts)]
        if apart:
            local += [symbol(f"m{i}", *apart.function.size_out(i)) for i in range(apart.function.n_out())]
        parts, at = ([each for k, each in enumerate(group) if k not in fixed] for group in (parts, local))
    q, whole, J, H, gradient = local[:5]
    residual, unshifted = whole, local[5] if problem.unshifted else None
    nearer = None if timed or replaceable else NearerTarget.of(problem, whole, by_level=by_level)
    coordinates = problem.coordinates
    if nearer and nearer.weights_differ and explores and not by_level:
        scale = nearer.joint_scale(J, state["explored"] > 0)
        coordinates, change = coordinates.scaled(scale), WeightedCoordinates(scale)
        J, gradient = change.jacobian(J), change.gradient(gradient)
    if nearer:
        residual, J = nearer.residual, nearer.weighted(J)
        unshifted = None if unshifted is None else nearer.weighted(unshifted)
    here = Evaluation(q, residual, H, unshifted=unshifted, whole=whole)
    neighbourhood = near_target = 0
    gradient_finite: Expression = 1
    if problem.has_criterion:
        gradient_finite = is_finite(gradient)
        gradient = if_else(gradient_finite, gradient, 0)
        known = state["neighbourhood"]
        neighbourhood = if_else(known > 0, known, NEIGHBOURHOOD * sqrt(squared_length(J) + TINY))
        near_target = here.length <= neighbourhood
    active = None
    if problem.bounded:
        moving = acceleration is not None
        active = ActiveSet(problem, state, here, near_target, J, gradient, limits, uses_qp=uses_qp, moving=moving)
    J_free = active.masked(J) if active else J
    squared = squared_length(J)
    curvature = _curvature(squared, J.shape[1], state["remaining"], whole) if timed else 0
    stagnation = Stagnation.of(state, here) if rests else None
    braking = None
    if acceleration is not None:
        braking = Braking.of(
            problem,
            state,
            J_free,
            curvature=curvature,
            singular=SINGULAR * squared,
            acceleration=acceleration,
            time=settings.braking_time,
        )
        here = replace(here, residual=whole - braking.shift)
    model = LocalModel(
        robot=problem.robot,
        here=here,
        J=J,
        gradient=gradient,
        J_free=J_free,
        gradient_free=active.masked(gradient.T).T if active else gradient,
        has_criterion=problem.has_criterion,
        near_target=near_target,
        neighbourhood=neighbourhood,
        lower=inputs.lower,
        upper=inputs.upper,
        bounded=problem.bounded,
        levels=problem.levels,
        residual_function=problem.residual,
        criterion_function=problem.criterion,
        least_squares=problem.least_squares,
        target=inputs.target,
        parameters=inputs.parameters,
        qps=qps,
        coordinates=coordinates,
        unshifted_function=problem.unshifted,
        weights=nearer.weights if nearer else 1 if braking else None,
        shift=nearer.shift if nearer else braking.shift if braking else None,
        clearance=clearance_model(problem, q, local[5 + bool(problem.unshifted) :], inputs.parameters, limits, state)
        if problem.clearances
        else None,
        tasks=problem.tasks,
        timed=timed,
        accelerated=acceleration is not None,
        position_limits=problem.position_limits if timed else None,
        weak_motion=braking.weak_motion if braking else 0,
        curvature=curvature,
        stagnation_damping=stagnation.damping(_left_out(norm(residual), squared, J.shape[1]), settings.rests)
        if stagnation
        else 0,
        null_space_share=_null_space_share(settings, state, neighbourhood),
    )
    return Linearized(parts, at, model, active, gradient_finite, stagnation, apart)


def _null_space_share(settings: Settings, state: Mapping[str, Expression], neighbourhood: Expression) -> Expression:
    """Share of a null-space displacement that a step takes; less of it where the last step has left an error."""
    if "null_space_left" not in state:
        return 1
    reached = fmax(1 - ratio(state["remaining"], neighbourhood), 0)
    return settings.null_space_share * state["null_space_left"] * reached


def _curvature(squared: Expression, n: int, remaining: Expression, residual: Expression) -> Expression:
    """Size of the curvature of V that J' J leaves out, for an error that remains after the step.

    The second derivative of a point's position by two joints is at most as long as a column of J. A share of V bounds
    the first step after the target has come back into reach, and one of |J|^2 keeps a step in the row space.
    """
    return _left_out(remaining, squared, n) + RETURN * sumsqr(residual) / 2 + SINGULAR * squared


def _left_out(error: Expression, squared: Expression, n: int) -> Expression:
    """Size of that curvature for an error, from the squared norm of J."""
    return LEFT_OUT * error * sqrt(squared / n)


def _parts(
    problem: SymbolicProblem,
    of_residual: Function,
    q: Expression,
    target: Expression,
    parameters: Expression,
    *,
    clearances: bool,
) -> list[Expression]:
    """The `Linearized.parts`, with this Jacobian of the residual, and with or without those of clearances."""
    at = symbol("at", problem.robot.nq)
    H, gradient = problem.criterion_gradient(at, parameters)
    J = problem.movable(of_residual(at, target))
    gradient = problem.movable(gradient.T).T
    parts = [problem.residual(at, target), J, H, gradient]
    if problem.unshifted:
        parts.append(problem.unshifted(at, target))
    if problem.clearances and clearances:
        distances, of_distances, figures = problem.measured.clearance(at, parameters)
        parts += [distances, problem.movable(of_distances), figures]
    return [q, *substitute(parts, [at], [q])]  # together: they share most of their values
