"""The proof that distances stay safe along the path of a step (formulations/clearance.md, (C6)), as one function.

A distance that is larger than the step is long is safe without more: it is not evaluated on the path. The others are,
body by body.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from math import inf

from jtik._step.active_set import clamped
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.constraints.clearance import SAMPLES, lacking
from jtik.constraints.motion_bound import MotionBound
from jtik.symbolic import (
    MX,
    Expression,
    Function,
    either,
    fmin,
    function,
    horzcat,
    if_else,
    mmin,
    sum1,
    symbol,
    vertcat,
)

REACH = 1 + 1 / (2 * SAMPLES)
"""How much a distance may change on the path, and between two samples beyond them, relative to the bound L."""

LARGEST_UNROLLED = 30
"""Distances of a group up to which their check is written out, operation by operation."""

ROUNDING = 1e-12
"""Decrease of a distance at a sample that counts as none [m]."""

FIGURES = 5
"""Figures of each distance: itself, safe, aim, radius of curvature, and whether it is restored."""


def safe_path(problem: SymbolicProblem) -> Function:
    """(q, dq, parameters, lower, upper, figures) -> whether every distance stays safe, and the violation at the end.

    The figures are a row of `FIGURES` for each distance; dq is in the joints' own units.

    Args:
        problem: the problem.
    """
    found: Function = problem.once("safe_path", lambda: _safe_path(problem))
    return found


def _safe_path(problem: SymbolicProblem) -> Function:
    robot, sizes = problem.robot, problem.measured.sizes
    q, _, parameters = problem.symbols()
    dq, limits = symbol("dq", robot.n), [symbol("lower", robot.nq), symbol("upper", robot.nq)]
    starts = [sum(sizes[:g]) for g in range(len(sizes))]
    bound = function("path_lengths", [q, dq], [vertcat(*MotionBound(robot, q).lengths(dq))])
    begin = _begin(bound, sizes, loops=problem.measured.rows is not None)
    samples = [
        clamped(robot.integrate(q, k / SAMPLES * dq), limits[0], limits[1], problem.bounded)
        for k in range(1, SAMPLES + 1)
    ]
    configurations = function("path_samples", [q, dq, *limits], samples)

    given = [q, dq, parameters, *limits]
    inputs = [*(MX.sym(f"i{i}", *each.shape) for i, each in enumerate(given)), MX.sym("figures", sum(sizes), FIGURES)]
    lengths, flags, any_near = begin(inputs[0], inputs[1], inputs[5])
    inside = [*[MX.sym(f"a{i}", *each.shape) for i, each in enumerate([*inputs, lengths, flags])]]
    at, turn, live, low, high, rows, bounds, near = inside
    places = configurations(at, turn, low, high)
    good, total, g = MX(1), MX(0), 0
    for shared, own in problem.measured.bodies:
        common = [*places, *[shared(place, live) for place in places], live, bounds]
        for body in own:
            size = sizes[g]
            given = [*common, rows[starts[g] : starts[g] + size, :]]
            good_here, violation = _either(_judged(body, given, size), given)(near[g], *given)
            good, total, g = good * good_here, total + violation, g + 1
    evaluated = function("near", inside, [good, total], cse=False)
    result = _either(evaluated, inside)(any_near, *inputs, lengths, flags)
    return function("safe_path", inputs, list(result), cse=False, inline=False)


def _begin(bound: Function, sizes: Sequence[int], *, loops: bool) -> Function:
    """(q, dq, figures) -> bounds of the lengths, which groups of distances are near, and whether any is."""
    made = MX.sym if loops else symbol
    q, dq, figures = made("q", bound.size1_in(0)), made("dq", bound.size1_in(1)), made("figures", sum(sizes), FIGURES)
    lengths = bound(q, dq)
    far = figures[:, 0] - REACH * lengths[0] >= figures[:, 2]
    flags, start = [], 0
    for size in sizes:
        flags.append(1 - mmin(far[start : start + size]))
        start += size
    return function(
        "path_begin", [q, dq, figures], [lengths, vertcat(*flags), 1 - mmin(vertcat(*[1 - f for f in flags]))]
    )


def _either(evaluated: Function, arguments: list[Expression]) -> Function:
    """``evaluated`` where the first argument is not 0, else 1 and 0."""
    symbols = [MX.sym(f"a{i}", *each.shape) for i, each in enumerate(arguments)]
    return either(evaluated, function("far", symbols, [MX(1), MX(0)]))


def _judged(own: Function, given: list[Expression], size: int) -> Function:
    """(samples, shared values of each, parameters, lengths, figures) -> whether safe, violation; of one body."""
    symbols = [MX.sym(f"a{i}", *each.shape) for i, each in enumerate(given)]
    places, shared, (live, lengths, figures) = symbols[:SAMPLES], symbols[SAMPLES:-3], symbols[-3:]
    after = [own(place, live, values) for place, values in zip(places, shared, strict=True)]
    return function(
        "body", symbols, list(_judge(size, loops=size > LARGEST_UNROLLED)(figures, lengths, *after)), cse=False
    )


@cache
def _judge(size: int, *, loops: bool) -> Function:
    """(figures, lengths, distances at each sample) -> whether they are safe on the path, violation at its end.

    The distances are evaluated at K samples. A point of a body moves at most L in the step and its link rotates by
    at most S. Between two samples a distance is safe where both exceed the safe value by the smaller of
    (L^2 / rho + L S) / (8 K^2) and L / (2 K). A distance that starts below it is no smaller at any sample.
    """
    made = MX.sym if loops else symbol
    figures, lengths = made("figures", size, FIGURES), made("lengths", 2)
    samples = [made(f"after{k}", size) for k in range(SAMPLES)]
    distance, safe, aim, radius, restored = (figures[:, i] for i in range(FIGURES))
    travelled, turned = lengths[0], lengths[1]
    curved = (travelled**2 / radius + travelled * turned) / (8 * SAMPLES**2)
    dip = fmin(curved, travelled / (2 * SAMPLES))
    # of a distance that starts too small only the samples count: it becomes no smaller
    too_small = distance < safe
    left_out, dip = if_else(too_small, inf, 0), if_else(too_small, 0, dip)
    smallest = if_else(too_small, distance - ROUNDING, safe)
    good: Expression = type(figures)(1)
    before = distance
    for after in samples:
        good = good * (mmin(fmin(before + left_out, after) - dip - smallest) >= 0)
        before = after
    violation = sum1(lacking(samples[-1], safe, aim, restored))
    return function("safe", [figures, lengths, *samples], [good, violation])


def figures_of(columns: list[Expression]) -> Expression:
    """The figures of each distance, of columns (k, 1), as `safe_path` takes them."""
    return horzcat(*columns)
