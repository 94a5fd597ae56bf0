"""Robots from files: URDF, MJCF and compiled MuJoCo models, all read through MuJoCo."""

from jtik.robot.loaders.description import Description
from jtik.robot.loaders.load import load_mjcf, load_mujoco, load_urdf

__all__ = ["Description", "load_mjcf", "load_mujoco", "load_urdf"]
