"""One robot in a scene of viser: nodes at its frames, with meshes, solids or links."""

from __future__ import annotations

from typing import Any

import numpy as np

from jtik.errors import RobotFileError
from jtik.plotting.body import THICKNESS, Poses, reach
from jtik.plotting.surfaces import Surface, along, capsule, surface
from jtik.robot import Robot
from jtik.types import Array

SHOWS = ("meshes", "shapes", "links")
"""What can be shown of a robot; each is replaced by the next where the robot has none."""

ROUNDING = 1e-9
"""Change of a link's length [m] that is rounding."""


def quaternion_of(rotation: Array) -> Array:
    """The quaternion (w, x, y, z) of a rotation (3, 3)."""
    from viser.transforms import SO3

    return np.asarray(SO3.from_matrix(rotation).wxyz)


class ArmNodes:
    """The nodes of one robot.

    Args:
        scene: viser's scene.
        path: name of its root node.
        robot: the robot.
        color: red, green and blue, 0 to 255.
        show: one of `SHOWS`.
        axes: whether the axes of the tip are shown.

    Attributes:
        frames: the nodes of its frames, by name of the frame.
        shown: which of `SHOWS` is shown.
    """

    def __init__(
        self, scene: Any, path: str, robot: Robot, color: tuple[int, int, int], show: str, *, axes: bool
    ) -> None:
        self._scene, self._path, self._robot = scene, path, robot
        self._color = color
        self._poses = Poses(robot)
        self.root = scene.add_frame(path, show_axes=False)
        surfaces, length = _surfaces(robot, show), reach(robot)
        self.shown = next(iter(surfaces))
        self.frames: dict[str, Any] = {}
        for frame in self._poses.frames:
            self.frames[frame] = scene.add_frame(
                f"{path}/{_escaped(frame)}",
                show_axes=axes and frame == robot.tip,
                axes_length=0.08 * length,
                axes_radius=0.004 * length,
            )
        for k, (frame, each) in enumerate(surfaces[self.shown]):
            self._add(f"{path}/{_escaped(frame)}/{k}", each)
        self.links: list[tuple[str, str, Any]] = []
        self._lengths: list[float] = []
        if self.shown == "links":
            self._radius = THICKNESS * length
            for k, (inner, outer) in enumerate(robot.segments):
                self.links.append((inner, outer, self._add(f"{path}/links/{k}", self._link(1.0))))
                self._lengths.append(1.0)

    def _add(self, name: str, each: Surface) -> Any:
        vertices, faces = each.vertices.astype(np.float32), each.faces.astype(np.uint32)
        return self._scene.add_mesh_simple(name, vertices, faces, flat_shading=not each.smooth, color=self._color)

    def _link(self, length: float) -> Surface:
        return capsule(np.zeros(3), np.array([0.0, 0.0, length]), self._radius)

    def move(self, q: Array) -> None:
        """Move the nodes to a configuration (nq,)."""
        poses = self._poses(q)
        for frame, node in self.frames.items():
            node.wxyz, node.position = quaternion_of(poses[frame][:3, :3]), poses[frame][:3, 3]
        for k, (inner, outer, node) in enumerate(self.links):
            start, end = poses[inner][:3, 3], poses[outer][:3, 3]
            length = float(np.linalg.norm(end - start))
            if abs(length - self._lengths[k]) > ROUNDING:
                node.vertices, self._lengths[k] = self._link(length).vertices.astype(np.float32), length
            node.wxyz, node.position = quaternion_of(along(start, end)), start

    @property
    def visible(self) -> bool:
        """Whether it is shown."""
        return bool(self.root.visible)

    @visible.setter
    def visible(self, value: bool) -> None:
        self.root.visible = value

    def remove(self) -> None:
        """Remove all of its nodes."""
        self.root.remove()


def _surfaces(robot: Robot, show: str) -> dict[str, list[tuple[str, Surface]]]:
    """The surfaces on the frames, by what is shown; a frame whose meshes cannot be read has its solids."""
    if show == "meshes":
        found: list[tuple[str, Surface]] = []
        read = False
        for frame in robot.frame_names:
            try:
                own = [Surface(*mesh.triangles(), smooth=False) for mesh in robot.meshes.get(frame, ())]
            except RobotFileError:
                own = []
            read = read or bool(own)
            found += [(frame, each) for each in own or map(surface, robot.shapes.get(frame, ()))]
        if read:
            return {"meshes": found}
    solids = [(frame, surface(each)) for frame, own in robot.shapes.items() for each in own]
    return {"shapes": solids} if solids and show != "links" else {"links": []}


def _escaped(frame: str) -> str:
    """The name of a frame without what separates nodes."""
    return frame.replace("/", "|") or "frame"
