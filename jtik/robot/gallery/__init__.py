"""Robots that come with jtik, from the published figures of their makers.

Each module holds tables: joints with limits, speeds and torques, solids around the links, masses and inertias, a
configuration "home", and the sources of the figures. Frames and joints have the names of the maker's own description;
the frame "tip" is that of the tool.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from typing import Any, cast

from jtik.errors import UnknownNameError
from jtik.robot.gallery.gallery_robot import GalleryRobot

__all__ = ["GalleryRobot", "describe", "names"]

_MODULES = {
    "panda": "panda",
    "ur5e": "universal",
    "ur5": "universal",
    "iiwa14": "iiwa14",
    "xarm7": "xarm7",
    "gen3": "gen3",
    "jaco2": "jaco2",
    "vehicle_panda": "vehicles",
    "vehicle3": "vehicles",
    "planar10": "vehicles",
}
"""The module that has the tables of each robot, in a function of the robot's name."""


def names() -> tuple[str, ...]:
    """The names that `Robot.builtin` accepts."""
    return tuple(_MODULES)


def describe(name: str) -> GalleryRobot:
    """The tables of a robot, with its summary and the source of its figures.

    Args:
        name: name of the robot, such as "panda".

    Raises:
        UnknownNameError: when there is no such robot; it suggests the closest name.
    """
    if name not in _MODULES:
        raise UnknownNameError("built-in robot", name, _MODULES)
    module = import_module(f"jtik.robot.gallery.{_MODULES[name]}")
    return cast(GalleryRobot, getattr(module, name)())


def __getattr__(name: str) -> Any:
    if name == "Description":
        text = "jtik.robot.gallery.Description is now jtik.robot.gallery.GalleryRobot"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        return GalleryRobot
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
