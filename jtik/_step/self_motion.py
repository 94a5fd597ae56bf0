"""The self-motion at a configuration as compiled functions: its directions, and a displacement along one of them.

Derivation: formulations/null_space_jog.md.
"""

from __future__ import annotations

import math

from jtik._step.active_set import clamped
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import AT_LIMIT
from jtik.constraints.step_box import braking
from jtik.symbolic import (
    Expression,
    Function,
    diag,
    dot,
    fabs,
    fmax,
    fmin,
    function,
    horzcat,
    identity,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    norm,
    ratio,
    sqrt,
    symbol,
    vertcat,
)
from jtik.symbolic.factorization import RowSpace, squared_length

CORRECTIONS = 3
"""Newton corrections to the end effector's pose; each squares the error."""

PASSES = 2
"""How often joints that a direction pushes against their limits are left out of it."""

DEPENDENT = 1e-3
"""Length that a unit direction must keep in the null space, beside the directions before it, to count as one more."""

TOUCHING = 1e-12
"""Distance from its bound below which a displacement has brought a joint to it [rad] or [m]."""

PROBE = 1e-3
"""Shortest displacement whose middle is looked at [rad]."""

IN_TIME = 0.5
"""Share of the accelerations that is used to stop in time and to follow the curve; the rest is for its curvature."""

FAR = 1e3
"""Distance of a limit that counts as none [rad] or [m]."""

NOTHING = 1e-100
"""Length below which a wish is none."""


def null_space(problem: SymbolicProblem) -> Function:
    """(q, target, directions (n, n)) -> projector onto the null space (n, n), directions carried into it (n, n).

    The directions are projected and made orthonormal in their order; one of which nothing is left is zero.
    """
    q, target, _ = problem.symbols()
    n = problem.robot.n
    before = symbol("directions", n, n)
    projected = _NullSpace(problem, problem.residual_jacobian(q, _held(problem, q, target)))
    directions: list[Expression] = []
    for k in range(n):
        v = projected.of(before[:, k])
        for _ in range(2):
            for known in directions:
                v = v - dot(known, v) * known
        length = norm(v)
        directions.append(if_else(length > DEPENDENT, ratio(1, length) * v, 0))
    projector = horzcat(*[projected.of(identity(n)[:, j]) for j in range(n)])
    return function("null_space", [q, target, before], [projector, horzcat(*directions)])


def tangent(problem: SymbolicProblem) -> Function:
    """(q, target, parameters, lower, upper, wish (n,), weights of criteria, sign) -> direction, share, held, wish at q.

    The direction (n, 1) is a unit vector in the null space, or zero: the projection of the wish less the weighted
    gradients of the criteria, without the joints whose limits it would push them beyond if the motion has that sign.
    The share is the length of the projection relative to that of what was projected. A joint that is held has a 1.
    """
    q, target, parameters = problem.symbols()
    n, nq = problem.robot.n, problem.robot.nq
    lower, upper, wish, sign = symbol("lower", nq), symbol("upper", nq), symbol("wish", n), symbol("sign", 1)
    weights = symbol("weights", len(problem.terms.named))
    if problem.has_criterion:
        wish_here = wish - problem.gradient(dot(weights, problem.values(q, parameters)), q)
    else:
        wish_here = wish
    J = problem.residual_jacobian(q, _held(problem, q, target))
    free = [1] * n
    z = _NullSpace(problem, J).of(wish_here)
    for _ in range(PASSES if problem.bounded else 0):
        for i, j in problem.bounded:
            up = logic_and(q[i] >= upper[i] - AT_LIMIT, sign * z[j] > 0)
            down = logic_and(q[i] <= lower[i] + AT_LIMIT, sign * z[j] < 0)
            moving = free[j] * (z[j] ** 2 > AT_LIMIT**2 * dot(z, z))
            free[j] = if_else(logic_and(moving, logic_or(up, down)), 0, free[j])
        z = _NullSpace(problem, J, free).of(wish_here)
    length, whole = norm(z), norm(_unlocked(problem, wish_here))
    held = vertcat(*[logic_not(each) for each in free])
    outputs = [ratio(1, length) * z, if_else(whole > NOTHING, ratio(length, whole), 0), held, wish_here]
    return function("tangent", [q, target, parameters, lower, upper, wish, weights, sign], outputs)


def displaced(problem: SymbolicProblem, *, accelerated: bool) -> Function:
    """A displacement along a direction of the self-motion, as long as the box of q' allows.

    Inputs: q; target; lower and upper bounds of q'; lower and upper position limits; largest change of the step of each
    joint (n,); the direction (n,); joints that are held (n,); the length. Outputs: q'; length; change of the norms of
    the errors in [m] and in [rad], (2,); |J|.

    Args:
        problem: the problem.
        accelerated: whether any joint has a limit of acceleration, so that the motion has to begin to stop in time.
    """
    q, target, _ = problem.symbols()
    robot, nq, n = problem.robot, problem.robot.nq, problem.robot.n
    lower, upper, z, length = symbol("lower", nq), symbol("upper", nq), symbol("direction", n), symbol("length", 1)
    limits, change, at_limit = [symbol(name, nq) for name in ("low", "high")], symbol("change", n), symbol("held", n)
    free = [logic_not(at_limit[j]) for j in range(n)]
    held = _held(problem, q, target)
    half = if_else(length < 0, fmin(length, -PROBE), fmax(length, PROBE)) / 2
    middle = robot.integrate(q, half * z)
    along = _NullSpace(problem, problem.residual_jacobian(middle, held), free).of(z)
    along = ratio(1, norm(along)) * along
    wanted = length
    if accelerated:
        longest = _stoppable(problem, q, limits, along, change, length)
        for j in range(n):
            longest = fmin(longest, sqrt(IN_TIME * _ratio(change[j], fabs(along[j] - z[j]) / fabs(half))))
        wanted = fmin(fmax(length, -longest), longest)
    smallest: Expression = -math.inf
    largest: Expression = math.inf
    for i, j in problem.bounded:
        moves = fabs(along[j]) > TOUCHING
        ends = [ratio(bound - q[i], if_else(moves, along[j], 1)) for bound in (lower[i], upper[i])]
        smallest = fmax(smallest, if_else(moves, fmin(*ends), smallest))
        largest = fmin(largest, if_else(moves, fmax(*ends), largest))
    taken = fmin(fmax(wanted, smallest), largest)
    end = clamped(robot.integrate(q, taken * along), lower, upper, problem.bounded)
    for i, j in problem.bounded:
        inside = logic_and(end[i] > lower[i] + TOUCHING, end[i] < upper[i] - TOUCHING)
        free[j] = logic_and(free[j], inside)
    start = problem.residual(q, held)
    for _ in range(CORRECTIONS):
        J = _without(problem, problem.residual_jacobian(end, held), free)
        back = RowSpace(J).least_squares(problem.residual(end, held) - start).vector
        end = clamped(robot.integrate(end, -back), lower, upper, problem.bounded)
    size = sqrt(squared_length(problem.residual_jacobian(q, held)))
    outputs = [end, taken, _change(problem, q, end, held), size]
    return function("displaced", [q, target, lower, upper, *limits, change, z, at_limit, length], outputs)


def _stoppable(
    problem: SymbolicProblem,
    q: Expression,
    limits: list[Expression],
    along: Expression,
    change: Expression,
    length: Expression,
) -> Expression:
    """The longest step along the curve after which all joints together can stop before the first position limit."""
    slowest: Expression = math.inf
    for j in range(problem.robot.n):
        slowest = fmin(slowest, _ratio(change[j], fabs(along[j])))
    longest: Expression = math.inf
    for i, j in problem.bounded:
        towards = if_else(length < 0, -along[j], along[j])
        room = if_else(towards < 0, q[i] - limits[0][i], limits[1][i] - q[i])
        distance = fmin(_ratio(fmax(room, 0), fabs(towards)), FAR)
        longest = fmin(longest, braking(distance, IN_TIME * fmin(slowest, FAR)))
    return longest


def _ratio(numerator: Expression, denominator: Expression) -> Expression:
    """The quotient, infinite where the denominator is nothing."""
    some = denominator > TOUCHING
    return if_else(some, numerator / if_else(some, denominator, 1), math.inf)


def error_change(problem: SymbolicProblem) -> Function:
    """(q, q', target) -> norms of the change of the error rows in [m] and in [rad] from q to q', (2,)."""
    q, target, _ = problem.symbols()
    end = symbol("end", problem.robot.nq)
    return function("error_change", [q, end, target], [_change(problem, q, end, _held(problem, q, target))])


def _change(problem: SymbolicProblem, q: Expression, end: Expression, held: Expression) -> Expression:
    change, rows = problem.error(end, held) - problem.error(q, held), range(problem.m)
    parts = [[change[i] for i in rows if problem.linear[i] == linear] for linear in (True, False)]
    return vertcat(*[norm(vertcat(0, *part)) for part in parts])


class _NullSpace:
    """The null space of J over the joints that are free and not locked."""

    def __init__(self, problem: SymbolicProblem, J: Expression, free: list[Expression] | None = None) -> None:
        self._free = vertcat(*[0 if j in problem.locked else 1 for j in range(problem.robot.n)])
        if free is not None:
            self._free = self._free * vertcat(*free)
        self._space = RowSpace(J @ diag(self._free))

    def of(self, v: Expression) -> Expression:
        """The projection of v onto it, (n, 1)."""
        return self._space.split(self._free * v).null


def _held(problem: SymbolicProblem, q: Expression, target: Expression) -> Expression:
    """The target that q meets."""
    return problem.tasks.held_target(problem.robot.at(q), target)


def _unlocked(problem: SymbolicProblem, v: Expression) -> Expression:
    return vertcat(*[0 if j in problem.locked else v[j] for j in range(problem.robot.n)])


def _without(problem: SymbolicProblem, J: Expression, free: list[Expression]) -> Expression:
    return J @ diag(vertcat(*[0 if j in problem.locked else each for j, each in enumerate(free)]))
