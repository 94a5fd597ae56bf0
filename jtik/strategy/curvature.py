"""Second derivatives of the criterion on the task's solutions: the Hessian of the Lagrangian."""

from __future__ import annotations

from jtik.criterion.least_squares import LeastSquares
from jtik.robot import Robot
from jtik.symbolic import Expression, Function, dot, hessian, substitute, symbol, zeros


def lagrangian_hessian(
    robot: Robot,
    criterion: Function,
    residual: Function,
    *,
    q: Expression,
    target: Expression,
    parameters: Expression,
    multipliers: Expression | None,
    least_squares: LeastSquares | None = None,
) -> Expression:
    """d2/dv2 of H(q + v) + lambda' r(q + v) at v = 0, ``+`` being ``robot.integrate``, (n, n); unit: that of H.

    Args:
        robot: the robot.
        criterion: (q, parameters) -> H.
        residual: (q, target) -> r, (m, 1).
        q: configuration (nq, 1).
        target: target of the tasks.
        parameters: live parameters of the criterion.
        multipliers: lambda (m, 1), constant in the derivative; None for the Hessian of H alone.
        least_squares: the criteria in residual form, to use their Gauss-Newton Hessian; None for the exact one.
    """
    at, v = symbol("at", robot.nq), symbol("v", robot.n)
    moved_q = robot.integrate(at, v)
    H = criterion if least_squares is None else least_squares.others
    L, old, new = H(moved_q, parameters), [v, at], [zeros(robot.n), q]
    if multipliers is not None:
        constants = symbol("lambda", *multipliers.shape)
        L = L + dot(constants, residual(moved_q, target))
        old, new = [*old, constants], [*new, multipliers]
    second = hessian(L, v)
    if least_squares is not None:
        second = second + least_squares.hessian(moved_q, v, parameters)
    for before, after in zip(old, new, strict=True):
        second = substitute(second, before, after)
    return second
