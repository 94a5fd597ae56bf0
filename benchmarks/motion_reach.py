"""Out of reach, out and back, and from a zero pose: scenes of `motion.py`."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from motion_runs import (
    Array,
    Cell,
    Table,
    by_steps,
    by_track,
    fulfilled,
    moved,
    rms,
    rotation,
    rotation_vector,
    rows,
    solver,
    times,
)

import jtik

REACH = {"position": 0.942, "pose": 0.865}
"""Largest distance of the UR5e's tip from the base axis at `HEIGHT`; for poses with the orientation of `home` [m]."""
HEIGHT, BEYOND = 0.4, 0.1
"""Height of the arc and its distance from the workspace [m]."""
ARRIVAL, STEPS, QUIET, AT_REST = 200, 449, 5, 1e-4
"""Steps before the arc and on it, in how many of these a sign may change, and motion that counts as none [rad]."""
OUTWARDS = 0.5
"""How far the Panda's tip is drawn out, 82 mm more than it can go [m]."""
RETURN = 4.0
"""Time out and back [s]."""
SWEPT_OUT, SWEPT_ASIDE = 1.02, 0.4
"""How far it is drawn out by the sweeps, 0.6 m more than it can go, and to either side [m]."""
SETTLE = 1.0
"""Time at the returned target [s]."""
LOST = 1e-3
"""An error after return that counts as one [m]."""
ZERO_ENDS = {"panda": 3, "ur5e": 3, "iiwa14": 7, "gen3": 8}
"""Seeds of the configurations to which the arms move from their zero poses."""


def arc(robot: jtik.Robot, kind: str, beyond: float, angles: Array) -> list[Array]:
    """Targets on a circle about the base axis: positions, or poses that turn with it."""
    start, radius = robot.pose(robot.keyframes["home"]), REACH[kind] + beyond
    targets = []
    for angle in angles:
        target = np.eye(4)
        target[:3, :3] = rotation(np.array([0.0, 0.0, angle])) @ start[:3, :3]
        target[:3, 3] = radius * math.cos(angle), radius * math.sin(angle), HEIGHT
        targets.append(target if kind == "pose" else target[:3, 3])
    return targets


def out_of_reach(strategies: Sequence[str], quick: bool) -> list[Table]:
    """A UR5e whose target is outside the workspace, on a slow arc or fixed."""
    arm, dt = jtik.Robot.builtin("ur5e"), 0.02
    home = arm.keyframes["home"]
    slow = np.concatenate([np.full(ARRIVAL, -0.6), np.linspace(-0.6, 0.6, STEPS)])
    distances = (0.1,) if quick else (0.02, 0.1, 0.5)
    angles = (0.6,) if quick else (-0.5, 0.6)
    long = 600 if quick else 1500

    def measure(name: str) -> tuple[Cell, ...]:
        cells: list[Cell] = []
        for kind in REACH:
            ik = solver(arm, name, kind=kind)
            motion = by_steps(ik, home, arc(arm, kind, BEYOND, slow), dt)
            changes = motion.sign_changes[ARRIVAL:].any(axis=1)
            rate = rms(np.diff(motion.q[ARRIVAL:], 2, axis=0)) / dt**2
            cells += [int(changes.sum()), rate, 1e3 * motion.position[-1]]
            fixed = [arc(arm, kind, beyond, [angle])[0] for beyond in distances for angle in angles]
            for period in (dt, None):
                ends = [by_steps(ik, home, [goal] * long, period).q[-101:] for goal in fixed]
                cells.append(max(float(np.abs(np.diff(end, axis=0)).max()) for end in ends))
        return tuple(cells)

    title = (
        f"out of reach: UR5e, {STEPS} steps of {1e3 * dt:g} ms on an arc {BEYOND:g} m outside: steps with a sign "
        "change, acceleration [rad/s^2], error [mm]; fixed targets: largest motion of a late step [rad]"
    )
    columns = ("signs", "acc", "error", "fixed, dt", "fixed, no dt")
    table = rows(strategies, measure)
    bounds = {
        "quiet outside": fulfilled(table, 10, lambda cells: max(cells[0], cells[5]) < QUIET),
        "fixed at rest": fulfilled(table, 10, lambda cells: max(cells[3:5] + cells[8:10]) < AT_REST),
    }
    return [Table("out of reach", title, columns, table, tuple(REACH), bounds)]


def out_and_back(strategies: Sequence[str], quick: bool) -> list[Table]:
    """A Panda whose tip is drawn out of the workspace and back."""
    panda = jtik.Robot.builtin("panda")
    home = panda.keyframes["home"]
    start = panda.pose(home)

    def path(duration: float, dt: float, x: float, y: float, frequency: float) -> tuple[Array, int]:
        """Poses drawn out by x with sideways sweeps of y, then at rest; and the index of the return."""
        t = times(duration, dt)
        out = (1 - np.cos(2 * np.pi * t / duration)) / 2
        displacement = np.zeros((len(t) + round(SETTLE / dt), 3))
        displacement[: len(t), 0] = x * out
        displacement[: len(t), 1] = y * out * np.sin(2 * np.pi * frequency * t)
        return moved(start, displacement), len(t) - 1

    def drawn(name: str) -> tuple[Cell, ...]:
        targets, back = path(RETURN, 0.002, OUTWARDS, 0.0, 0.0)
        cells: list[Cell] = []
        for acceleration in accelerations:
            motion = by_steps(solver(panda, name, velocity=2.0, acceleration=acceleration), home, targets, 0.002)
            errors = 1e3 * motion.position
            cells += [float(errors[: back + 1].max()), float(errors[back]), float(errors[-1])]
            cells += [motion.rms_acceleration, motion.failed]
        return tuple(cells)

    def swept(name: str) -> tuple[Cell, ...]:
        dt, ik, ends = 1 / 72, solver(panda, name), []
        for duration in (8.0,) if quick else (8.0, 12.0):
            for frequency in (0.5,) if quick else (0.25, 0.5, 1.0):
                targets, _ = path(duration, dt, SWEPT_OUT, SWEPT_ASIDE, frequency)
                ends.append(float(by_steps(ik, home, targets, dt).position[-1]))
        return sum(end > LOST for end in ends), len(ends), 1e3 * max(ends)

    accelerations = (None, 20.0)
    out, swept_rows = rows(strategies, drawn), rows(strategies, swept)
    lost = 1e3 * LOST
    columns = ("largest", "return", "later", "acc", "refused")
    bounds = {
        "returns": fulfilled(out, 10, lambda cells: cells[1] < lost),
        "returns, acc 20": fulfilled(out, 10, lambda cells: max(cells[6:8]) < lost),
        "sweeps": fulfilled(swept_rows, 3, lambda cells: cells[0] == 0),
    }
    return [
        Table(
            "out and back",
            f"out and back: Panda, 500 Hz, {OUTWARDS:g} m outwards and back in {RETURN:g} s: largest error, error at "
            f"return and {SETTLE:g} s later [mm], acceleration [rad/s^2]",
            columns,
            out,
            ("velocity 2 rad/s", "velocity 2 rad/s, acceleration 20 rad/s^2"),
            bounds,
        ),
        Table(
            "sweeps",
            "sweeps: Panda, 72 Hz, 0.6 m past the reach and back with sideways sweeps: "
            f"runs that end more than {1e3 * LOST:g} mm off, largest error at the end [mm]",
            ("lost", "of", "largest"),
            swept_rows,
        ),
    ]


def zero_pose(strategies: Sequence[str], quick: bool) -> list[Table]:
    """Straight paths from the zero pose, which is singular for most arms, to a pose inside."""
    periods = (0.02,) if quick else (0.02, 0.005)
    arms = {name: jtik.Robot.builtin(name) for name in (list(ZERO_ENDS)[::2] if quick else ZERO_ENDS)}

    def straight(arm: jtik.Robot, seed: int, dt: float) -> tuple[Array, list[Array]]:
        q0 = np.clip(np.zeros(arm.n), arm.lower, arm.upper)
        lower, upper = np.maximum(arm.lower, -1.5), np.minimum(arm.upper, 1.5)
        end = arm.pose(np.random.default_rng(seed).uniform(lower, upper))
        start = arm.pose(q0)
        turn = rotation_vector(start[:3, :3].T @ end[:3, :3])
        targets = []
        for share in (1 - np.cos(np.pi * times(4.0, dt) / 4)) / 2:
            target = start.copy()
            target[:3, 3] += share * (end - start)[:3, 3]
            target[:3, :3] = start[:3, :3] @ rotation(share * turn)
            targets.append(target)
        return q0, targets

    goals = {(name, dt): straight(robot, ZERO_ENDS[name], dt) for name, robot in arms.items() for dt in periods}

    def measure(name: str) -> tuple[Cell, ...]:
        cells: list[Cell] = []
        for arm, robot in arms.items():
            ik = solver(robot, name)
            for dt in periods:
                q0, targets = goals[arm, dt]
                motion = by_steps(ik, q0, targets, dt)
                cells += [1e3 * float(motion.position.max()), 1e3 * float(motion.position[-1])]
            q0, targets = goals[arm, periods[0]]
            cells.append(1e3 * float(by_track(ik, q0, targets, periods[0]).position.max()))
        return tuple(cells)

    columns = tuple(f"{what} {1e3 * dt:g} ms" for dt in periods for what in ("max", "end"))
    title = "zero pose: straight paths of 4 s from q = 0 inwards: errors of step, largest and at the end, of track [mm]"
    table = rows(strategies, measure)
    width = 2 * len(periods) + 1

    def arrives(cells: Sequence[float]) -> bool:
        """Whether every error of `step` at the end is small."""
        return all(cells[k + 2 * i + 1] < 1e3 * LOST for k in range(0, len(cells), width) for i in range(len(periods)))

    bounds = {"zero pose": fulfilled(table, width * len(arms), arrives)}
    return [Table("zero pose", title, (*columns, "track"), table, tuple(arms), bounds)]
