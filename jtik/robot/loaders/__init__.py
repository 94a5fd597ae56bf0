"""Robots from files: URDF, MJCF and compiled MuJoCo models, all read through MuJoCo."""

import warnings
from typing import Any

from jtik.robot.loaders.load import load_mjcf, load_mujoco, load_urdf
from jtik.robot.loaders.robot_description import RobotDescription

__all__ = ["RobotDescription", "load_mjcf", "load_mujoco", "load_urdf"]


def __getattr__(name: str) -> Any:
    if name == "Description":
        text = "jtik.robot.loaders.Description is now jtik.robot.loaders.RobotDescription"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return RobotDescription
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
