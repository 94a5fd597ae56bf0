"""Solids in the workspace and on the links of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from jtik.arguments import array_of, finite_array, non_negative_number, number, positive_number
from jtik.constructors import Constructed, lists_arguments
from jtik.errors import ArgumentError
from jtik.types import Array


class Solid(metaclass=Constructed):
    """Base of the solids: in the workspace, or on a link of a robot in the coordinates of its frame."""

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        raise NotImplementedError

    def __repr__(self) -> str:
        values = (f"{name}={np.asarray(value).tolist()}" for name, value in vars(self).items() if name[0] != "_")
        return f"{type(self).__name__}({', '.join(values)})"


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
        object.__setattr__(self, "center", read_only(array_of("center", center, shapes, accepted)))
        length = non_negative_number("radius", radius, "a non-negative finite length [m]")
        object.__setattr__(self, "radius", length)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return len(self.center)

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

    Example:
        >>> ObstacleAvoidance([jtik.Circle(center=(4.0, 2.0), radius=0.6)], bodies="links").name
        'obstacle_avoidance'
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


@dataclass(frozen=True, eq=False, repr=False)
class _Rounded(Solid):
    """Base of the solids around a segment.

    Attributes:
        start: start of the segment [m].
        end: end of the segment, of the same shape [m].
        radius: positive radius [m].
    """

    start: Array
    end: Array
    radius: float

    dimensions: ClassVar[tuple[int, ...]] = (3,)

    def __post_init__(self) -> None:
        shapes = [(size,) for size in self.dimensions]
        accepted = f"finite coordinates [m] of shape {' or '.join(map(str, shapes))}"
        start = array_of("start", self.start, shapes, accepted)
        object.__setattr__(self, "start", read_only(start))
        object.__setattr__(self, "end", read_only(finite_array("end", self.end, start.shape)))
        object.__setattr__(self, "radius", positive_number("radius", self.radius, "a positive length [m]"))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.start, self.end, self.radius), ()

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return len(self.start)


class Capsule(_Rounded):
    """All points within a radius of a segment, in the plane or in space.

    Args:
        start: start of the segment, (2,) or (3,) [m].
        end: end of the segment, of the same shape [m]; where it is the start, the capsule is a ball.
        radius: positive radius [m].

    Raises:
        ArgumentError: when a number is not finite, the radius is not positive, or an end has another shape.
    """

    dimensions = (2, 3)


class Cylinder(_Rounded):
    """A cylinder with flat ends.

    Args:
        start: start of its axis, (3,) [m].
        end: end of its axis, (3,) [m].
        radius: positive radius [m].

    Raises:
        ArgumentError: when a number is not finite, the radius is not positive, an end has another shape, or both ends
            are the same point.
    """

    def __post_init__(self) -> None:
        super().__post_init__()
        if not np.any(self.start != self.end):
            raise ArgumentError("end", self.end.tolist(), "another point than the start: its axis is between them")


@dataclass(frozen=True, eq=False, repr=False)
class Box(Solid):
    """A box in space, or a rectangle in the plane, in any orientation.

    `Box.at` makes one from its centre, half the lengths of its edges, and its rotation.

    Attributes:
        pose: pose of its centre, with axes along its edges, (4, 4) in space or (3, 3) in the plane [m].
        half: half of the length of each edge, (3,) in space or (2,) in the plane [m].

    Raises:
        ArgumentError: when a number is not finite, a length is not positive, the pose has no rotation, or an argument
            has another shape.

    Example:
        >>> table = jtik.Box.at([0.6, 0.0, -0.05], [0.4, 0.8, 0.05])  # centre, half sizes [m]
    """

    pose: Array
    half: Array

    _rotation: ClassVar[float | Array | None] = None  # the numbers that `at` was given, so that a copy has the same

    def __post_init__(self) -> None:
        half = array_of("half", self.half, [(3,), (2,)], "three positive lengths [m], or two in the plane")
        if half.min() <= 0:
            raise ArgumentError("half", half.tolist(), f"{len(half)} positive lengths [m]")
        object.__setattr__(self, "half", read_only(half))
        size = len(half) + 1
        pose = finite_array("pose", self.pose, (size, size), f"a pose ({size}, {size}) [m]")
        rotation = pose[:-1, :-1]
        if np.abs(rotation @ rotation.T - np.eye(size - 1)).max() > ROTATION_TOLERANCE or np.linalg.det(rotation) < 0:
            raise ArgumentError("pose", rotation.tolist(), "a pose whose upper left block is a rotation")
        object.__setattr__(self, "pose", read_only(pose))

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(_turned, type(self), self.pose, self.half, self.rotation), ()

    @classmethod
    @lists_arguments
    def at(cls, center: ArrayLike, half: ArrayLike, rotation: ArrayLike | None = None) -> Box:
        """The box of a centre, half the lengths of its edges, and a rotation.

        Args:
            center: its centre, (3,) or (2,) [m].
            half: half of the length of each edge, of the same shape [m].
            rotation: in space a quaternion (w, x, y, z), in the plane an angle [rad]; none by default.

        Raises:
            ArgumentError: when a number is not finite, a length is not positive, the quaternion is zero, or an
                argument has another shape.
        """
        middle = array_of("center", center, [(3,), (2,)], "finite coordinates [m] of shape (3,) or (2,)")
        size = len(middle)
        pose = np.eye(size + 1)
        pose[:size, size] = middle
        edges = finite_array("half", half, (size,))
        if rotation is None:
            return cls(pose, edges)
        turned: float | Array = _angle(rotation) if size == 2 else _unit(rotation)
        pose[:size, :size] = _planar(turned) if isinstance(turned, float) else _spatial(turned)
        return _turned(cls, pose, edges, turned)

    @property
    def dimension(self) -> int:
        """2 in the plane, 3 in space."""
        return len(self.half)

    @property
    def center(self) -> Array:
        """Its centre [m]."""
        return self.pose[:-1, -1]

    @property
    def rotation(self) -> float | Array:
        """The angle [rad] in the plane; in space the quaternion (w, x, y, z)."""
        if self._rotation is not None:
            return self._rotation
        R = self.pose[:-1, :-1]
        return float(np.arctan2(R[1, 0], R[0, 0])) if self.dimension == 2 else _quaternion(R)


ROTATION_TOLERANCE = 1e-6
"""Largest entry of R R' - I up to which a matrix counts as a rotation."""

ROUNDING = 1e-15
"""Difference from 1 up to which the norm of a quaternion counts as 1."""


def read_only(array: Array) -> Array:
    """The array, which can no longer be changed."""
    array.flags.writeable = False
    return array


def _turned(kind: type[Box], pose: Array, half: Array, rotation: float | Array) -> Box:
    """The box of a pose whose rotation has been made from these numbers."""
    box = kind(pose, half)
    object.__setattr__(box, "_rotation", rotation if isinstance(rotation, float) else read_only(np.array(rotation)))
    return box


def _angle(rotation: ArrayLike) -> float:
    """An angle in (-pi, pi] [rad]."""
    angle = number("rotation", rotation, "an angle [rad]")
    return angle if abs(angle) <= np.pi else float(np.arctan2(np.sin(angle), np.cos(angle)))


def _unit(rotation: ArrayLike) -> Array:
    """A quaternion of norm 1 with w >= 0; one that has norm 1 but for rounding keeps its numbers."""
    given = finite_array("rotation", rotation, (4,), "a quaternion (w, x, y, z)")
    largest = float(np.abs(given).max())
    if not largest > 0:
        raise ArgumentError("rotation", given.tolist(), "a quaternion (w, x, y, z) that is not zero")
    if abs(np.linalg.norm(given) - 1) > ROUNDING:
        given = given / largest
        given = given / np.linalg.norm(given)
    return given if given[0] >= 0 else -given


def _planar(angle: float) -> Array:
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])


def _spatial(quaternion: Array) -> Array:
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def _quaternion(R: Array) -> Array:
    """(w, x, y, z) of a rotation matrix: the eigenvector of the largest eigenvalue, with w >= 0."""
    xx, xy, xz, yx, yy, yz, zx, zy, zz = R.ravel()
    symmetric = np.array(
        [
            [xx + yy + zz, zy - yz, xz - zx, yx - xy],
            [zy - yz, xx - yy - zz, xy + yx, xz + zx],
            [xz - zx, xy + yx, yy - xx - zz, yz + zy],
            [yx - xy, xz + zx, yz + zy, zz - xx - yy],
        ]
    )
    largest = np.linalg.eigh(symmetric)[1][:, -1]
    return np.asarray(largest if largest[0] >= 0 else -largest)
