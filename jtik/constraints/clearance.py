"""Clearances: distances that must stay above a safe value along the path of a step (formulations/clearance.md).

The distances come from a criterion that measures them, such as ObstacleAvoidance; its parameters stay live.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import inf
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from jtik import arguments
from jtik.constraints.measure import Measure
from jtik.constraints.motion_bound import MotionBound
from jtik.constructors import Constructed
from jtik.errors import ArgumentError
from jtik.robot import Robot
from jtik.symbolic import Expression, fmax, fmin, if_else, once_for_each, reshape, sum1, vertcat
from jtik.types import Array

SAMPLES = 4
"""Points along a step, its end included, where distances are evaluated; between them they are bounded."""

TOLERATED = 0.5
"""Share of the margin by which a distance may fall short of its aim before it is restored.

A body that moves along an obstacle ends every step slightly short of the aim, which needs no restoration.
"""

LONGEST = 0.3
"""Largest motion of each velocity entry in a restoration step [rad] or [m]; refused steps reduce it."""


OWN = ("safe", "influence", "gain")
"""Names of a clearance's own figures: a parameter of the measure of such a name is not one of the clearance."""


class Clearance(metaclass=Constructed):
    """Keeps every distance of a measure at ``safe`` or more along the path of each step.

    A row limits the approach of each step, grad d' dq >= -gain (d - safe - margin), for distances below ``influence``:
    the velocity damper of Faverjon and Tournassoud, with ``influence=math.inf`` its control-barrier form. Where the
    task requires more than the rows allow, the arm moves along the obstacle and the task is relaxed. A distance below
    ``safe`` plus half the margin is restored first, grad d' dq = gain (safe + margin - d), as far as limits and the
    other clearances allow; it never becomes smaller. ``Solution.relaxed`` lists what cannot be met, and
    ``Solution.active_clearances`` which distances are as small as they may become.

    Braking is not anticipated: in `track` and ``step(dt=)`` with acceleration limits, a body that moves towards an
    obstacle can come closer than ``safe`` (formulations/limits.md).

    Live parameters: ``clearance.safe``, ``.influence``, and those of the measure, such as ``clearance.centers``, but
    for the gain and the influence of its H.

    Args:
        measure: a criterion with ``distances``, such as ``ObstacleAvoidance(obstacles, bodies="links")``. It is not
            minimised here; as one of ``criteria`` it can be, too. The bounds between the ends of a step hold for
            points of the robot's frames, links and solids.
        safe: the smallest distance allowed [m].
        influence: distance from which on a body is not constrained [m].
        gain: share of the distance to ``safe + margin`` that a step may use, in (0, 1].
        margin: how far above ``safe`` the rows aim [m]; it keeps steps near an obstacle from becoming tiny.
        restore: whether a distance that is too small is restored. If not, it only becomes no smaller.
        name: name under which its parameters are addressed.
        recover: former name of ``restore``; deprecated.

    Raises:
        ArgumentError: for a value outside its range.

    Source: Faverjon and Tournassoud (1987); Ames et al. (2017) for the barrier form.

    Example:
        >>> ball = jtik.Circle((1.5, 1.2), 0.3)
        >>> apart = jtik.Clearance(ObstacleAvoidance([ball], bodies="links"), safe=0.05)
        >>> arm, task = jtik.Robot.planar(3), jtik.FrameTask("tip")
        >>> ik = jtik.InverseKinematics(arm, task, strategy="hybrid+qp", clearances=apart)
    """

    def __init__(
        self,
        measure: Measure,
        *,
        safe: float = 0.01,
        influence: float = 0.3,
        gain: float = 0.5,
        margin: float = 0.01,
        restore: bool = True,
        name: str = "clearance",
        recover: bool | None = None,
    ) -> None:
        if recover is not None:
            warnings.warn("Clearance(recover=) is now called restore=", DeprecationWarning, stacklevel=2)
            restore = recover
        if isinstance(measure, type) or not isinstance(measure, Measure):
            raise ArgumentError("measure", measure, "a criterion with distances(), such as ObstacleAvoidance")
        self.measure, self.name = measure, arguments.name("name", name)
        self.restore = arguments.flag("restore", restore, "whether distances that are too small are restored")
        self.safe = arguments.non_negative_number("safe", safe, "a non-negative distance [m]")
        self.margin = arguments.positive_number("margin", margin, "a positive distance [m]")
        accepted = f"a distance above safe + margin = {self.safe + self.margin:g} m"
        self.influence = arguments.positive_or_infinite("influence", influence, accepted)
        if not self.influence > self.safe + self.margin:
            raise ArgumentError("influence", influence, accepted)
        self.gain = arguments.share("gain", gain)

    def __repr__(self) -> str:
        return f"Clearance({self.measure!r}, safe={self.safe:g})"

    @property
    def non_negative_parameters(self) -> tuple[str, ...]:
        """Names of the live parameters that no negative number can be assigned to."""
        return ("safe", "influence", *getattr(self.measure, "non_negative_parameters", ()))

    def accepted_instead(self, parameter: str, value: Array) -> str | None:
        """What would be accepted instead of a value of a live parameter; None where the value is accepted.

        Args:
            parameter: name of the live parameter, without that of the clearance.
            value: the value assigned to it.
        """
        judge = getattr(self.measure, "accepted_instead", None)
        return judge(parameter, value) if callable(judge) and parameter not in ("safe", "influence") else None

    def parameters(self, robot: Robot) -> Mapping[str, ArrayLike]:
        """Its own, and those of the measure but for `OWN`, which there belong to H.

        Args:
            robot: the robot.
        """
        own = {"safe": self.safe, "influence": min(self.influence, 1e300)}
        return {**own, **{name: value for name, value in self.measure.parameters(robot).items() if name not in OWN}}

    def of_measure(self, robot: Robot, parameters: Mapping[str, Expression]) -> dict[str, Expression]:
        """The parameters of the measure, among these of the clearance; those of `OWN` keep their first values.

        Args:
            robot: the robot.
            parameters: expressions of the live parameters of the clearance by name.
        """
        first = self.measure.parameters(robot)
        return {name: _constant(value) if name in OWN else parameters[name] for name, value in first.items()}


def _constant(value: ArrayLike) -> Expression:
    """Numbers as an expression of the shape of a live parameter."""
    array = np.asarray(value, dtype=float)
    return reshape(vertcat(*array.ravel(order="F").tolist()), *(*array.shape, 1, 1)[:2])


def clearances_of(given: Clearance | Iterable[Clearance] | None) -> tuple[Clearance, ...]:
    """The clearances, each with a name of its own. Raises ArgumentError for anything else."""
    accepted = "a jtik.Clearance, several, or None"
    found = () if given is None else arguments.instances("clearances", given, Clearance, accepted)
    names = [clearance.name for clearance in found]
    if len(set(names)) != len(names):
        raise ArgumentError("clearances", names, "a name each: Clearance(..., name=...)")
    return found


class RowValues(NamedTuple):
    """What follows from the distances and the state of a step; see the properties of `ClearanceModel`.

    Attributes:
        low: smallest increase of each distance in a step (k, 1) [m].
        demand: increase wanted of the distances that are too small (k, 1) [m].
        lacking: by how much the restored distances fall short of their aims (k, 1) [m].
        violation: the sum of ``lacking`` [m].
    """

    low: Expression
    demand: Expression
    lacking: Expression
    violation: Expression


@dataclass(frozen=True)
class ClearanceModel:
    """Clearances at one configuration, for a strategy and for the acceptance of its step.

    Attributes:
        distance: distances (k, 1) [m].
        jacobian: their Jacobian (k, n).
        safe: smallest value allowed of each (k, 1) [m].
        aim: safe + margin of each (k, 1) [m].
        influence: distance from which on each is not constrained (k, 1) [m].
        gain: share of the distance to the aim that a step may use (k, 1).
        curvature_radius: smallest radius of curvature of the surface at the safe distance of each (k, 1) [m].
        motion: upper bounds of the motion of any point of the robot from q.
        path: dq -> 1 if every distance stays safe along that displacement, else 0, and the total violation after it
            [m]; see `keeps` and `violation_after`.
        restored: which distances are restored when they are too small (k,).
        longest: how far each velocity entry may move for the restoration in this step [rad] or [m].
        smallest_violation: smallest violation so far [m].
        rows: what follows from the distances, where it is computed with them; None where it is not.
    """

    distance: Expression
    jacobian: Expression
    safe: Expression
    aim: Expression
    influence: Expression
    gain: Expression
    curvature_radius: Expression
    motion: MotionBound
    path: Callable[[Expression], tuple[Expression, Expression]]
    restored: NDArray[np.bool_]
    longest: Expression = 0
    smallest_violation: Expression = 0
    rows: RowValues | None = None

    @property
    def restores(self) -> bool:
        """Whether any distance is restored when it is too small."""
        return bool(self.restored.any())

    @cached_property
    def low(self) -> Expression:
        """Smallest increase of each distance in a step, (k, 1) [m]: negative beyond the aim, else the demand."""
        if self.rows:
            return self.rows.low
        surplus = fmax(self.distance - self.aim, 0)
        low = if_else(self.distance > self.influence, -inf, -self.gain * surplus)
        return low + self.demand if self.restores else low

    @cached_property
    def demand(self) -> Expression:
        """Increase wanted of the distances that are too small, (k, 1) [m], non-negative.

        That of a distance above ``safe`` falls with the square of ``longest``, faster than the step itself when steps
        are refused: a body that moves along an obstacle must not be kept from moving by a share of its margin.
        """
        if self.rows:
            return self.rows.demand
        shortened = fmin(self.longest / LONGEST, 1) ** 2
        return self.gain * self.lacking * if_else(self.distance < self.safe, 1, shortened)

    @cached_property
    def restored_column(self) -> Expression:
        """1 for each distance that is restored when it is too small, else 0, (k, 1)."""
        return vertcat(*self.restored.astype(float).tolist())

    @cached_property
    def lacking(self) -> Expression:
        """By how much the restored distances fall short of their aims, (k, 1) [m], non-negative."""
        if self.rows:
            return self.rows.lacking
        return lacking(self.distance, self.safe, self.aim, self.restored_column)

    @cached_property
    def violation(self) -> Expression:
        """Total violation: the sum of `lacking` [m]."""
        return self.rows.violation if self.rows else sum1(self.lacking)

    @property
    def of_rows(self) -> RowValues:
        """What follows from the distances and the state."""
        return RowValues(self.low, self.demand, self.lacking, self.violation)

    @cached_property
    def _path(self) -> Callable[[Expression], tuple[Expression, Expression]]:
        return once_for_each(self.path)

    def keeps(self, dq: Expression) -> Expression:
        """1 if every distance stays safe along the straight path of the displacement ``dq`` (n, 1), else 0.

        Args:
            dq: the displacement.
        """
        return self._path(dq)[0]

    def violation_after(self, dq: Expression) -> Expression:
        """The total violation after the displacement ``dq`` (n, 1) [m].

        Args:
            dq: the displacement.
        """
        return self._path(dq)[1]


def lacking(distance: Expression, safe: Expression, aim: Expression, restored: Expression) -> Expression:
    """By how much distances that are restored fall short of their aims [m], non-negative; columns (k, 1).

    Args:
        distance: the distances [m].
        safe: smallest value allowed of each [m].
        aim: safe + margin of each [m].
        restored: 1 where a distance is restored when it is too small, else 0.
    """
    lacks = aim - distance
    counts = restored * (lacks > TOLERATED * (aim - safe))
    return if_else(counts, lacks, 0)
