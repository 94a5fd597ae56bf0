"""The robot as the planner shows it: poses of its frames, its bodies, and ranges for sliders."""

from __future__ import annotations

import math
from functools import cached_property
from typing import Any

import numpy as np

from jtik.geometry import enclosing_segment
from jtik.planner.session import rotations
from jtik.robot import JointType, Robot
from jtik.symbolic import function, horzcat, symbol
from jtik.symbolic.compile import CompiledFunction
from jtik.types import Array

THIN = 0.012
"""Radius of a link of the skeleton, as a share of the robot's reach."""

SLIDER = {JointType.REVOLUTE: math.pi, JointType.PRISMATIC: 1.0}
"""Half the range of a slider of a joint without limits [rad] or [m]."""


class Arm:
    """Poses and bodies of a robot.

    Args:
        robot: the robot, with only the joints that move.
        tip: frame of the end effector.

    Attributes:
        robot: the robot.
        tip: frame of the end effector.
    """

    def __init__(self, robot: Robot, tip: str) -> None:
        self.robot, self.tip = robot, tip
        q = symbol("q", robot.nq)
        kinematics = robot.at(q)
        poses = [kinematics.pose(frame)[:3, :] for frame in robot.frame_names]
        self._poses = CompiledFunction(function("poses", [q], [horzcat(*poses)]))

    def poses(self, q: Array) -> Array:
        """Poses of all frames in the order of ``robot.frame_names``: (k, 7), position [m] and quaternion (w, x, y, z).

        Args:
            q: configuration (nq,) [rad] and [m].
        """
        flat = self._poses(q)[0].reshape(3, -1, 4).transpose(1, 0, 2)
        found = np.concatenate([flat[:, :, 3], rotations.quaternions(flat[:, :, :3])], axis=1)
        found.flags.writeable = False
        return found

    def pose(self, q: Array, frame: str) -> tuple[Array, Array]:
        """Position (2,) or (3,) [m] and unit quaternion (w, x, y, z) of a frame."""
        pose = self.poses(q)[self.robot.frame_names.index(frame)]
        return pose[: self.robot.dimension].copy(), pose[3:].copy()

    @cached_property
    def reach(self) -> float:
        """Sum of the lengths of the skeleton's links at the home configuration [m]."""
        poses, names = self.poses(self.robot.home), self.robot.frame_names
        place = {name: poses[i, :3] for i, name in enumerate(names)}
        total = sum(float(np.linalg.norm(place[a] - place[b])) for a, b in self.robot.segments)
        return total or 1.0

    @cached_property
    def bodies(self) -> tuple[dict[str, Any], ...]:
        """Capsules to draw: frame, start (3,) and end (3,) in its coordinates, radius [m]; and what "kind" they are.

        The robot's own solids where it has any, else the links of its skeleton, which go from the origin of a frame to
        that of another: these have the frames ``frame`` and ``to``.
        """
        found = []
        for frame, solids in self.robot.shapes.items():
            for solid in solids:
                start, end, radius = enclosing_segment(solid)
                found.append(_body(frame, start, end, radius))
        if not found:
            origin = np.zeros(3)
            for inner, outer in self.robot.segments:
                found.append({**_body(inner, origin, origin, THIN * self.reach), "to": outer})
        return tuple(found)

    def description(self) -> dict[str, Any]:
        """What `Setup.robot` says."""
        robot = self.robot
        joints = []
        for joint in robot.independent_joints:
            entry: dict[str, Any] = {"name": joint.name, "type": joint.type.value, "scalar": joint.type in SLIDER}
            entry["frame"], entry["velocity"] = joint.child, robot.v_slice(joint.name).start
            if joint.type in SLIDER:
                lower, upper = _range(joint.lower, joint.upper, SLIDER[joint.type])
                limited = math.isfinite(joint.lower) or math.isfinite(joint.upper)
                entry |= {"index": robot.q_slice(joint.name).start, "lower": lower, "upper": upper, "limited": limited}
            joints.append(entry)
        links = [{"start": start, "end": end} for start, end in robot.segments]
        return {
            "name": robot.name,
            "dimension": robot.dimension,
            "nq": robot.nq,
            "n": robot.n,
            "tip": self.tip,
            "joints": joints,
            "bodies": self.bodies,
            "links": links,
            "reach": self.reach,
            "home": robot.home,
            "no_meshes": _no_meshes(robot),
        }


def _no_meshes(robot: Robot) -> str:
    """Why there are no meshes to draw, as a sentence; empty where there are files of some."""
    files = [mesh.file for own in robot.meshes.values() for mesh in own]
    if not files:
        return f"The description of {robot.name} names no mesh files that could be found."
    if any(file.is_file() for file in files):
        return ""
    return f"None of the {len(files)} mesh files of {robot.name} is found, such as {files[0]}."


def _body(frame: str, start: Array, end: Array, radius: float) -> dict[str, Any]:
    return {"frame": frame, "start": start.tolist(), "end": end.tolist(), "radius": float(radius)}


def _range(lower: float, upper: float, half: float) -> tuple[float, float]:
    """The ends of a slider."""
    if math.isfinite(lower) and math.isfinite(upper):
        return lower, upper
    if math.isfinite(lower):
        return lower, lower + 2 * half
    return (upper - 2 * half, upper) if math.isfinite(upper) else (-half, half)
