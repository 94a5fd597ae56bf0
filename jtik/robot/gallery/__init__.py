"""Robots that come with jtik, from the published figures of their makers.

Each module holds tables: joints with limits, speeds and torques, solids around the links, masses and inertias, a
configuration "home", and the sources of the figures. Frames and joints have the names of the maker's own description;
the frame "tip" is that of the tool.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

from jtik.errors import UnknownNameError
from jtik.robot.gallery.gallery_robot import GalleryRobot
from jtik.robot.gallery.gen3 import gen3
from jtik.robot.gallery.iiwa14 import iiwa14
from jtik.robot.gallery.jaco2 import jaco2
from jtik.robot.gallery.panda import panda
from jtik.robot.gallery.universal import ur5, ur5e
from jtik.robot.gallery.vehicles import planar10, vehicle3, vehicle_panda
from jtik.robot.gallery.xarm7 import xarm7

__all__ = ["GalleryRobot", "describe", "names"]

_BUILDERS: tuple[Callable[[], GalleryRobot], ...] = (
    panda,
    ur5e,
    ur5,
    iiwa14,
    xarm7,
    gen3,
    jaco2,
    vehicle_panda,
    vehicle3,
    planar10,
)
_ROBOTS = {build.__name__: build for build in _BUILDERS}


def names() -> tuple[str, ...]:
    """The names that `Robot.builtin` accepts."""
    return tuple(_ROBOTS)


def describe(name: str) -> GalleryRobot:
    """The tables of a robot, with its summary and the source of its figures.

    Args:
        name: name of the robot, such as "panda".

    Raises:
        UnknownNameError: when there is no such robot; it suggests the closest name.
    """
    if name not in _ROBOTS:
        raise UnknownNameError("built-in robot", name, _ROBOTS)
    return _ROBOTS[name]()


def __getattr__(name: str) -> Any:
    if name == "Description":
        text = "jtik.robot.gallery.Description is now jtik.robot.gallery.GalleryRobot"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return GalleryRobot
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
