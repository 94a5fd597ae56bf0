"""Steps and paths with joints at their velocity limits: scenes of `motion.py`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from motion_runs import (
    Array,
    Cell,
    Motion,
    Row,
    Table,
    by_steps,
    fulfilled,
    moved,
    rotation,
    rotation_vector,
    rows,
    solver,
    times,
)

import jtik

DT = 1e-3
"""Time of a step of a random state, in which J changes little [s]."""
ENOUGH, STRAIGHT, STILL = 0.99, 0.01, 1e-6
"""Share of the feasible progress that counts as all of it, angle that counts as kept [rad], and share of the wanted
speed that counts as none, which has no direction."""
MISSED, EXACT = 1 / 300, 1e-3
"""Share of the states that may miss either, and accuracy of the published example [rad/s]."""
EXAMPLE_Q = np.array([1.0, -1.0, 1.0, -1.0]) * math.pi / 2
EXAMPLE_VELOCITY = np.array([-4.0, -1.5])
EXAMPLE_LIMITS = (2.0, 2.0, 4.0, 4.0)
EXAMPLE_ANSWER = np.array([2, -11 / 6, 11 / 6, -11 / 3])
"""The example of Flacco, De Luca and Khatib (2015): unit 4R, configuration [rad], task velocity [m/s], limits and
joint velocities [rad/s]."""
SPEED = 0.8
"""Velocity limit of the slow arm [rad/s]."""
NEARLY = 1.5
"""Errors and accelerations of the slow arm that count as pink's, relative to them."""
SLOW_DT = 0.005
"""Time of its steps [s]."""


class State:
    """A configuration, the wanted velocity of its task, and the share of it that the velocity limits allow.

    Attributes:
        q: configuration (n,) [rad].
        J: Jacobian of the task (m, n).
        wanted: task velocity (m,) [m/s] and [rad/s].
        target: where it leads in `DT`.
        share: largest s in [0, 1] with J dq = s wanted within the limits.
    """

    def __init__(self, robot: jtik.Robot, kind: str, velocity: Array, generator: np.random.Generator) -> None:
        lower, upper = np.maximum(robot.lower, -math.pi), np.minimum(robot.upper, math.pi)
        self.q = generator.uniform(lower, upper)
        self.J = robot.jacobian(self.q, "tip")[: 2 if kind == "position" else 6]
        direction = generator.normal(size=len(self.J))
        # half of the wanted velocities are feasible, most of them only with a joint at its limit
        feasible = _largest(self.J, direction, velocity)
        self.wanted = direction * feasible * generator.uniform(0.5, 1.5)
        self.share = min(1.0, _largest(self.J, self.wanted, velocity))
        self.target = _ahead(robot, self.q, self.wanted, kind)

    def step(self, ik: jtik.InverseKinematics) -> tuple[float, float]:
        """Progress of a first step relative to the feasible one, and its angle from the wanted direction [rad]."""
        ik.reset()
        got = self.J @ (ik.step(self.q, self.target, dt=DT).q - self.q) / DT
        length, full = float(np.linalg.norm(got)), float(np.linalg.norm(self.wanted))
        if length < STILL * full:
            return 0.0, 0.0
        along = float(got @ self.wanted) / full
        return along / full / self.share, math.acos(max(-1.0, min(1.0, along / length)))


def _largest(J: Array, wanted: Array, velocity: Array) -> float:
    """The largest s with J dq = s wanted and |dq| <= velocity, by a linear program."""
    from scipy.optimize import linprog

    n = J.shape[1]
    bounds = [*((-v, v) for v in velocity), (0, None)]
    found = linprog(np.r_[np.zeros(n), -1.0], A_eq=np.c_[J, -wanted], b_eq=np.zeros(len(J)), bounds=bounds)
    if not found.success:
        raise RuntimeError(f"linear program: {found.message}")
    return float(found.x[-1])


def _ahead(robot: jtik.Robot, q: Array, velocity: Array, kind: str) -> Array:
    """The target a step of `DT` ahead."""
    pose = robot.pose(q, "tip")
    if kind == "position":
        return pose[:2, 3] + DT * velocity
    ahead = pose.copy()
    ahead[:3, 3] += DT * velocity[:3]
    ahead[:3, :3] = rotation(DT * velocity[3:]) @ pose[:3, :3]
    return ahead


def limits(strategies: Sequence[str], quick: bool) -> list[Table]:
    """Joints at their velocity limits: the published example, random states, and a slow arm on two paths."""
    return [_random_states(strategies, quick), _slow_arm(strategies)]


def _random_states(strategies: Sequence[str], quick: bool) -> Table:
    planar, panda = jtik.Robot.planar(4), jtik.Robot.builtin("panda")
    arms = {"4R, position": (planar, "position"), "7R (Panda), pose": (panda, "pose")}
    sets, size = (2, 25) if quick else (6, 50)
    generator = np.random.default_rng(0)
    drawn: dict[str, list[tuple[Array, list[State]]]] = {}
    for label, (robot, kind) in arms.items():
        drawn[label] = []
        for _ in range(sets):
            velocity = generator.uniform(0.5, 2.0, robot.n)
            drawn[label].append((velocity, [State(robot, kind, velocity, generator) for _ in range(size)]))
    ahead = _ahead(planar, EXAMPLE_Q, EXAMPLE_VELOCITY, "position")

    def measure(name: str) -> tuple[Cell, ...]:
        ik = solver(planar, name, kind="position", velocity=EXAMPLE_LIMITS)
        got = (ik.step(EXAMPLE_Q, ahead, dt=DT).q - EXAMPLE_Q) / DT
        cells: list[Cell] = [float(np.abs(got - EXAMPLE_ANSWER).max())]
        for label, (robot, kind) in arms.items():
            figures = []
            for velocity, states in drawn[label]:
                ik = solver(robot, name, kind=kind, velocity=velocity, position=False)
                figures += [state.step(ik) for state in states]
            progress, angle = np.array(figures).T
            cells += [int((progress < ENOUGH).sum()), int((progress == 0).sum()), float(np.median(progress))]
            cells += [int((angle > STRAIGHT).sum()), float(angle.max())]
            cells.append(int(((progress < ENOUGH) | (angle > STRAIGHT)).sum()))
        return tuple(cells)

    title = (
        f"velocity limits: deviation from the published 4R example [rad/s]; first steps of {sets * size} random "
        f"states: progress below {ENOUGH:g} of the linear program's, none, median; direction off by more than "
        f"{STRAIGHT:g} rad, largest angle [rad]; either"
    )
    heads = ("slow", "none", "median", "off", "angle", "either")
    columns = ("example", *(f"{head} {label[:2]}" for label in arms for head in heads))
    table = rows(strategies, measure)
    allowed = sets * size * MISSED
    bounds = {
        "4R example": fulfilled(table, 13, lambda cells: cells[0] < EXACT),
        "progress": fulfilled(table, 13, lambda cells: max(cells[1], cells[7]) <= allowed),
        "direction": fulfilled(table, 13, lambda cells: max(cells[4], cells[10]) <= allowed),
    }
    return Table("velocity limits", title, columns, table, bounds=bounds)


def _slow_arm(strategies: Sequence[str]) -> Table:
    arm = jtik.Robot.builtin("ur5e")
    home = arm.keyframes["home"]
    t = times(6.0, SLOW_DT)
    swing = 0.1 * np.sin(np.pi * t)[:, None] ** 3 * np.array([0.0, 1.0, 1.0])
    # joint speeds up to 0.9 rad/s, each joint at its own frequency
    rate = 2 * np.pi / 3 * np.array([1.0, 0.6, 0.8, 1.1, 0.7, 1.3])
    joints = home + 0.9 / rate * (1 - np.cos(np.outer(t, rate)))
    targets = {"line": moved(arm.pose(home), swing), "joints": np.array([arm.pose(q) for q in joints])}

    def cells(motions: Sequence[Motion]) -> tuple[Cell, ...]:
        found: list[Cell] = []
        for motion in motions:
            found += [1e3 * float(motion.position.max()), 1e3 * float(motion.orientation.max())]
            found += [motion.rms_acceleration, int(motion.sign_changes.sum())]
            found.append(100 * float((np.abs(motion.velocity) > SPEED - 1e-6).any(axis=1).mean()))
        return tuple(found)

    def measure(name: str) -> tuple[Cell, ...]:
        ik = solver(arm, name, velocity=SPEED)
        return cells([by_steps(ik, home, path, SLOW_DT) for path in targets.values()])

    peer: list[Row] = rows(["pink"], lambda _: cells([_by_pink(arm, home, path) for path in targets.values()]))
    title = (
        f"slow arm: UR5e at {SPEED:g} rad/s, steps of {1e3 * SLOW_DT:g} ms: largest errors [mm] and [mrad], "
        "acceleration [rad/s^2], sign changes, steps with a joint at its limit [%]"
    )
    columns = ("mm", "mrad", "acc", "signs", "at limit")
    table = rows(strategies, measure)
    bounds = {}
    reference = next((cells for _, cells in peer if len(cells) == 10), None)
    if reference is not None:
        bounds["slow arm"] = fulfilled(table, 10, lambda cells: _as_good(cells, reference))
    return Table("slow arm", title, columns, [*peer, *table], tuple(targets), bounds)


def _as_good(cells: Sequence[Any], reference: Sequence[Any]) -> bool:
    """Whether errors (norm of [mm] and [mrad]) and acceleration are at most `NEARLY` times the reference's."""
    return all(
        math.hypot(*cells[k : k + 2]) <= NEARLY * math.hypot(*reference[k : k + 2])
        and cells[k + 2] <= NEARLY * reference[k + 2]
        for k in (0, 5)
    )


def _by_pink(robot: jtik.Robot, q0: Array, targets: Sequence[Array]) -> Motion:
    """The path by `pink.solve_ik`, a step for each target, judged by the kinematics of jtik."""
    import pink
    import pinocchio as pin

    from jtik.interop.urdf import to_urdf

    model: Any = pin.buildModelFromXML(to_urdf(robot))
    model.velocityLimit[:] = SPEED
    configuration = pink.Configuration(model, model.createData(), q0.copy())
    task = pink.FrameTask("tip", position_cost=1.0, orientation_cost=1.0, lm_damping=0.0)
    bounds = [pink.limits.ConfigurationLimit(model), pink.limits.VelocityLimit(model)]
    at, position, orientation = [q0], [], []
    for target in targets:
        task.set_target(pin.SE3(target))
        velocity = pink.solve_ik(configuration, [task], SLOW_DT, solver="daqp", limits=bounds, safety_break=False)
        configuration.integrate_inplace(velocity, SLOW_DT)
        at.append(configuration.q.copy())
        pose = robot.pose(at[-1])
        position.append(float(np.linalg.norm(pose[:3, 3] - target[:3, 3])))
        orientation.append(float(np.linalg.norm(rotation_vector(pose[:3, :3].T @ target[:3, :3]))))
    return Motion(np.array(at), np.array(position), np.array(orientation), 0, SLOW_DT)
