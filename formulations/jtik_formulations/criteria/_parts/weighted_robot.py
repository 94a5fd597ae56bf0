"""What criteria on masses ask of a robot."""

from __future__ import annotations

from jtik.errors import ArgumentError
from jtik.robot import Robot


def require_masses(robot: Robot) -> None:
    """Raise ArgumentError, which names the links, where a joint moves no mass."""
    frames = robot.massless_frames
    if frames:
        raise ArgumentError(
            "robot",
            f"{robot!r}, without a mass on or after {', '.join(frames)}",
            "a mass beyond every joint; Robot.with_masses adds masses, Robot.subset locks joints",
        )
