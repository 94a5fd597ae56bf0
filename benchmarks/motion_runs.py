"""Runs of a controller and what its arm would feel: the common part of `motion.py`."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

import jtik

Array = np.ndarray
REFERENCE = "weighted_qp"
"""The strategy whose figures the ratios refer to."""
SLOWEST = 1e-4
"""Speeds below this have no sign [rad/s]."""
TOLERANCE = 1e-6
"""The default tolerances of jtik [m] and [rad]; a smaller error counts as this one in a ratio."""
Cell = float | str
Row = tuple[str, tuple[Cell, ...]]


@dataclass(frozen=True)
class Motion:
    """A run along a path of k targets.

    Attributes:
        q: configurations, the start first, (k + 1, n) [rad].
        position: position error at each target, (k,) [m].
        orientation: orientation error at each target, (k,) [rad].
        failed: refused steps of `step`, or targets that `track` does not reach.
        dt: time from one target to the next [s].
    """

    q: Array
    position: Array
    orientation: Array
    failed: int
    dt: float

    @property
    def velocity(self) -> Array:
        """Mean joint velocities of the steps, (k, n) [rad/s]."""
        return np.diff(self.q, axis=0) / self.dt

    @property
    def rms_acceleration(self) -> float:
        """Root of the mean square of the joint accelerations, from second differences of q [rad/s^2]."""
        return rms(np.diff(self.q, 2, axis=0)) / self.dt**2

    @property
    def sign_changes(self) -> Array:
        """Whether the velocity of a joint has another sign than when it last had one, (k, n)."""
        velocity = self.velocity
        sign = np.sign(velocity) * (np.abs(velocity) > SLOWEST)
        last, changed = np.zeros(velocity.shape[1]), np.zeros(velocity.shape, dtype=bool)
        for k, now in enumerate(sign):
            changed[k] = now * last < 0
            last = np.where(now == 0, last, now)
        return changed


def rms(values: Array) -> float:
    """Root mean square."""
    return math.sqrt(float(np.mean(values**2)))


def solver(
    robot: jtik.Robot, strategy: str, *, kind: str = "pose", criteria: Any = None, **limits: Any
) -> jtik.InverseKinematics:
    """A solver for the tip with these `Limits`."""
    task = jtik.FrameTask("tip", kind=kind)
    return jtik.InverseKinematics(
        robot, task, strategy=strategy, criteria=criteria, limits=jtik.Limits(**limits), joints="all"
    )


def by_steps(ik: jtik.InverseKinematics, q0: Array, targets: Iterable[Any], dt: float | None) -> Motion:
    """A controller: one ``step`` for each target, from rest."""
    ik.reset()
    q, refused = np.array(q0, dtype=float), 0
    at, position, orientation = [q], [], []
    for target in targets:
        step = ik.step(q, target, dt=dt)
        q = step.q
        at.append(q)
        position.append(step.position_error)
        orientation.append(step.orientation_error)
        refused += not step.accepted
    return Motion(np.array(at), np.array(position), np.array(orientation), refused, dt or 1.0)


def by_track(ik: jtik.InverseKinematics, q0: Array, targets: Sequence[Any], dt: float) -> Motion:
    """The path in one call of ``track``."""
    found = ik.track(targets, q0=q0, dt=dt)
    q = np.vstack([q0, found.q])
    return Motion(q, found.position_error, found.orientation_error, int((~found.reached).sum()), dt)


def times(duration: float, dt: float) -> Array:
    """dt, 2 dt ... duration [s]."""
    return dt * np.arange(1, round(duration / dt) + 1)


def moved(pose: Array, displacement: Array) -> Array:
    """A pose (4, 4) moved by each row of (k, 3) [m] in world axes: (k, 4, 4)."""
    poses = np.repeat(pose[None], len(displacement), axis=0)
    poses[:, :3, 3] += displacement
    return poses


def rotation(vector: Array) -> Array:
    """The rotation (3, 3) by a rotation vector (3,) [rad]."""
    angle = float(np.linalg.norm(vector))
    if angle < 1e-12:
        return np.eye(3)
    x, y, z = vector / angle
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * K + (1 - math.cos(angle)) * K @ K


def rotation_vector(R: Array) -> Array:
    """The vector (3,) [rad] of a rotation (3, 3) by less than half a turn."""
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
    sine = float(np.linalg.norm(axis))
    if sine < 1e-9:
        return axis
    return axis * (math.atan2(sine, (float(np.trace(R)) - 1) / 2) / sine)


@dataclass(frozen=True)
class Table:
    """Figures of the strategies.

    Attributes:
        name: short name, unique in the record.
        title: what is shown.
        columns: heads of the columns after the first, which has the strategy.
        rows: (strategy, cells); one cell with a reason where there are no figures.
        groups: heads of groups of columns, if the columns repeat.
        bounds: what the figures should fulfil, and for each strategy with figures whether they do.
    """

    name: str
    title: str
    columns: tuple[str, ...]
    rows: list[Row]
    groups: tuple[str, ...] = ("",)
    bounds: dict[str, dict[str, bool]] = field(default_factory=dict)

    def text(self) -> str:
        """As plain text."""
        heads = self.columns * len(self.groups)
        width = max([len(name) for name, _ in self.rows] + [8])
        cells = [[shown(cell) for cell in row] for _, row in self.rows]
        full = [row for row in cells if len(row) == len(heads)]
        widths = [max([len(head)] + [len(row[k]) for row in full]) for k, head in enumerate(heads)]
        spans, n = [], len(self.columns)
        for k, group in enumerate(self.groups):
            span = sum(widths[k * n : (k + 1) * n]) + 2 * (n - 1)
            widths[(k + 1) * n - 1] += max(0, len(group) - span)
            spans.append(f"{group:<{max(span, len(group))}}")
        lines = [self.title]
        if any(self.groups):
            lines.append(f"{'':{width}} | {' | '.join(spans)}")
        for name, row in [("", list(heads)), *[(name, row) for (name, _), row in zip(self.rows, cells, strict=True)]]:
            padded = [f"{each:>{w}}" for each, w in zip(row, widths, strict=False)]
            if len(row) != len(heads):
                padded = row
            blocks = ["  ".join(padded[k : k + n]) for k in range(0, len(padded), n)]
            lines.append(f"{name:{width}} | {' | '.join(blocks)}")
        return "\n".join(lines)

    def record(self) -> dict[str, Any]:
        """For the JSON file."""
        keys = [f"{group}: {head}" if group else head for group in self.groups for head in self.columns]
        rows = [
            {"strategy": name, **dict(zip(keys, row, strict=True))}
            if len(row) == len(keys)
            else {"strategy": name, "note": row[0]}
            for name, row in self.rows
        ]
        return {"name": self.name, "title": self.title, "rows": rows}


def fulfilled(rows: Iterable[Row], columns: int, bound: Callable[[Any], bool]) -> dict[str, bool]:
    """Whether the cells of each strategy fulfil a bound, for rows with figures."""
    return {name: bool(bound(cells)) for name, cells in rows if len(cells) == columns}


def verdict(tables: Sequence[Table], strategies: Iterable[str]) -> Table:
    """Which bounds each strategy fulfils."""
    bounds = {head: held for table in tables for head, held in table.bounds.items()}
    words = {True: "yes", False: "no", None: ""}
    found = [(name, tuple(words[held.get(name)] for held in bounds.values())) for name in strategies]
    return Table("bounds", "what holds", tuple(bounds), found)


def shown(cell: Cell) -> str:
    """A cell as text."""
    if isinstance(cell, str):
        return cell
    if isinstance(cell, int) or not math.isfinite(cell):
        return str(cell)
    return f"{cell:.0f}" if abs(cell) >= 1000 else f"{cell:.3g}"


def rows(strategies: Iterable[str], measure: Callable[[str], tuple[Cell, ...]]) -> list[Row]:
    """A row for each strategy; one that fails has a row that says so."""
    found: list[Row] = []
    for name in strategies:
        try:
            found.append((name, measure(name)))
        except Exception as error:  # a failure of any kind is a row
            found.append((name, (f"{type(error).__name__}: {error}",)))
    return found
