"""What is wrong with a motion: limits, speeds, accelerations and clearances that do not hold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from jtik.arguments import instance, non_negative_number
from jtik.constraints import Limits
from jtik.errors import ArgumentError
from jtik.geometry import Scene
from jtik.planner.attempts.attempt import Attempt
from jtik.planner.attempts.between import ACCURACY
from jtik.planner.attempts.clearances import smallest
from jtik.planner.attempts.motion import Motion
from jtik.planner.commit.commands import JointCommands
from jtik.robot import Robot
from jtik.types import Array

ROUNDING = 1e-6
"""Share of a limit of speed or acceleration by which differences of positions may be above it by rounding."""

AT_LIMIT = 1e-9
"""How far a position may be beyond its limit by rounding [rad] or [m]."""


@dataclass(frozen=True)
class Finding:
    """Something in a motion that a robot cannot or must not do.

    Attributes:
        kind: "position", "velocity", "acceleration" or "clearance".
        joint: name of the joint; of the body for a clearance.
        time: where it is worst [s].
        value: the figure there [rad], [m], [rad/s] ...
        limit: what is allowed.
        text: a sentence.
    """

    kind: str
    joint: str
    time: float
    value: float
    limit: float
    text: str

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


def check(
    motion: Attempt | JointCommands,
    robot: Robot,
    *,
    limits: Limits | None = None,
    scene: Scene | Mapping[str, Any] | None = None,
    safe: float = 0.0,
    bodies: str | None = None,
    accuracy: float = ACCURACY,
) -> tuple[Finding, ...]:
    """What is wrong with a motion: one finding for each joint and limit, where it is worst; none for a good one.

    Speeds are those between samples. Accelerations are the changes of these; at the first and the last sample from and
    to rest. The joints move straight between samples, where clearances are bounded, too.

    Args:
        motion: an attempt, or joint commands.
        robot: the robot.
        limits: which limits hold; the robot's own positions and velocities by default.
        scene: the obstacles, a `jtik.Scene` or its dict; by default those of the attempt when it ended.
        safe: smallest distance allowed of any body to any obstacle [m].
        bodies: what may not come close to obstacles; by default "shapes", else "links", else "joints".
        accuracy: how far the distance found may be above the smallest one [m].

    Raises:
        ArgumentError: for an argument that cannot be used.
    """
    instance("motion", motion, (Attempt, JointCommands), "an Attempt, or JointCommands")
    instance("robot", robot, Robot, "a jtik.Robot")
    given = Limits() if limits is None else instance("limits", limits, Limits, "a jtik.Limits, or None")
    safe = non_negative_number("safe", safe, "a non-negative distance [m]")
    bounds = given.of(robot)
    if motion.configurations.shape[1] != robot.nq:
        width = f"configurations of {motion.configurations.shape[1]} numbers"
        raise ArgumentError("motion", width, f"configurations of {robot!r}")
    times, q = motion.times, motion.configurations
    findings = _positions(robot, times, q, bounds.lower, bounds.upper)
    moved = Motion.of(robot, times, q)
    if len(times) > 1:
        middles = (times[1:] + times[:-1]) / 2
        rest = np.zeros((1, robot.n))
        ends = np.array([times[1] - times[0], times[-1] - times[-2]])[:, None]
        accelerations = np.concatenate(
            [moved.velocities[:1] / ends[0], moved.accelerations, (rest - moved.velocities[-1:]) / ends[1]]
        )
        findings += _rates(robot, "velocity", middles, moved.velocities, bounds.velocity)
        findings += _rates(robot, "acceleration", times, accelerations, bounds.acceleration)
    if scene is None:
        scene = (motion.scene_at(motion.duration) if isinstance(motion, Attempt) else None) or {}
    nearest, obstacle = smallest(robot, times, q, [(0.0, scene)], bodies=bodies, accuracy=accuracy)
    if nearest.bound < safe:
        found = nearest.distance if nearest.distance < safe else nearest.bound
        allowed = f"the smallest distance allowed is {safe:g} m"
        text = f"{nearest.body} comes within {found:.4g} m of {obstacle} at {nearest.time:.3f} s; {allowed}"
        if nearest.distance < 0:
            text = f"{nearest.body} is {-found:.4g} m inside {obstacle} at {nearest.time:.3f} s"
        findings.append(Finding("clearance", nearest.body, nearest.time, found, safe, text))
    return tuple(findings)


def _positions(robot: Robot, times: Array, q: Array, lower: Array, upper: Array) -> list[Finding]:
    findings = []
    for name in robot.joint_names:
        for i in range(*robot.q_slice(name).indices(robot.nq)):
            for limit, sign in ((lower[i], -1.0), (upper[i], 1.0)):
                beyond = sign * (q[:, i] - limit)
                at = int(beyond.argmax())
                if beyond[at] > AT_LIMIT:
                    unit = "rad" if robot.rotational[robot.v_slice(name)].all() else "m"
                    text = f"{name} is at {q[at, i]:.4g} {unit} at {times[at]:.3f} s; its limit is {limit:.4g} {unit}"
                    findings.append(Finding("position", name, float(times[at]), float(q[at, i]), float(limit), text))
    return findings


def _rates(robot: Robot, kind: str, times: Array, rates: Array, limit: Array) -> list[Finding]:
    """One finding for each joint that is faster than its limit, or accelerates more."""
    findings = []
    verb, per = ("moves at", "/s") if kind == "velocity" else ("accelerates at", "/s^2")
    for name in robot.joint_names:
        for j in range(*robot.v_slice(name).indices(robot.n)):
            size = np.abs(rates[:, j])
            at = int(size.argmax())
            if size[at] > limit[j] * (1 + ROUNDING):
                unit = ("rad" if robot.rotational[j] else "m") + per
                time, value = float(times[at]), float(size[at])
                text = f"{name} {verb} {value:.4g} {unit} at {time:.3f} s; its limit is {limit[j]:.4g} {unit}"
                findings.append(Finding(kind, name, time, value, float(limit[j]), text))
    return findings
