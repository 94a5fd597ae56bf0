"""Reads a compiled MuJoCo model: frames, joints, masses, shapes, keyframes and the neutral configuration."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from jtik.errors import RobotFileError
from jtik.robot.joint_type import JointType
from jtik.robot.loaders.constraints import ConstraintReader
from jtik.robot.loaders.meshes import MeshFile
from jtik.robot.loaders.robot_description import Names, RobotDescription
from jtik.robot.loaders.shapes import solids
from jtik.robot.loaders.transforms import pose_of, rotation_about, translation
from jtik.robot.loaders.visuals import model_meshes
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.tree import Joint
from jtik.types import Array

TYPES = {
    mujoco.mjtJoint.mjJNT_FREE: JointType.FREE,
    mujoco.mjtJoint.mjJNT_BALL: JointType.BALL,
    mujoco.mjtJoint.mjJNT_SLIDE: JointType.PRISMATIC,
    mujoco.mjtJoint.mjJNT_HINGE: JointType.REVOLUTE,
}
"""MuJoCo's joint types."""


class ModelReader:
    """Reads one ``mujoco.MjModel``.

    Each body and each site is a frame with its name. Several joints on a body form a chain in their order; the frames
    between them have the names of the joints, and so has the frame of a joint whose anchor is not the origin of the
    body. Elements without a name get that of their body.

    Args:
        model: the ``mujoco.MjModel``.
        label: the name of the model in errors.
        root: number of the body that is the base: 0, the world, or its only child.
        meshes: meshes that were removed from the model, by the number of the geom that replaces them.
        negligible_mass: masses up to this count as none [kg].
    """

    def __init__(
        self,
        model: Any,
        label: str,
        *,
        root: int = 0,
        meshes: Mapping[int, MeshFile] | None = None,
        negligible_mass: float = 0.0,
    ) -> None:
        self._model = model
        self._label = label
        self._root = root
        self._meshes = meshes or {}
        self._negligible_mass = negligible_mass
        self._frames, self._joints = Names(), Names()
        kind = mujoco.mjtObj
        given = [self._given(kind.mjOBJ_BODY, body) for body in range(model.nbody)]
        self._frames.reserve(given)
        self._bodies = [name or self._frames.unique(f"body{body}") for body, name in enumerate(given)]
        given = [self._given(kind.mjOBJ_JOINT, joint) for joint in range(model.njnt)]
        self._joints.reserve(given)
        self._joint_names = [
            name or self._joints.unique(self._bodies[model.jnt_bodyid[joint]], "joint")
            for joint, name in enumerate(given)
        ]
        given = [self._given(kind.mjOBJ_SITE, site) for site in range(model.nsite)]
        self._sites = [self._frames.unique(name or f"site{site}", "site") for site, name in enumerate(given)]

    def read(self) -> RobotDescription:
        """The robot; see `RobotDescription`.

        Raises:
            RobotFileError: when a joint has limits that cannot be used.
        """
        joints: list[Joint] = []
        for body in range(self._root + 1, self._model.nbody):
            joints += self._chain(body)
            joints += self._site_frames(body)
        joints[:0] = self._site_frames(self._root)
        constraints = ConstraintReader(self._model, self._joint_names, self._bodies)
        objects = self._objects()
        return RobotDescription(
            label=self._label,
            name=self._model_name(),
            base=self._bodies[self._root],
            joints=tuple(joints),
            couplings=tuple(constraints.couplings),
            objects=tuple(self._joint_names[self._model.body_jntadr[body]] for body in objects),
            masses=self._masses(objects),
            shapes={self._bodies[body]: found for body, found in solids(self._model, self._meshes).items()},
            meshes={self._bodies[body]: found for body, found in model_meshes(self._model, self._meshes).items()},
            keyframes=self._keyframes(),
            neutral=self._positions(self._model.qpos0),
            notes=tuple(constraints.notes),
        )

    def _chain(self, body: int) -> Iterator[Joint]:
        """The joints between the parent body and a body, with its frame."""
        model, name = self._model, self._bodies[body]
        parent = self._bodies[model.body_parentid[body]]
        before = pose_of(model.body_pos[body], model.body_quat[body])
        first, count = int(model.body_jntadr[body]), int(model.body_jntnum[body])
        for number in range(first, first + count):
            anchor = np.array(model.jnt_pos[number])
            joint_type = TYPES[mujoco.mjtJoint(model.jnt_type[number])]
            if joint_type in (JointType.FREE, JointType.PRISMATIC):
                anchor = np.zeros(3)  # has no effect on these joints
            if joint_type is JointType.FREE:
                before = np.eye(4)  # the position of a free joint is that of its body in the world
            last = number == first + count - 1 and not anchor.any()
            child = name if last else self._frames.unique(self._joint_names[number], "joint")
            yield self._joint(number, joint_type, parent, child, before @ translation(anchor))
            if last:
                return
            parent, before = child, translation(-anchor)
        yield Joint(self._joints.unique(name, "fixed"), JointType.FIXED, parent, name, origin=before)

    def _joint(self, number: int, kind: JointType, parent: str, child: str, origin: Array) -> Joint:
        model, name = self._model, self._joint_names[number]
        if not kind.is_scalar:
            return Joint(name, kind, parent, child, origin=origin)
        axis = np.array(model.jnt_axis[number])
        at_zero = -float(model.qpos0[model.jnt_qposadr[number]])
        offset = rotation_about(axis, at_zero) if kind is JointType.REVOLUTE else translation(at_zero * axis)
        lower, upper = self._limits(number)
        return Joint(name, kind, parent, child, origin=origin @ offset, axis=axis, lower=lower, upper=upper)

    def _limits(self, number: int) -> tuple[float, float]:
        lower, upper = map(float, self._model.jnt_range[number])
        if math.isnan(lower) or math.isnan(upper):
            where = f"joint {self._joint_names[number]!r}"
            raise RobotFileError(self._label, where, f"its limits are {lower:g} and {upper:g}; accepted: no NaN")
        return (lower, upper) if self._model.jnt_limited[number] else (-math.inf, math.inf)

    def _site_frames(self, body: int) -> Iterator[Joint]:
        model = self._model
        for site in np.flatnonzero(model.site_bodyid == body):
            frame = self._sites[site]
            joint = self._joints.unique(frame, "fixed")
            origin = pose_of(model.site_pos[site], model.site_quat[site])
            yield Joint(joint, JointType.FIXED, self._bodies[body], frame, origin=origin)

    def _objects(self) -> list[int]:
        """The bodies that move freely and carry no other joint, beside a robot that has other joints."""
        model = self._model
        joints_on = np.bincount(model.body_rootid, weights=model.body_jntnum, minlength=model.nbody)
        free = model.jnt_bodyid[model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)]
        objects = [int(body) for body in free if joints_on[body] == 1]
        return objects if len(objects) < model.njnt else []

    def _masses(self, objects: list[int]) -> dict[str, Mass]:
        """The masses of the bodies, without those of objects."""
        model = self._model
        return {
            self._bodies[body]: Mass(float(model.body_mass[body]), np.array(model.body_ipos[body]))
            for body in range(self._root, model.nbody)
            if model.body_mass[body] > self._negligible_mass and model.body_rootid[body] not in objects
        }

    def _keyframes(self) -> dict[str, dict[str, Array]]:
        model = self._model
        names = Names()
        found = {}
        for key in range(model.nkey):
            name = names.unique(self._given(mujoco.mjtObj.mjOBJ_KEY, key) or f"key{key}")
            found[name] = self._positions(model.key_qpos[key])
        return found

    def _positions(self, qpos: Array) -> dict[str, Array]:
        """The position of each joint in ``qpos`` (model.nq,), by its name."""
        types = [TYPES[mujoco.mjtJoint(kind)] for kind in self._model.jnt_type]
        return {
            name: np.array(qpos[first : first + joint_type.nq])
            for name, joint_type, first in zip(self._joint_names, types, self._model.jnt_qposadr, strict=True)
        }

    def _given(self, kind: Any, number: int) -> str:
        return str(mujoco.mj_id2name(self._model, int(kind), int(number)) or "")

    def _model_name(self) -> str:
        return bytes(self._model.names).partition(b"\0")[0].decode()
