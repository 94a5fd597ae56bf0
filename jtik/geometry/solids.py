"""Solids in the workspace and on the links of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, finite_array, non_negative_number, positive_number
from jtik.errors import ArgumentError
from jtik.types import Array


class Solid:
    """Base of the solids: in the workspace, or on a link of a robot in the coordinates of its frame."""


@dataclass(frozen=True, init=False, eq=False)
class Ball(Solid):
    """Base of `Point`, `Circle` and `Sphere`: all points within a radius of a centre.

    Attributes:
        center: centre (2,) in the plane or (3,) in space [m].
        radius: non-negative radius [m]; 0 is a point.
    """

    center: Array
    radius: float

    dimensions: ClassVar[tuple[int, ...]] = (2, 3)

    def __init__(self, center: ArrayLike, radius: float = 0.0) -> None:
        shapes = [(size,) for size in self.dimensions]
        accepted = f"finite coordinates [m] of shape {' or '.join(map(str, shapes))}"
        object.__setattr__(self, "center", _read_only(array_of("center", center, shapes, accepted)))
        length = non_negative_number("radius", radius, "a non-negative finite length [m]")
        object.__setattr__(self, "radius", length)

    def __repr__(self) -> str:
        return f"{type(self).__name__}(center={tuple(self.center.tolist())}, radius={self.radius})"


class Point(Ball):
    """A point obstacle, in the plane or in space.

    Args:
        center: position (2,) or (3,) [m].

    Raises:
        ArgumentError: when the position is not finite or has another shape.

    Source: Das, Slotine and Sheridan 1988.
    """

    def __init__(self, center: ArrayLike) -> None:
        super().__init__(center, 0.0)


class Circle(Ball):
    """A disc in the plane of a planar robot.

    Args:
        center: centre (2,) [m].
        radius: non-negative radius [m].

    Raises:
        ArgumentError: when a number is not finite, the radius is negative, or the centre has another shape.
    """

    dimensions = (2,)


class Sphere(Ball):
    """A ball in space.

    Args:
        center: centre (3,) [m].
        radius: non-negative radius [m].

    Raises:
        ArgumentError: when a number is not finite, the radius is negative, or the centre has another shape.
    """

    dimensions = (3,)


@dataclass(frozen=True, eq=False)
class _Rounded(Solid):
    """Base of the solids around a segment.

    Attributes:
        start: start of the segment, (3,) [m].
        end: end of the segment, (3,) [m].
        radius: positive radius [m].
    """

    start: Array
    end: Array
    radius: float

    def __post_init__(self) -> None:
        for name in ("start", "end"):
            object.__setattr__(self, name, _read_only(finite_array(name, getattr(self, name), (3,))))
        object.__setattr__(self, "radius", positive_number("radius", self.radius, "a positive length [m]"))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.start, self.end, self.radius), ()


class Capsule(_Rounded):
    """All points within a radius of a segment.

    Args:
        start: start of the segment, (3,) [m].
        end: end of the segment, (3,) [m].
        radius: positive radius [m].

    Raises:
        ArgumentError: when a number is not finite, the radius is not positive, or an end has another shape.
    """


class Cylinder(_Rounded):
    """A cylinder with flat ends.

    Args:
        start: start of its axis, (3,) [m].
        end: end of its axis, (3,) [m].
        radius: positive radius [m].

    Raises:
        ArgumentError: when a number is not finite, the radius is not positive, or an end has another shape.
    """


@dataclass(frozen=True, eq=False)
class Box(Solid):
    """A box.

    Attributes:
        pose: pose (4, 4) [m] of its centre, with axes along its edges.
        half: half of the length of each edge, (3,) [m].

    Raises:
        ArgumentError: when a number is not finite, a length is not positive, or an argument has another shape.
    """

    pose: Array
    half: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", _read_only(finite_array("pose", self.pose, (4, 4))))
        half = finite_array("half", self.half, (3,))
        if half.min() <= 0:
            raise ArgumentError("half", half.tolist(), "three positive lengths [m]")
        object.__setattr__(self, "half", _read_only(half))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.pose, self.half), ()


def enclosing_segment(solid: Solid) -> tuple[Array, Array, float]:
    """The smallest capsule around a solid about its longest axis.

    Returns:
        The ends of its axis, (3,) [m] each, and its radius [m].

    Raises:
        ArgumentError: when ``solid`` is not a Sphere, Capsule, Cylinder or Box.
    """
    if isinstance(solid, _Rounded):
        return solid.start, solid.end, solid.radius
    if isinstance(solid, Ball):
        center = np.pad(solid.center, (0, 3 - len(solid.center)))
        return center, center, solid.radius
    if isinstance(solid, Box):
        longest = int(np.argmax(solid.half))
        axis = solid.half[longest] * solid.pose[:3, longest]
        radius = float(np.linalg.norm(np.delete(solid.half, longest)))
        return solid.pose[:3, 3] - axis, solid.pose[:3, 3] + axis, radius
    raise ArgumentError("solid", solid, "a jtik.Sphere, Capsule, Cylinder or Box")


def _read_only(array: Array) -> Array:
    array.flags.writeable = False
    return array
