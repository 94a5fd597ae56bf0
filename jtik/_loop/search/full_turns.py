"""Full turns: joints that can turn all the way round move without limits, and the answer is brought back by turns.

A revolute joint whose limits leave a full turn reaches every angle, but within its limits a search that starts on one
side of the wrap-around cannot reach the other side directly. So a search moves such a joint as if it had no limits,
and replaces its final position by the one a whole number of turns away that lies within the limits and is nearest to
where the search began (formulations/full_turns.md).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from jtik._step.symbolic_problem import SymbolicProblem
from jtik.robot import JointType, Robot
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

TURN = 2 * math.pi
"""A full turn [rad]."""

SHORT_OF_A_TURN = 0.02
"""A range that is smaller than a full turn by at most this still counts as one [rad]: files round pi to 3.14."""

ROUNDING = 1e-12
"""A position this far outside a limit is moved to the limit [rad]."""

FARTHEST = 1e6
"""No joint is turned further from zero than this: its angle would be rounded by more than 1e-10 [rad]."""

PERIODIC = 1e-9
"""Largest relative change of the task error by a full turn of a joint that only turns its links."""


class FullTurns:
    """The joints of a problem that can turn all the way round.

    Args:
        problem: the problem. A joint is left out where the task error changes by a full turn of it, or where a mimic
            joint follows it by another motion than whole turns.
        lower: lower limits, (nq,).
        upper: upper limits, (nq,).

    Attributes:
        indices: the entries of these joints in q, (k,).
        lower: their lower limits, (k,) [rad].
        upper: their upper limits, (k,) [rad].
        free: lower and upper limits (nq,) of a search: infinite for these joints.
    """

    def __init__(self, problem: SymbolicProblem, lower: Array, upper: Array) -> None:
        robot = problem.robot
        candidates = [
            i
            for joint in robot.independent_joints
            if joint.type is JointType.REVOLUTE and _followers_turn(robot, joint.name)
            for i in [robot.q_slice(joint.name).start]
            if upper[i] - lower[i] >= TURN - SHORT_OF_A_TURN
        ]
        periodic = problem.once("periodic", lambda: _periodic(problem, candidates))
        self.indices: NDArray[np.int64] = np.array(periodic, dtype=np.int64)
        self.lower, self.upper = lower[self.indices], upper[self.indices]
        self.free = lower.copy(), upper.copy()
        self.free[0][self.indices], self.free[1][self.indices] = -math.inf, math.inf

    def nearest(self, q: Array, reference: Array) -> tuple[Array, bool]:
        """``q`` with each joint at the turn within its limits that is nearest to ``reference``.

        Returns:
            That configuration, (nq,), clamped to the limits of joints for which no turn fits; and whether all fit.
        """
        own, lower, upper = q[self.indices], self.lower, self.upper
        turns = np.rint((reference[self.indices] - own) / TURN)
        turns[np.abs(own + turns * TURN) > FARTHEST] = 0
        least = np.ceil((lower - own - ROUNDING) / TURN)
        most = np.floor((upper - own + ROUNDING) / TURN)
        turns = np.minimum(np.maximum(turns, least), most)
        turned = q.copy()
        turned[self.indices] = np.minimum(np.maximum(own + turns * TURN, lower), upper)
        return turned, not bool((least > most).any())


def _followers_turn(robot: Robot, leader: str) -> bool:
    """Whether every mimic joint of a leader makes whole turns when the leader makes one."""
    followers = [joint for joint in robot.joints if joint.mimic is not None and joint.mimic.joint == leader]
    return all(
        joint.type is JointType.REVOLUTE and joint.mimic is not None and float(joint.mimic.multiplier).is_integer()
        for joint in followers
    )


def _periodic(problem: SymbolicProblem, candidates: list[int]) -> list[int]:
    """The candidates by a full turn of which the task error does not change."""
    error = CompiledFunction(problem.error) if candidates else None
    return [i for i in candidates if error and _is_periodic(problem, error, i)]


def _is_periodic(problem: SymbolicProblem, error: CompiledFunction, i: int) -> bool:
    """Whether a full turn of entry i of q leaves the task error as it is, at a few configurations."""
    generator = np.random.default_rng(0)
    for _ in range(3):
        q = problem.robot.random_configuration(generator)
        target = generator.uniform(-1.0, 1.0, problem.tasks.target_size)
        before = error(q, target)[0]
        q[i] += TURN
        if not np.abs(error(q, target)[0] - before).max(initial=0.0) <= PERIODIC * (1 + np.abs(before).max(initial=0)):
            return False
    return True
