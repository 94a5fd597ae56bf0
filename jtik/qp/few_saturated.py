"""A task displacement fitted into a box without a solver, where few joints saturate (formulations/motion.md, Q2)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from jtik.symbolic import (
    Expression,
    Function,
    dot,
    fabs,
    fmax,
    fmin,
    function,
    if_else,
    logic_and,
    logic_not,
    logic_or,
    mmax,
    norm_inf,
    ratio,
    symbol,
    vertcat,
    zeros,
)
from jtik.symbolic.factorization import RowSpace
from jtik.symbolic.reflections import Reflections

PASSES = 2
"""Largest number of joints that saturate before the null space is used up."""

INDEPENDENT = 1e-6
"""Squared length below which the null-space part of a unit vector counts as rounding."""

SHORTEST = 0.01
"""Share of the task displacement below which the QP decides whether its direction is blocked."""

ROUNDING = 1e-11
"""Distance outside the box that counts as rounding, relative to the largest entry of the displacement."""


def few_saturated(m: int, n: int) -> Function:
    """(J (m, n), t (n, 1), lower (n, 1), upper (n, 1)) -> x (n, 1), whether it is the fitted displacement.

    The joint that is farthest outside the box is moved to its bound by a motion in the null space, then the next one,
    up to `PASSES` times. If these joints use up the null space, the displacement is shortened until it is in the box.
    x is the fitted displacement if it is in the box and every multiplier has the right sign.
    """
    J, t, lower, upper = given = [symbol("J", m, n), symbol("t", n), symbol("lower", n), symbol("upper", n)]
    freedom = n - m
    space: Reflections | RowSpace
    found: Expression = 1
    if freedom in (0, 1):
        space = Reflections(J)
        full_rank = found = space.full_rank  # where the rank is smaller, the null space has more directions
    else:
        space = RowSpace(J)
        full_rank = space.rank == m

    def outside(x: Expression) -> list[Expression]:
        """How far each joint has to go back into the box."""
        return [fmin(fmax(x[j], lower[j]), upper[j]) - x[j] for j in range(n)]

    x = along = t  # along: a displacement without the saturated joints, J along = J t
    saturated: list[_Saturated] = []
    for _ in range(min(freedom, PASSES)):
        way = vertcat(*outside(x))
        joint = _first_largest([fabs(way[j]) for j in range(n)])
        each = _Saturated.of(space, joint, dot(joint, way), saturated)
        x, along = x + each.gain * each.motion, along - ratio(dot(joint, along), each.squared) * each.motion
        saturated.append(each)
    gains = _of_unit_vectors(saturated, [each.gain for each in saturated])
    for each, gain in zip(saturated, gains, strict=True):
        found = logic_and(found, logic_or(each.way == 0, logic_and(each.independent, gain * each.way >= 0)))
    if freedom <= PASSES:
        back = outside(x)
        # the saturated joints are at their bounds to rounding, which may not be divided by rounding
        at_bound = sum((each.joint for each in saturated), zeros(n)) - 1
        lost = [at_bound[j] * fmin(ratio(back[j] * along[j], along[j] ** 2), 0) for j in range(n)]
        joint, most = _first_largest(lost), mmax(vertcat(*lost))
        x = x - most * along
        way = dot(joint, vertcat(*back))
        shares = _of_unit_vectors(saturated, [ratio(dot(each.motion, joint), each.squared) for each in saturated])
        shortened = logic_and(full_rank, most <= 1 - SHORTEST)
        for each, share in zip(saturated, shares, strict=True):
            shortened = logic_and(shortened, logic_and(each.independent, share * way * each.way < 0))
        found = if_else(most > 0, shortened, found)
    left: Expression = 0
    for entry in outside(x):
        left = left + fabs(entry)
    found = logic_and(found, left <= ROUNDING * norm_inf(t))
    return function("few_saturated", given, [fmin(fmax(x, lower), upper), found])


@dataclass(frozen=True)
class _Saturated:
    """A joint that is moved to its bound while those before it stay at theirs.

    Attributes:
        joint: its unit vector (n, 1); zeros for no joint.
        way: how far it has to move; 0 for no joint.
        motion: the motion of this joint in the null space without the joints before it (n, 1).
        squared: its squared length, which is its entry of the joint.
        before: the shares of the earlier motions that its unit vector has.
    """

    joint: Expression
    way: Expression
    motion: Expression
    squared: Expression
    before: Sequence[Expression]

    @classmethod
    def of(
        cls, space: Reflections | RowSpace, joint: Expression, way: Expression, saturated: Sequence[_Saturated]
    ) -> _Saturated:
        """That of the joint with the unit vector ``joint`` (n, 1)."""
        motion, before = space.null_part(joint), []
        for each in saturated:
            before.append(ratio(dot(each.motion, joint), each.squared))
            motion = motion - before[-1] * each.motion
        return cls(joint, way, motion, dot(joint, motion), before)

    @property
    def independent(self) -> Expression:
        """1 if it can move in that null space."""
        return self.squared > INDEPENDENT

    @property
    def gain(self) -> Expression:
        """Factor of the motion that moves the joint to its bound."""
        return ratio(self.way, self.squared)


def _of_unit_vectors(saturated: Sequence[_Saturated], shares: Sequence[Expression]) -> list[Expression]:
    """The coefficients of the joints' unit vectors for coefficients of their motions."""
    found = list(shares)
    for i in reversed(range(len(found))):
        for k, before in enumerate(saturated[i].before):
            found[k] = found[k] - before * found[i]
    return found


def _first_largest(values: Sequence[Expression]) -> Expression:
    """1 at the first of the largest values, which are not negative, else 0, (n, 1); zeros if none is positive."""
    largest, entries = mmax(vertcat(*values)), list[Expression]()
    wanted = largest > 0
    for value in values:
        entries.append(logic_and(wanted, value >= largest))
        wanted = logic_and(wanted, logic_not(entries[-1]))
    return vertcat(*entries)
