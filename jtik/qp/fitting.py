"""A task displacement fitted into a box: the unsaturated joints compensate for the saturated ones (limits.md)."""

from __future__ import annotations

from math import inf

from jtik.qp.call import called
from jtik.qp.conic import Conic
from jtik.qp.few_saturated import few_saturated
from jtik.symbolic import (
    MX,
    Expression,
    Function,
    dot,
    fmax,
    fmin,
    function,
    gram,
    identity,
    if_else,
    is_finite,
    logic_and,
    logic_not,
    logic_or,
    norm,
    ratio,
    sumsqr,
    symbol,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import RowSpace

PENALTY = 1e4
"""Weight of motion along the task in units of the displacement's length: larger than the multipliers of the box."""

OF_ERROR = 1e6
"""Weight of the error that a displacement leaves against its distance from the wanted one, relative to 1 / |J|^2."""

BLOCKED = 0.01
"""Where the direction allows less than this share of the progress of clipping each joint, the joints are clipped."""


def fitted_by(m: int, n: int, *, least_error: bool) -> tuple[Function, Function | None]:
    """The function that fits a displacement by a QP, and the one that mostly finds the same without it, or None.

    Args:
        m: number of rows of J.
        n: number of its columns.
        least_error: whether the error is to be the smallest, rather than the direction of the task to be kept.
    """
    return (least_error_fitting(m, n), None) if least_error else (fitting(m, n), few_saturated(m, n))


def fitting(m: int, n: int) -> Function:
    """(J (m, n), t (n, 1), lower (n, 1), upper (n, 1)) -> x (n, 1), the displacement t fitted into the box.

    J x = s J t with the largest s up to 1, and of these x the closest to t. The box contains 0. Where that direction is
    blocked, and clipping joint by joint is not, x is the clipped t. It solves a QP; `few_saturated` does where it can.
    """
    data, finish = _quadratic_program(m, n), _finish(m, n)
    given = [MX.sym(f"a{i}", *data.size_in(i)) for i in range(data.n_in())]
    z, _, _ = called(Conic().function(n, m), called(data, given))
    return function("fitting", given, called(finish, [*given, z]))


def least_error_fitting(m: int, n: int) -> Function:
    """(J (m, n), t (n, 1), lower (n, 1), upper (n, 1)) -> x (n, 1), the displacement t fitted into the box.

    |J x - J t| is the smallest, and of these x the one closest to t, to the weight `OF_ERROR`.
    """
    J, t, lower, upper = given = _symbols(m, n)
    size = norm(t)
    P = identity(n) + OF_ERROR * ratio(1, sumsqr(J)) * gram(J)
    rows = [zeros(0, n), zeros(0), zeros(0)]
    data = function("data", given, [P, -(P @ t) / size, *rows, lower / size, upper / size])
    z = symbol("z", n)
    x, clipped = (fmin(fmax(dq, lower), upper) for dq in (size * z, t))
    finish = function("finish", [*given, z], [if_else(is_finite(z), x, clipped)])
    inputs = [MX.sym(f"a{i}", *data.size_in(i)) for i in range(data.n_in())]
    z, _, _ = called(Conic().function(n, 0), called(data, inputs))
    return function("fitting", inputs, called(finish, [*inputs, z]))


def _symbols(m: int, n: int) -> list[Expression]:
    return [symbol("J", m, n), symbol("t", n), symbol("lower", n), symbol("upper", n)]


def _quadratic_program(m: int, n: int) -> Function:
    """The QP of z = x / |t|: rows across the direction of the task are kept at 0, the motion along it is maximised."""
    J, t, lower, upper = given = _symbols(m, n)
    space, size = RowSpace(J), norm(t)
    rows, wanted = space.unit_basis, space.unit_basis @ (t / size)
    # a reflection that turns the wanted motion along the first independent row; it leaves dependent rows zero
    first, before = list[Expression](), zeros(1)
    for independent in space.independent:
        first.append(logic_and(independent, logic_not(before)))
        before = logic_or(before, independent)
    chosen, length = vertcat(*first), norm(wanted)
    sign = if_else(dot(chosen, wanted) >= 0, 1, -1)
    mirror = wanted + sign * length * chosen
    turned = rows - (2 / sumsqr(mirror) * mirror) @ (mirror.T @ rows)
    matrix = turned - (1 + sign) * chosen @ (chosen.T @ turned)
    low, high = (space.dependent_bounds(side) for side in (-1, 1))
    bounds = [if_else(chosen, -inf, low), if_else(chosen, length, high), lower / size, upper / size]
    along = chosen.T @ matrix
    return function("data", given, [identity(n) + zeros(n, n), -t / size - PENALTY * along.T, matrix, *bounds])


def _finish(m: int, n: int) -> Function:
    """The displacement of the QP's solution z, inside the box in spite of rounding; or the clipped one."""
    J, t, lower, upper = given = _symbols(m, n)
    z = symbol("z", n)
    x, clipped = (fmin(fmax(dq, lower), upper) for dq in (norm(t) * z, t))
    wanted = J @ t

    def progress(dq: Expression) -> Expression:
        return sumsqr(wanted) - sumsqr(wanted - J @ dq)

    free = logic_and(is_finite(z), progress(x) >= BLOCKED * progress(clipped))
    return function("finish", [*given, z], [if_else(free, x, clipped)])
