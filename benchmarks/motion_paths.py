"""Paths under acceleration limits, and the self-motion beside a criterion: scenes of `motion.py`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from motion_runs import (
    REFERENCE,
    TOLERANCE,
    Array,
    Cell,
    Motion,
    Table,
    by_steps,
    by_track,
    fulfilled,
    moved,
    rms,
    rows,
    solver,
    times,
)

import jtik
from jtik_formulations import JointCentering

VELOCITY = 1.5
"""Velocity limit of the paths [rad/s]."""
ACCELERATIONS = (10.0, 50.0)
"""Acceleration limits of the paths [rad/s^2]."""
PERIODS = (0.002, 0.02)
"""Times of a step [s]."""
RUNS = {"step": by_steps, "track": by_track}
ACCELERATION_RATIO, ERROR_RATIO = 1.2, 2.0
"""What rms acceleration and largest error may be, relative to the reference."""
README_START = np.array(
    [2.25800978, -1.34884353, -1.25552235, -1.27659013, 1.66019621, 2.04833312, -1.08895018],
)
"""What the solve of the README finds, from which its path starts [rad]."""
HOLD = 0.2
"""Time for which a pose is kept beside a criterion [s]."""


@dataclass(frozen=True)
class Path:
    """A path of a Panda, from rest.

    Attributes:
        name: its name.
        title: what it is.
        q0: where it starts [rad].
        duration: its time [s].
        displacement: (time [s]) -> displacement (3,) [m] from the pose at q0 in world axes.
        criteria: of the solver.
    """

    name: str
    title: str
    q0: Array
    duration: float
    displacement: Callable[[float], Any]
    criteria: Any = None

    def targets(self, panda: jtik.Robot, dt: float) -> Array:
        """The poses of the path, (k, 4, 4)."""
        displacement = np.array([self.displacement(t) for t in times(self.duration, dt)])
        return moved(panda.pose(self.q0), displacement)


def paths_of(panda: jtik.Robot) -> list[Path]:
    """The three paths."""
    home, down = panda.keyframes["home"], panda.pose(README_START)[:3, 2]
    return [
        Path(
            "cosine",
            "0.3 m along y and back in 3 s",
            home,
            3.0,
            lambda t: (0.0, 0.15 * (1 - np.cos(2 * np.pi * t / 3)), 0.0),
        ),
        Path(
            "straight",
            "the README's path: 0.1 m/s at once, for 2 s",
            README_START,
            2.0,
            lambda t: -0.1 * t * down,
        ),
        Path(
            "sine",
            "0.2 m along y at 0.5 Hz, 0.63 m/s at once, with 0.1 * JointCentering()",
            home,
            3.0,
            lambda t: (0.0, 0.2 * np.sin(np.pi * t), 0.0),
            0.1 * JointCentering(),
        ),
    ]


@dataclass(frozen=True)
class Figures:
    """Figures of a run.

    Attributes:
        acceleration: rms of the joint accelerations [rad/s^2].
        error_rms: rms of the position error [m].
        error: largest position error [m].
        signs: sign changes of joint velocities.
        failed: refused steps, or targets that are not reached.
        steps: number of steps.
    """

    acceleration: float
    error_rms: float
    error: float
    signs: int
    failed: int
    steps: int

    @classmethod
    def of(cls, motion: Motion) -> Figures:
        """The figures of a run."""
        return cls(
            acceleration=motion.rms_acceleration,
            error_rms=rms(motion.position),
            error=float(motion.position.max()),
            signs=int(motion.sign_changes.sum()),
            failed=motion.failed,
            steps=len(motion.position),
        )

    def ratios(self, reference: Figures) -> tuple[float, float]:
        """Ratios of rms acceleration and of errors, the larger of rms and largest, each at least `TOLERANCE`."""
        pairs = (self.error, reference.error), (self.error_rms, reference.error_rms)
        error = max(max(mine, TOLERANCE) / max(other, TOLERANCE) for mine, other in pairs)
        return self.acceleration / reference.acceleration, error


Found = dict[tuple[str, str, str], list[Figures]]
"""(path, "step" or "track", strategy) -> figures of each case."""


def paths(strategies: Sequence[str], quick: bool) -> list[Table]:
    """Paths under acceleration limits, by `step` and by `track`."""
    panda = jtik.Robot.builtin("panda")
    accelerations = ACCELERATIONS[:1] if quick else ACCELERATIONS
    # thousands of targets that cannot be reached take `track` half of the time of all scenes
    periods = {"step": PERIODS, "track": PERIODS[1:] if quick else PERIODS}
    cases = {mode: [(a, dt) for dt in periods[mode] for a in accelerations] for mode in RUNS}
    found: Found = {}
    tables = []
    for path in paths_of(panda):
        targets = {dt: path.targets(panda, dt) for dt in PERIODS}

        def measure(name: str, path: Path = path, targets: dict[float, Array] = targets) -> tuple[Cell, ...]:
            solvers = {
                a: solver(panda, name, criteria=path.criteria, velocity=VELOCITY, acceleration=a) for a in accelerations
            }
            for mode, run in RUNS.items():
                found[path.name, mode, name] = [
                    Figures.of(run(solvers[a], path.q0, targets[dt], dt)) for a, dt in cases[mode]
                ]
            return ()

        notes = dict(rows(dict.fromkeys((REFERENCE, *strategies)), measure))
        for mode in RUNS:
            table = rows(
                strategies,
                lambda name, mode=mode, path=path, notes=notes: (
                    notes[name] or _cells(found[path.name, mode, name], found[path.name, mode, REFERENCE])
                ),
            )
            columns = ("acc", "x ref", "rms", "max", "x ref", "signs", "refused" if mode == "step" else "missed")
            groups = tuple(f"{1e3 * dt:g} ms, {a:g} rad/s^2" for a, dt in cases[mode])
            title = f"{path.name}, {mode}: {path.title}; acc [rad/s^2], errors rms and max [mm]"
            tables.append(Table(f"{path.name}, {mode}", title, columns, table, groups))
    return [*tables, _summary(strategies, found)]


def _cells(figures: Sequence[Figures], references: Sequence[Figures]) -> tuple[Cell, ...]:
    cells: list[Cell] = []
    for mine, reference in zip(figures, references, strict=True):
        acceleration, error = mine.ratios(reference)
        cells += [mine.acceleration, acceleration, 1e3 * mine.error_rms, 1e3 * mine.error, error]
        cells += [mine.signs, mine.failed]
    return tuple(cells)


def _summary(strategies: Sequence[str], found: Found) -> Table:
    """The largest ratios of each strategy over the paths, and how many runs are within the bounds."""

    def measure(name: str) -> tuple[Cell, ...]:
        cells: list[Cell] = []
        for mode in RUNS:
            ratios = np.array(
                [
                    mine.ratios(reference)
                    for (path, run, strategy), figures in found.items()
                    if run == mode and strategy == name
                    for mine, reference in zip(figures, found[path, run, REFERENCE], strict=True)
                ]
            )
            if not len(ratios):
                return ("no figures",)
            within = (ratios <= (ACCELERATION_RATIO, ERROR_RATIO)).all(axis=1).sum()
            cells += [float(ratios[:, 0].max()), float(ratios[:, 1].max()), f"{within}/{len(ratios)}"]
        return tuple(cells)

    title = (
        f"paths, largest ratios to {REFERENCE} and runs within {ACCELERATION_RATIO:g} (acceleration) "
        f"and {ERROR_RATIO:g} (error)"
    )
    table = rows(strategies, measure)
    bounds = {
        f"paths, {mode}": fulfilled(
            table, 6, lambda cells, k=k: cells[3 * k] <= ACCELERATION_RATIO and cells[3 * k + 1] <= ERROR_RATIO
        )
        for k, mode in enumerate(RUNS)
    }
    return Table("paths", title, ("x acc", "x error", "within"), table, tuple(RUNS), bounds)


def self_motion(strategies: Sequence[str], quick: bool) -> list[Table]:
    """Steps from rest at a fixed pose beside a criterion: the speed along the self-motion for several dt."""
    panda = jtik.Robot.builtin("panda")
    q0 = np.clip(panda.keyframes["home"] + 0.3, panda.lower, panda.upper)
    pose, periods = panda.pose(q0), (0.002, 0.01, 0.02)

    def measure(name: str) -> tuple[Cell, ...]:
        ik = solver(panda, name, criteria=JointCentering())
        cells: list[Cell] = []
        for dt in periods:
            motion = by_steps(ik, q0, [pose] * round(HOLD / dt), dt)
            speed = np.abs(motion.velocity).max(axis=1)
            moved = float(np.abs(motion.q[-1] - q0).max())
            cells += [float(speed[0]), float(speed[-1]), moved, 1e3 * float(motion.position.max()), motion.failed]
        return tuple(cells)

    slowest = float(panda.velocity_limit.min())

    def independent_of_dt(cells: Sequence[float]) -> bool:
        """Whether speed and motion do not depend on dt by more than a tenth, below the velocity limits."""
        first, motion = cells[0::5], cells[2::5]
        return min(motion) > 0.9 * max(motion) and 0.9 * max(first) < min(first) < 0.99 * slowest

    title = (
        f"self-motion: Panda from rest beside JointCentering(): largest joint speed of the first step and after "
        f"{HOLD:g} s [rad/s], motion until then [rad], largest error [mm]"
    )
    columns = ("first", "last", "motion", "error", "refused")
    groups = tuple(f"{1e3 * dt:g} ms" for dt in periods)
    table = rows(strategies, measure)
    bounds = {"self-motion": fulfilled(table, 15, independent_of_dt)}
    return [Table("self-motion", title, columns, table, groups, bounds)]
