"""Robots that come with jtik, written from their makers' published figures.

Each is a module of tables: joints with their limits and speeds, solids around the links, a posture "home", and where
the figures come from. Frames and joints have the names that the maker's own descriptions give them; the frame "tip" is
the tool's.
"""

from __future__ import annotations

from collections.abc import Callable

from jtik.errors import UnknownNameError
from jtik.robot.gallery.description import Description
from jtik.robot.gallery.gen3 import gen3
from jtik.robot.gallery.iiwa14 import iiwa14
from jtik.robot.gallery.jaco2 import jaco2
from jtik.robot.gallery.panda import panda
from jtik.robot.gallery.universal import ur5, ur5e
from jtik.robot.gallery.vehicles import planar10, vehicle3, vehicle_panda
from jtik.robot.gallery.xarm7 import xarm7

__all__ = ["Description", "describe", "names"]

_BUILDERS: tuple[Callable[[], Description], ...] = (
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


def describe(name: str) -> Description:
    """The tables of a robot, with its summary and the source of its figures.

    Raises:
        UnknownNameError: when there is no such robot; it suggests the closest name.
    """
    if name not in _ROBOTS:
        raise UnknownNameError("built-in robot", name, _ROBOTS)
    return _ROBOTS[name]()
