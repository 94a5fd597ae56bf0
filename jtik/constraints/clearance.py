"""Clearances as hard constraints: rows of a step's program, and a proof for the whole way that an accepted step goes.

What measures the distances is a criterion that has them, such as ObstacleAvoidance; its parameters stay live.
(formulations/clearance.md)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik.errors import ArgumentError, finite_array
from jtik.robot import JointType, Kinematics, Robot
from jtik.symbolic import Expression, fabs, fmax, fmin, if_else, mmin, sum1, vertcat
from jtik.types import Array

SAMPLES = 4
"""Places along a step, its end among them, where the distances are measured; between them they are bounded."""

CONTENT = 0.5
"""Share of the margin up to which a distance may fall short of its aim before it is moved out: along an obstacle every
step ends a hair short, and that is not worth a program."""


@runtime_checkable
class Measure(Protocol):
    """What can tell distances [m]: a criterion's parameters, and signed distances of each body to each obstacle."""

    name: str

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Names and first values of its live parameters."""

    def distances(self, kinematics: Kinematics, parameters: Mapping[str, Expression]) -> list[list[Expression]]:
        """One list a body, one entry an obstacle."""


class Clearance:
    """Keeps every distance of a measure at ``safe`` or more, at the end of each step and on the way there.

    A row limits each step's approach, grad d' dq >= -gain (d - safe - margin), for distances below ``influence``: the
    velocity damper of Faverjon and Tournassoud; with ``influence=math.inf`` its control-barrier form. Where the task
    asks for more than the rows allow, the task gives way. A body that is nearer than ``safe`` and half the margin is
    moved out, grad d' dq = gain (safe + margin - d), before anything else, as far as limits and the other clearances
    allow, and comes no nearer in any case. What cannot be had is in ``Solution.relaxed``.

    Live parameters: ``clearance.safe``, ``.influence``, and those of the measure, such as ``clearance.centers``.

    Args:
        measure: a criterion with ``distances``, such as ``ObstacleAvoidance(obstacles, bodies="links")``. It is not
            minimised here; as one of ``criteria`` it can be, too.
        safe: the least distance [m].
        influence: from which distance on a body goes unhindered [m].
        gain: share of the way to ``safe + margin`` that a step may use, in (0, 1].
        margin: how far above ``safe`` the rows aim [m]; the room that keeps steps near an obstacle from being tiny.
        recover: whether a body that is too near is moved out. If not, it only comes no nearer.
        name: how its parameters are addressed.

    Source: Faverjon and Tournassoud (1987); Ames et al. (2017) for the barrier form.
    """

    def __init__(
        self,
        measure: Measure,
        *,
        safe: float = 0.01,
        influence: float = 0.3,
        gain: float = 0.5,
        margin: float = 0.01,
        recover: bool = True,
        name: str = "clearance",
    ) -> None:
        if not isinstance(measure, Measure):
            raise ArgumentError("measure", measure, "a criterion with distances(), such as ObstacleAvoidance")
        if not isinstance(recover, (bool, np.bool_)):
            raise ArgumentError("recover", recover, "True or False: whether what is too near is moved out")
        self.measure, self.name, self.recover = measure, name, bool(recover)
        self.safe, self.margin = float(finite_array("safe", safe, ())), float(finite_array("margin", margin, ()))
        self.influence, self.gain = float(influence), float(finite_array("gain", gain, ()))
        if self.safe < 0:
            raise ArgumentError("safe", safe, "a distance [m] from 0")
        if not self.margin > 0:
            raise ArgumentError("margin", margin, "a positive distance [m]")
        if not self.influence > self.safe + self.margin:
            raise ArgumentError("influence", influence, f"a distance above safe + margin = {safe + margin:g} m")
        if not 0 < self.gain <= 1:
            raise ArgumentError("gain", gain, "a number in (0, 1]")

    def __repr__(self) -> str:
        return f"Clearance({self.measure!r}, safe={self.safe:g})"

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Its own, and those of the measure."""
        own = {"safe": self.safe, "influence": min(self.influence, 1e300)}
        return {**own, **dict(self.measure.parameters(robot))}


def clearances_of(given: Clearance | Iterable[Clearance] | None) -> tuple[Clearance, ...]:
    """The clearances, each with a name of its own. Raises ArgumentError for anything else."""
    found = (given,) if isinstance(given, Clearance) else tuple(given or ())
    for clearance in found:
        if not isinstance(clearance, Clearance):
            raise ArgumentError("clearances", clearance, "a jtik.Clearance, or several")
    names = [clearance.name for clearance in found]
    if len(set(names)) != len(names):
        raise ArgumentError("clearances", names, "a name each: Clearance(..., name=...)")
    return found


def names_of(measure: Measure, robot: Robot, count: int) -> list[str]:
    """What a measure's bodies are called: by its own ``body_names(robot)`` where it has that, else by number."""
    named = getattr(measure, "body_names", None)
    names = list(named(robot)) if callable(named) else []
    return names if len(names) == count else [f"body {i}" for i in range(count)]


@dataclass(frozen=True)
class ClearanceModel:
    """Clearances at one configuration, for a law and for the judgement of its step.

    Attributes: distance (k, 1) [m]; its Jacobian (k, n); safe, aim = safe + margin, influence and gain of each (k, 1);
    the least radius of curvature of a surface of constant distance [m]; how far a unit of each velocity entry can move
    any point of the robot (n,) [m]; q -> distances, for other configurations; recover, which of them ask to be moved
    out (k,); longest, how far each velocity entry may go for that in this step [rad] or [m]; record, the least
    violation so far [m].
    """

    distance: Expression
    jacobian: Expression
    safe: Expression
    aim: Expression
    influence: Expression
    gain: Expression
    curvature_radius: Expression
    travel: Array
    rotational: NDArray[np.bool_]
    elsewhere: Any
    recover: NDArray[np.bool_]
    longest: Expression = 0
    record: Expression = 0

    @property
    def lever(self) -> float:
        """Bound of the length of a row of the Jacobian [m]."""
        return float(np.linalg.norm(self.travel)) or 1.0

    @property
    def recovers(self) -> bool:
        """Whether any of them asks to be moved out."""
        return bool(self.recover.any())

    @cached_property
    def low(self) -> Expression:
        """What a step should gain of each distance at least, (k, 1) [m]: negative beyond the aim, else the demand."""
        room = fmax(self.distance - self.aim, 0)
        low = if_else(self.distance > self.influence, -inf, -self.gain * room)
        return low + self.demand if self.recovers else low

    @cached_property
    def demand(self) -> Expression:
        """What should be gained of the distances that are too small, (k, 1) [m], from 0."""
        return self.gain * self.lacking

    @cached_property
    def lacking(self) -> Expression:
        """What distances that ask to be moved out lack of their aims, (k, 1) [m], from 0."""
        return self._lacking(self.distance)

    def violation(self, distance: Expression) -> Expression:
        """The sum of what distances that ask to be moved out lack of their aims [m]."""
        return sum1(self._lacking(distance))

    def _lacking(self, distance: Expression) -> Expression:
        lacks = self.aim - distance
        asked = vertcat(*self.recover.astype(float).tolist()) * (lacks > CONTENT * (self.aim - self.safe))
        return if_else(asked, lacks, 0)

    def keeps(self, term: Expression) -> Expression:
        """1 if the step -term keeps clear all the way: at the samples, and between them by a bound on how far d dips.

        A body's point travels at most L in the whole step and turns by at most S; between samples a distance lies at
        most (L^2 / rho + L S) / (8 K^2) below the chord of a convex stretch, and L / (2 K) below the lower end.
        """
        size = [fabs(term[j]) for j in range(len(self.travel))]
        travelled = sum(reach * length for reach, length in zip(self.travel, size, strict=True))
        # a turn moves the axis of a slide beyond it: each such pair of entries counts twice
        twice = 1 if self.rotational.all() else 2
        turned = twice * sum((length for length, turns in zip(size, self.rotational, strict=True) if turns), 0)
        curved = (travelled**2 / self.curvature_radius + travelled * turned) / (8 * SAMPLES**2)
        dip = fmin(curved, travelled / (2 * SAMPLES))
        least = fmin(self.safe, self.distance)  # what starts too near comes no nearer
        good: Expression = 1
        before = self.distance
        for k in range(1, SAMPLES + 1):
            after = self.elsewhere(k / SAMPLES * term)
            low = fmin(before, after) - dip
            near = if_else(self.distance < self.safe, after - self.distance + 1e-12, low - least)
            good = good * (mmin(near) >= 0)
            before = after
        return good


def travels(robot: Robot) -> Array:
    """How far a unit of each velocity entry can move any point of the robot, at any configuration, (n,) [m]."""
    beyond = {frame: _own_reach(robot, frame) for frame in robot.frame_names}
    for joint in reversed(robot.joints):
        length = float(np.linalg.norm(joint.origin[:3, 3])) + _stroke(joint)
        beyond[joint.parent] = max(beyond[joint.parent], length + beyond[joint.child])
    result = np.zeros(robot.n)
    for joint in robot.joints:
        if not joint.is_moving:
            continue
        gain = 1.0 if joint.mimic is None else abs(joint.mimic.multiplier)
        place = robot.v_slice(joint.name)
        turning = np.array(joint.type.rotational)
        result[place] += gain * np.where(turning, beyond[joint.child] + _stroke(joint), 1.0)
    return result


def _own_reach(robot: Robot, frame: str) -> float:
    """The farthest point of a frame's solids from its origin [m]."""
    from jtik.geometry import enclosing_segment

    farthest = 0.0
    for a, b, radius in (enclosing_segment(solid) for solid in robot.shapes.get(frame, ())):
        farthest = max(farthest, float(np.linalg.norm(a)) + radius, float(np.linalg.norm(b)) + radius)
    return farthest


def _stroke(joint: Any) -> float:
    """How far a slide can carry its child [m]."""
    if joint.type is not JointType.PRISMATIC:
        return 0.0
    ends = max(abs(joint.lower), abs(joint.upper))
    return float(ends) if np.isfinite(ends) else 0.0
