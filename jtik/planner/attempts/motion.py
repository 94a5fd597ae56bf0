"""Speeds, accelerations and end effector positions of a sampled motion."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from jtik.arguments import instance
from jtik.errors import ArgumentError
from jtik.planner.attempts.attempt import Attempt
from jtik.robot import Robot
from jtik.study.path_metrics import displacements
from jtik.symbolic import function, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array


class Motion(NamedTuple):
    """A sampled motion and its differences; the joints move straight from one sample to the next.

    Attributes:
        times: time of each sample (k,) [s].
        steps: displacements between samples (k - 1, n) [rad] and [m].
        velocities: mean velocity between samples (k - 1, n) [rad/s] and [m/s].
        accelerations: change of the mean velocity over the time between the middles of the two intervals, (k - 2, n)
            [rad/s^2] and [m/s^2]; each belongs to an inner sample.
    """

    times: Array
    steps: Array
    velocities: Array
    accelerations: Array

    @classmethod
    def of(cls, robot: Robot, times: Array, configurations: Array) -> Motion:
        """The motion through configurations (k, nq) at times (k,)."""
        steps, durations = displacements(robot, configurations), np.diff(times)[:, None]
        velocities = steps / durations
        between = (durations[1:] + durations[:-1]) / 2
        return cls(times, steps, velocities, np.diff(velocities, axis=0) / between)

    @property
    def length(self) -> float:
        """Sum of the norms of the steps [rad] and [m]."""
        return float(np.linalg.norm(self.steps, axis=1).sum())

    @property
    def smoothness(self) -> float:
        """Root mean square of the norm of the acceleration [rad/s^2]; NaN below three samples."""
        if not len(self.accelerations):
            return float("nan")
        return float(np.sqrt((self.accelerations**2).sum(axis=1).mean()))

    @property
    def reversals(self) -> int:
        """How often a joint changes its direction; moves of less than 1e-6 of its largest step do not count."""
        total = 0
        for steps in self.steps.T:
            size = np.abs(steps).max(initial=0.0)
            signs = np.sign(steps[np.abs(steps) > 1e-6 * size])
            total += int((signs[1:] != signs[:-1]).sum())
        return total


def read_attempt(attempt: object, robot: object) -> Attempt:
    """The attempt. Raises ArgumentError for anything else, or one of another robot."""
    arm = instance("robot", robot, Robot, "a jtik.Robot")
    given = instance("attempt", attempt, Attempt, "an Attempt")
    if given.configurations.shape[1] != arm.nq:
        width = f"{given!r} with configurations of {given.configurations.shape[1]} numbers"
        raise ArgumentError("attempt", width, f"an attempt of {arm!r}")
    return given


def placements(robot: Robot, configurations: Array, *, frame: str | None, pose: bool) -> tuple[Array, Array]:
    """Positions of a frame (k, d) [m], and the Jacobians (k, m, n) of its position or of its pose.

    Args:
        robot: the robot.
        configurations: (k, nq).
        frame: name of the frame; the tip when None.
        pose: whether the Jacobian has the rows of the orientation, too.
    """
    q = symbol("q", robot.nq)
    d = robot.dimension
    J = robot.at(q).jacobian(robot.frame(frame))
    rows = [*range(d), *(range(3, 6) if d == 3 else (5,))] if pose else [*range(d)]
    evaluate = CompiledFunction(function("placement", [q], [robot.at(q).position(robot.frame(frame)), J[rows, :]]))
    results = [evaluate(each) for each in configurations]
    return np.array([position[:, 0] for position, _ in results]), np.array([jacobian for _, jacobian in results])
