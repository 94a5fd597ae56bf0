"""The certificate of a strict minimum: a sufficient condition of second order, cheap enough for the end of a solve.

Where a configuration is on target and H is stationary, H can still have a saddle point or a maximum there on the
self-motion. The certificate is 1 only where second derivatives exclude that; where it is 0, `Report.second_order` has
to decide. See formulations/criterion_escape.md.
"""

from __future__ import annotations

from jtik._step.inputs import Inputs, Settings
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.limits import AT_LIMIT
from jtik.result.second_order import FLAT
from jtik.strategy.curvature import lagrangian_hessian
from jtik.symbolic import (
    LDL,
    Expression,
    Function,
    densify,
    diag,
    fmax,
    function,
    gram,
    identity,
    logic_and,
    logic_not,
    logic_or,
    norm,
    ratio,
    symbol,
    vec,
    vertcat,
)
from jtik.symbolic.factorization import damped_multipliers, squared_length
from jtik.symbolic.generated_c import SELDOM

PENALTY = 1e8
"""Weight of J'J, relative to |J|^2, beside the Hessian, relative to its norm: rounding of it is below `FLAT`."""


UNROLLED = 12
"""Most velocity entries for which the function itself factorises M, by a cubic number of operations."""

OPTIMISED = 10_000
"""Most instructions of a certificate that is optimised as generated C: compilers take longer than linearly for more."""


def strict_minimum(problem: SymbolicProblem) -> Function:
    """(q, inputs) -> 1 where H certainly has a strict minimum on the self-motion at a stationary q, else 0.

    Beyond `UNROLLED` velocity entries it has a second output, a matrix: the minimum is certain where this is positive
    definite as well.
    """
    nq, n = problem.robot.nq, problem.robot.n
    q, target, parameters = problem.symbols()
    inputs = Inputs(target, parameters, symbol("lower", nq), symbol("upper", nq), symbol("settings", len(Settings())))
    J, gradient = problem.residual_jacobian(q, target), problem.gradient(problem.criterion(q, parameters), q)
    free, at_lower, at_upper = _limits(problem, q, inputs)
    J_free = J @ diag(free)
    multipliers = -damped_multipliers(J_free, 0, J_free @ gradient)
    reduced = gradient + J.T @ multipliers
    small = Settings.of(inputs.settings).optimality_tolerance * fmax(1, norm(gradient))
    holds = norm(free * reduced) <= small
    for j in range(n):  # a joint at a limit counts as fixed only where its multiplier is certainly not zero
        pushed = logic_or(logic_and(at_upper[j], reduced[j] < -small), logic_and(at_lower[j], reduced[j] > small))
        fixed = logic_and(at_lower[j], at_upper[j])
        holds = logic_and(holds, logic_or(free[j], logic_or(pushed, fixed)))
    W = lagrangian_hessian(
        problem.robot,
        problem.criterion,
        problem.residual,
        q=q,
        target=target,
        parameters=parameters,
        multipliers=multipliers,
    )
    inside = diag(free)
    M = inside @ (ratio(1, norm(vec(W))) * W) @ inside + ratio(PENALTY, squared_length(J_free)) * gram(J_free)
    M = M + identity(n) - inside - FLAT * identity(n)
    outputs = [logic_and(holds, LDL.of(M).positive_definite)] if n <= UNROLLED else [holds, densify(M)]
    made = function("strict_minimum", [q, *inputs], outputs, cse=False)  # it takes longest
    if made.n_instructions() <= OPTIMISED:
        return made
    return function(f"{SELDOM}strict_minimum", [q, *inputs], outputs, cse=False)


def _limits(problem: SymbolicProblem, q: Expression, inputs: Inputs[Expression]) -> tuple[Expression, ...]:
    """For each velocity entry: 1 if it is not at a limit, at its lower limit, at its upper limit, (n, 1) each."""
    n = problem.robot.n
    at_lower: list[Expression] = [0] * n
    at_upper: list[Expression] = [0] * n
    for i, j in problem.bounded:
        at_lower[j] = q[i] <= inputs.lower[i] + AT_LIMIT
        at_upper[j] = q[i] >= inputs.upper[i] - AT_LIMIT
    free = [logic_not(logic_or(low, high)) for low, high in zip(at_lower, at_upper, strict=True)]
    return vertcat(*free), vertcat(*at_lower), vertcat(*at_upper)
