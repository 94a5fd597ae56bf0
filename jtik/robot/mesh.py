"""Meshes of a robot's links: where their files are, kept as plain data and read only when they are drawn."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from jtik.arguments import finite_array, mapping, path, several
from jtik.constructors import Constructed
from jtik.errors import ArgumentError, UnknownNameError
from jtik.robot.tree import frozen
from jtik.types import Array


@dataclass(frozen=True, eq=False)
class Mesh(metaclass=Constructed):
    """A mesh on a frame, for pictures. Its file is not read before it is drawn, and may be missing then.

    Attributes:
        file: path of its file.
        pose: pose (4, 4) [m] of the mesh in its frame.
        scale: factor of each coordinate of the file, (3,).

    Raises:
        ArgumentError: when the path, the pose or the scale cannot be used.
    """

    file: Path
    pose: Array = field(default_factory=lambda: np.eye(4))
    scale: Array = field(default_factory=lambda: np.ones(3))

    def __post_init__(self) -> None:
        object.__setattr__(self, "file", path("Mesh.file", self.file))
        object.__setattr__(self, "pose", frozen(finite_array("Mesh.pose", self.pose, (4, 4))))
        object.__setattr__(self, "scale", frozen(finite_array("Mesh.scale", self.scale, (3,))))

    def triangles(self) -> tuple[Array, NDArray[np.int64]]:
        """Its corners (n, 3) [m] in the frame, and the corners of each triangle (m, 3).

        STL, OBJ and MSH files are read by MuJoCo, COLLADA (.dae) files by jtik, without colours.

        Raises:
            RobotFileError: when the file is missing or cannot be read.
        """
        from jtik.robot.loaders.triangles import read_triangles

        vertices, faces = read_triangles(self.file, self.scale)
        return vertices @ self.pose[:3, :3].T + self.pose[:3, 3], faces

    def __reduce__(self) -> tuple[Any, ...]:
        return partial(type(self), self.file, self.pose, self.scale), ()


class Meshes(dict[str, tuple[Mesh, ...]]):
    """Meshes by frame. They are for pictures: nothing that is computed depends on them, nor does a fingerprint."""


def meshes_on(frames: Sequence[str], meshes: Mapping[str, Sequence[Mesh]] | None) -> Meshes:
    """The meshes by frame; raises UnknownNameError for a frame that does not exist."""
    accepted = "a list, each a jtik.robot.Mesh"
    named = {} if meshes is None else mapping("meshes", meshes, f"a dict from frame to {accepted}; or None")
    found = {frame: several(f"meshes[{frame!r}]", several_meshes, accepted) for frame, several_meshes in named.items()}
    for frame, own in found.items():
        if frame not in frames:
            raise UnknownNameError("frame of a mesh", frame, frames)
        for mesh in own:
            if not isinstance(mesh, Mesh):
                raise ArgumentError(f"meshes[{frame!r}]", mesh, accepted)
    return Meshes({frame: own for frame, own in found.items() if own})
