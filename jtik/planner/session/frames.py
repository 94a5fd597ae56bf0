"""What the planner publishes: immutable values that any thread may read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, Literal, NamedTuple

from jtik.types import Array

Mode = Literal["live", "playing", "scrubbing", "paused"]
"""Whether the arm follows the target, or an attempt is shown."""

Level = Literal["info", "warning", "error"]
"""How serious a message is."""


@dataclass(frozen=True, eq=False)
class Frame:
    """The arm at one moment. A new one is published only when something has moved. Arrays are read-only.

    Attributes:
        tick: number of the period in which it was made.
        time: time of the clock [s].
        q: configuration (nq,) [rad] and [m].
        position: position of the target (2,) or (3,) [m].
        orientation: orientation of the target, a unit quaternion (w, x, y, z).
        poses: poses of all frames of the robot, in the order of `Setup.frames`: (k, 7), position [m] and unit
            quaternion (w, x, y, z).
        mode: whether the arm follows the target, or an attempt is shown.
        recording: whether an attempt is recorded.
        shown: name and time [s] of the attempt that is shown; None in the mode "live".
    """

    tick: int
    time: float
    q: Array
    position: Array
    orientation: Array
    poses: Array
    mode: Mode = "live"
    recording: bool = False
    shown: tuple[str, float] | None = None


@dataclass(frozen=True)
class StatusLine:
    """The state of the planner in words and figures, ten times a second.

    Attributes:
        words: what the arm does, and why it does not reach the target where it does not.
        heartbeat: how many of these there were before.
        error: norm of the task error, [m] and [rad] together.
        V: the Lyapunov function of the task, half the sum of squares of the weighted error.
        H: weighted sum of the criteria.
        criteria: weighted value of each criterion by name.
        clearance: smallest distance of the joints and of the links to an obstacle [m]; empty without an obstacle.
        manipulability: square root of the determinant of J J', from the singular values of the weighted Jacobian.
        active_limits: names of the joints at a limit.
        violated: names of the bodies that are nearer to an obstacle than the clearance allows, or inside one.
        null_space: dimension of the null space of the task.
        step_time: time of the last step [s].
        rebuilding: whether another solver is being built.
        attempts: version of the list of attempts.
        late: periods that were left out so far because others took too long.
    """

    words: str
    heartbeat: int = 0
    error: float = 0.0
    V: float = 0.0
    H: float = 0.0
    criteria: Mapping[str, float] = field(default_factory=dict)
    clearance: Mapping[str, float] = field(default_factory=dict)
    manipulability: float = 0.0
    active_limits: tuple[str, ...] = ()
    violated: tuple[str, ...] = ()
    null_space: int = 0
    step_time: float = 0.0
    rebuilding: bool = False
    attempts: int = 0
    late: int = 0

    def to_json(self) -> dict[str, Any]:
        """Plain data; numbers that are not finite become None."""
        found: dict[str, Any] = plain(asdict(self))
        return found


class Message(NamedTuple):
    """A message for the operator.

    Attributes:
        number: how many there were before.
        level: how serious it is.
        text: a sentence.
    """

    number: int
    level: Level
    text: str


@dataclass(frozen=True)
class Setup:
    """What the planner plans for; it stays as it is.

    Attributes:
        robot: name, dimension, nq, joints, bodies, links and reach [m], of `jtik.planner.session.arm.Arm.description`.
        frames: names of the frames, in the order of `Frame.poses`.
        strategies: name, summary and options of each strategy that can be chosen.
        criteria: name and summary of each criterion that can be chosen.
        task: kind of the first task and frame of the end effector.
        dt: period [s].
    """

    robot: Mapping[str, Any]
    frames: tuple[str, ...]
    strategies: tuple[Mapping[str, Any], ...]
    criteria: tuple[Mapping[str, Any], ...]
    task: Mapping[str, Any]
    dt: float

    def to_json(self) -> dict[str, Any]:
        """Plain data; numbers that are not finite become None."""
        found: dict[str, Any] = plain(asdict(self))
        return found


@dataclass(frozen=True)
class Settings:
    """What the planner is set to; another one is published, at most ten times a second, when something has changed.

    Attributes:
        version: grows with every change.
        tasks: name, kind and frame of each task, with the position of its target [m] where it is held.
        strategy: name and options of the strategy.
        criteria: names of the criteria.
        joint_weights: weights of the velocity entries (n,).
        scene: the obstacles by name, as plain data with the gain of each.
        preferred: preferred posture (nq,) [rad] and [m].
        gains: values of the live parameters by name.
        limits: whether the position limits hold.
        clearance: whether the clearance holds.
        safe: its smallest distance [m].
        target_speed: largest speed [m/s] and angular speed [rad/s] of the target.
        capacity: number of obstacles of each kind for which no solver has to be built.
        rebuilding: whether another solver is being built; the settings are then those of the one that is to come.
    """

    version: int
    tasks: tuple[Mapping[str, Any], ...]
    strategy: Mapping[str, Any]
    criteria: tuple[str, ...]
    joint_weights: tuple[float, ...]
    scene: Mapping[str, Any]
    preferred: tuple[float, ...]
    gains: Mapping[str, Any]
    limits: bool
    clearance: bool
    safe: float
    target_speed: tuple[float, float]
    capacity: Mapping[str, int]
    rebuilding: bool

    def to_json(self) -> dict[str, Any]:
        """Plain data; numbers that are not finite become None."""
        found: dict[str, Any] = plain(asdict(self))
        return found


def plain(value: Any) -> Any:
    """Plain data of what is published: lists for tuples and arrays, None for numbers that are not finite.

    Args:
        value: the value.
    """
    if isinstance(value, Mapping):
        return {str(key): plain(each) for key, each in value.items()}
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, (tuple, list)):
        return [plain(each) for each in value]
    if isinstance(value, float):
        return value if abs(value) < float("inf") else None
    return value
