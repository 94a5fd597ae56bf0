"""Figures of attempts, side by side."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.between import ACCURACY
from jtik.planner.attempts.clearances import clearance
from jtik.planner.attempts.motion import Motion, placements, read_attempt
from jtik.robot import Robot
from jtik.study.path_metrics import displacements
from jtik.types import Array

CLOSED = 0.01
"""Distance between the first and the last target, as a share of the path of targets, up to which the path is closed."""


@dataclass(frozen=True, kw_only=True)
class Measures:
    """Figures of an attempt. Joint-space figures count a radian as a metre.

    Attributes:
        name: name of the attempt.
        parent: name of the attempt that it branched from; None for none.
        strategy: name of the strategy.
        samples: number of samples.
        duration: time from the first to the last sample [s].
        path_length: length of the end effector's path [m].
        joint_length: length of the path in joint space [rad] and [m].
        smoothness: root mean square of the joint acceleration [rad/s^2]; smaller is smoother. NaN below three samples.
        reversals: how often a joint changes its direction.
        clearance: smallest distance of a body to an obstacle, between the samples too [m]; infinite without obstacles.
        clearance_bound: a distance below which none is, `accuracy` below `clearance` at most [m].
        clearance_time: where the smallest distance was found [s].
        clearance_body: name of that body, such as "link2-link3".
        clearance_obstacle: name of that obstacle.
        limit_margin: smallest distance of a joint to a position limit, negative beyond it [rad] or [m]; infinite
            without limits.
        limit_joint: name of that joint; empty without limits.
        limit_time: when it was there [s].
        condition: largest condition number of the task's Jacobian at a sample; infinite at a singularity.
        condition_time: where it was found [s].
        target_error: largest distance of the end effector to the target [m].
        closed: whether the targets end where they begin.
        closing_error: joint-space distance between the first and the last configuration of a closed path [rad] and [m];
            NaN for a path that is not closed.
        closing_distance: distance between the first and the last position of the end effector on a closed path [m];
            NaN for another.
    """

    name: str
    parent: str | None
    strategy: str
    samples: int
    duration: float
    path_length: float
    joint_length: float
    smoothness: float
    reversals: int
    clearance: float
    clearance_bound: float
    clearance_time: float
    clearance_body: str
    clearance_obstacle: str
    limit_margin: float
    limit_joint: str
    limit_time: float
    condition: float
    condition_time: float
    target_error: float
    closed: bool
    closing_error: float
    closing_distance: float

    def to_json(self) -> dict[str, Any]:
        """Plain data; null for what is infinite or not defined."""
        return {key: None if _is_missing(value) else value for key, value in asdict(self).items()}


COLUMNS: tuple[tuple[str, str, str], ...] = (
    ("name", "attempt", ""),
    ("duration", "duration", "s"),
    ("path_length", "path", "m"),
    ("joint_length", "joint path", "rad"),
    ("smoothness", "rms acceleration", "rad/s²"),
    ("reversals", "reversals", ""),
    ("clearance", "clearance", "m"),
    ("limit_margin", "limit margin", "rad"),
    ("condition", "condition", ""),
    ("target_error", "target error", "m"),
    ("closing_error", "closing error", "rad"),
)
"""The columns of a table of attempts: key of `Measures`, title, unit."""


def measure(
    attempt: Attempt, robot: Robot, *, frame: str | None = None, bodies: str | None = None, accuracy: float = ACCURACY
) -> Measures:
    """The figures of an attempt.

    Args:
        attempt: the attempt.
        robot: the robot of its configurations.
        frame: name of the end effector's frame; the tip when None.
        bodies: what may not come close to obstacles, as in the criterion "obstacle_avoidance": "joints", "links",
            "both" or "shapes". By default "shapes" on a robot that has any, else "links".
        accuracy: how far `Measures.clearance` may be above the smallest distance [m].

    Raises:
        ArgumentError: for an argument that cannot be used, or a scene that is no `jtik.Scene`.
    """
    q, times = read_attempt(attempt, robot).configurations, attempt.times
    motion = Motion.of(robot, times, q)
    positions, jacobians = placements(robot, q, frame=frame, pose=attempt.targets.shape[1] == 7)
    targets = attempt.targets[:, : robot.dimension]
    conditions = _conditions(jacobians)
    worst = int(conditions.argmax())
    margin, joint, at = _limit_margin(robot, q)
    nearest, obstacle = clearance(robot, attempt, bodies=bodies, accuracy=accuracy)
    around = float(np.linalg.norm(np.diff(targets, axis=0), axis=1).sum())
    closed = around > 0 and float(np.linalg.norm(targets[-1] - targets[0])) <= CLOSED * around
    return Measures(
        name=attempt.name,
        parent=attempt.parent,
        strategy=attempt.strategy,
        samples=len(attempt),
        duration=attempt.duration,
        path_length=float(np.linalg.norm(np.diff(positions, axis=0), axis=1).sum()),
        joint_length=motion.length,
        smoothness=motion.smoothness,
        reversals=motion.reversals,
        clearance=nearest.distance,
        clearance_bound=nearest.bound,
        clearance_time=nearest.time,
        clearance_body=nearest.body,
        clearance_obstacle=obstacle,
        limit_margin=margin,
        limit_joint=joint,
        limit_time=float(times[at]),
        condition=float(conditions[worst]),
        condition_time=float(times[worst]),
        target_error=float(np.linalg.norm(positions - targets, axis=1).max()),
        closed=closed,
        closing_error=float(np.linalg.norm(displacements(robot, q[[0, -1]]))) if closed else math.nan,
        closing_distance=float(np.linalg.norm(positions[-1] - positions[0])) if closed else math.nan,
    )


def table(measures: Iterable[Measures], chosen: str | None = None) -> str:
    """The figures of several attempts as a text, one line each; the chosen one is marked."""
    rows = [[title if not unit else f"{title} [{unit}]" for _, title, unit in COLUMNS]]
    for each in measures:
        data = each.to_json()
        rows.append([_cell(data[key]) for key, _, _ in COLUMNS])
        rows[-1][0] += " *" * (each.name == chosen)
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return "\n".join(_line(row, widths) for row in rows)


def _conditions(jacobians: Array) -> Array:
    """Condition number of each Jacobian (k, m, n)."""
    values = np.linalg.svd(jacobians, compute_uv=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        found: Array = np.where(values[:, -1] > 1e-14 * values[:, 0], values[:, 0] / values[:, -1], np.inf)
    return found


def _limit_margin(robot: Robot, q: Array) -> tuple[float, str, int]:
    """The smallest margin to a position limit, the joint and the sample."""
    margins = np.minimum(q - robot.lower, robot.upper - q)
    if not margins.size or not np.isfinite(margins).any():
        return math.inf, "", 0
    at, entry = np.unravel_index(int(margins.argmin()), margins.shape)
    joint = next(name for name in robot.joint_names if entry in range(*robot.q_slice(name).indices(robot.nq)))
    return float(margins[at, entry]), joint, int(at)


def _is_missing(value: object) -> bool:
    return isinstance(value, float) and not math.isfinite(value)


def _cell(value: object) -> str:
    return "-" if value is None else f"{value:.4g}" if isinstance(value, float) else str(value)


def _line(row: Sequence[str], widths: Sequence[int]) -> str:
    first, *rest = zip(row, widths, strict=True)
    return "  ".join([first[0].ljust(first[1]), *(cell.rjust(width) for cell, width in rest)])
