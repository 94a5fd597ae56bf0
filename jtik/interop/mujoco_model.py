"""A robot as a MuJoCo model, and the correspondence of their configurations and velocities."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import mujoco
import numpy as np

from jtik.arguments import instance, instances
from jtik.errors import ArgumentError
from jtik.geometry import Ball, Box, Capsule, Cylinder, HalfSpace, Solid
from jtik.interop.renamed import renamed_classes
from jtik.robot import Joint, JointType, Robot
from jtik.robot.loaders.compiled import ModelReader
from jtik.types import Array

WORLD = "world"
"""MuJoCo's name of the root frame."""

NEGLIGIBLE = 1e-9
"""Mass [kg] and inertia [kg m^2] of a frame that has none: MuJoCo needs them for moving bodies."""

_TYPES = {
    JointType.REVOLUTE: mujoco.mjtJoint.mjJNT_HINGE,
    JointType.PRISMATIC: mujoco.mjtJoint.mjJNT_SLIDE,
    JointType.BALL: mujoco.mjtJoint.mjJNT_BALL,
    JointType.FREE: mujoco.mjtJoint.mjJNT_FREE,
}


def to_mujoco(robot: Robot, *, obstacles: Iterable[Solid] = ()) -> Any:
    """The robot as a ``mujoco.MjModel``; every frame becomes a body, and every joint a joint, with the same name.

    Limits, masses with their inertias, the solids of the frames (as geoms "FRAME solid0" ...) and mimic joints (as
    equalities of joints) are kept. qpos is in MuJoCo's order, see `MujocoCorrespondence`.

    Args:
        robot: the robot.
        obstacles: solids in the base frame; a circle becomes a sphere. Each is the geom of its own mocap body
            "obstacle0" ...: mink ignores geoms of the world body as obstacles for links that are mounted on it.

    Raises:
        ArgumentError: for a free joint that is not on the base, or a frame "world" that is not the base.
    """
    instance("robot", robot, Robot, "a jtik.Robot")
    field = instances("obstacles", obstacles, Solid, f"a list, each {ACCEPTED}")
    spec = mujoco.MjSpec()
    spec.modelname = robot.name
    spec.compiler.fusestatic = False
    spec.compiler.degree = False
    bodies = {robot.base: spec.worldbody}
    if robot.base != WORLD:
        if WORLD in robot.frame_names:
            raise ArgumentError("robot", f"{robot!r} with a frame 'world'", "that name for the base only")
        spec.worldbody.add_body(name=robot.base)
    for joint in robot.joints:
        pose = joint.origin
        body = bodies[joint.parent].add_body(name=joint.child, pos=pose[:3, 3], quat=_quaternion(pose))
        bodies[joint.child] = body
        _add_joint(body, joint, robot)
        _add_mass(body, joint.child, robot)
    for joint in robot.joints:
        if joint.mimic is not None:
            follow = spec.add_equality(name1=joint.name, name2=joint.mimic.joint)
            follow.type, follow.objtype = mujoco.mjtEq.mjEQ_JOINT, mujoco.mjtObj.mjOBJ_JOINT
            follow.data[:5] = [joint.mimic.offset, joint.mimic.multiplier, 0, 0, 0]
    for frame, solids in robot.shapes.items():
        for i, solid in enumerate(solids):
            _add_geom(bodies[frame], f"{frame} solid{i}", solid)
    for i, solid in enumerate(field):
        body = spec.worldbody.add_body(name=f"obstacle{i}", mocap=True)
        _add_geom(body, f"obstacle{i}", solid)
    return spec.compile()


class MujocoCorrespondence:
    """The correspondence of a robot's joints with those of a MuJoCo model, by their names.

    The robot may be read from the model, or the model may be made of the robot, or of a robot of which it is a subset.
    Joints of the model that the robot does not have keep the positions ``rest``.

    Args:
        robot: the robot.
        model: the ``mujoco.MjModel``.
        rest: qpos (model.nq,) of the model's other joints; ``model.qpos0`` by default.

    Attributes:
        leads: the matrix (model.nv, n) from a velocity of the robot to that of the model, zero for mimic joints.
        moves: the matrix (model.nv, n) from a velocity of the robot to that of the model, mimic joints included.
        follows: rows (k, model.nv) that are zero for velocities at which mimic joints follow their leaders.

    Raises:
        ArgumentError: when the model does not have a joint of the robot, or one of another type.
    """

    def __init__(self, robot: Robot, model: Any, *, rest: Any = None) -> None:
        numbers = _joints_of(model)
        self._robot, self._rest = robot, np.array(model.qpos0 if rest is None else rest, dtype=float)
        self._q = np.zeros(robot.nq, dtype=np.intp)
        self._followers: list[tuple[int, int, float, float]] = []
        self.leads = np.zeros((model.nv, robot.n))
        extra, rows = np.zeros((model.nv, robot.n)), []
        for joint in robot.joints:
            if not joint.is_moving:
                continue
            number = numbers.get(joint.name, -1)
            if number < 0 or model.jnt_type[number] != _TYPES[joint.type]:
                kind = f"a {joint.type.value} joint {joint.name!r}"
                raise ArgumentError("model", f"one without {kind}", f"a model with the joints of {robot!r}")
            at, dof = int(model.jnt_qposadr[number]), int(model.jnt_dofadr[number])
            mine, own = robot.q_slice(joint.name), robot.v_slice(joint.name)
            if joint.mimic is None:
                self._q[mine] = np.arange(at, at + joint.type.nq)
                self.leads[dof : dof + joint.type.nv, own] = np.eye(joint.type.nv)
            else:
                self._followers.append((at, mine.start, joint.mimic.multiplier, joint.mimic.offset))
                extra[dof, own] = joint.mimic.multiplier
                rows.append(np.eye(model.nv)[dof])
        self.moves = self.leads + extra
        chosen = np.array(rows).reshape(len(rows), model.nv)
        self.follows = chosen - chosen @ extra @ self.leads.T

    def qpos(self, q: Array) -> Array:
        """The model's configuration (model.nq,) for the robot's (nq,).

        Args:
            q: configuration of the robot.
        """
        qpos = self._rest.copy()
        qpos[self._q] = q
        for at, leader, multiplier, offset in self._followers:
            qpos[at] = multiplier * q[leader] + offset
        return qpos

    def q(self, qpos: Array) -> Array:
        """The robot's configuration (nq,) for the model's (model.nq,).

        Args:
            qpos: configuration of the model.
        """
        return np.array(qpos, dtype=float)[self._q]

    def velocity(self, v: Array) -> Array:
        """The robot's velocity or displacement (n,) for the model's (model.nv,).

        Args:
            v: velocity or displacement of the model.
        """
        part: Array = self.leads.T @ v
        return part


def _joints_of(model: Any) -> dict[str, int]:
    """The number of each joint by its name; joints without a name have the one that `ModelReader` gives them."""
    joints = [joint for joint in ModelReader(model, "model").read().joints if joint.is_moving]
    return {joint.name: number for number, joint in enumerate(joints)}


def _add_joint(body: Any, joint: Joint, robot: Robot) -> None:
    if not joint.is_moving:
        return
    if joint.type is JointType.FREE and (joint.parent != robot.base or not np.array_equal(joint.origin, np.eye(4))):
        raise ArgumentError(
            "robot", f"free joint {joint.name!r} on {joint.parent!r}", "free joints at the base's origin"
        )
    made = body.add_joint(name=joint.name, type=_TYPES[joint.type])
    if not joint.type.is_scalar:
        return
    made.axis = joint.axis
    if np.isfinite(joint.lower) or np.isfinite(joint.upper):
        made.limited = True
        low, high = np.clip([joint.lower, joint.upper], -UNLIMITED, UNLIMITED)
        made.range = low, max(high, low + MINIMUM_RANGE)
    if np.isfinite(joint.effort_limit):
        made.actfrclimited = True
        made.actfrcrange = -joint.effort_limit, joint.effort_limit


ACCEPTED = "a jtik.Point, Circle or Sphere, or a Capsule, Cylinder, Box or HalfSpace in space"
"""What becomes a geom, for errors."""

MINIMUM_RANGE = 1e-9
"""Range [rad] or [m] of a joint whose limits are equal: MuJoCo needs a positive range."""

UNLIMITED = 1e6
"""Limit [rad] or [m] on the unlimited side of a joint with one limit: MuJoCo has both limits or none."""


def _add_mass(body: Any, frame: str, robot: Robot) -> None:
    found = robot.masses.get(frame)
    body.explicitinertial = True
    body.mass = max(found.mass if found else 0.0, NEGLIGIBLE)
    moments, axes = np.linalg.eigh(np.zeros((3, 3)) if found is None else found.inertia)
    if np.linalg.det(axes) < 0:
        axes[:, 0] = -axes[:, 0]
    moments = np.maximum(moments, NEGLIGIBLE)
    # MuJoCo refuses a largest moment above the sum of the others, which no body has: it gets those of a flat one
    moments[:2] += max(0.0, (moments[2] - moments[0] - moments[1]) / 2)
    body.inertia, body.iquat = moments, _quaternion(axes)
    body.ipos = found.center if found else np.zeros(3)


def _add_geom(body: Any, name: str, solid: Solid) -> None:
    kind = mujoco.mjtGeom
    if solid.dimension == 2 and not isinstance(solid, Ball):
        raise ArgumentError(name, solid, ACCEPTED)
    if isinstance(solid, Ball):
        center = np.pad(solid.center, (0, 3 - len(solid.center)))
        radius = max(solid.radius, NEGLIGIBLE)
        body.add_geom(name=name, type=kind.mjGEOM_SPHERE, size=[radius, 0, 0], pos=center)
    elif isinstance(solid, (Capsule, Cylinder)):
        shape = kind.mjGEOM_CAPSULE if isinstance(solid, Capsule) else kind.mjGEOM_CYLINDER
        ends = np.concatenate([solid.start, solid.end])
        if isinstance(solid, Capsule) and np.linalg.norm(solid.end - solid.start) <= NEGLIGIBLE:
            body.add_geom(name=name, type=kind.mjGEOM_SPHERE, size=[solid.radius, 0, 0], pos=solid.start)
        else:
            body.add_geom(name=name, type=shape, size=[solid.radius, 0, 0], fromto=ends)
    elif isinstance(solid, Box):
        pose = solid.pose
        body.add_geom(name=name, type=kind.mjGEOM_BOX, size=solid.half, pos=pose[:3, 3], quat=_quaternion(pose))
    elif isinstance(solid, HalfSpace):
        pose = np.eye(4)
        pose[:3, :3] = np.linalg.svd(solid.normal[None])[2].T[:, [1, 2, 0]]  # z along the normal or against it
        pose[:3, 2] = solid.normal
        pose[:3, 0] = np.cross(pose[:3, 1], pose[:3, 2])
        body.add_geom(name=name, type=kind.mjGEOM_PLANE, size=[0, 0, 1], pos=solid.point, quat=_quaternion(pose))
    else:
        raise ArgumentError(name, solid, ACCEPTED)


def _quaternion(pose: Array) -> Array:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(pose[:3, :3]).ravel())
    return quaternion


__getattr__ = renamed_classes(__name__, {"Correspondence": MujocoCorrespondence})
