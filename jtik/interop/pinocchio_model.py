"""The correspondence of a robot with a Pinocchio model, as pink uses it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from jtik.errors import ArgumentError
from jtik.interop.renamed import renamed_classes
from jtik.robot import JointType, Robot
from jtik.robot.loaders.transforms import pose_of
from jtik.types import Array

ROOT = "root_joint"
"""Pinocchio's name of the free joint that it adds below a robot."""

_TO_XYZW = [1, 2, 3, 0]
_TO_WXYZ = [3, 0, 1, 2]


class PinocchioCorrespondence:
    """The correspondence of a robot's joints with those of a Pinocchio model, by name; a free joint also with its root.

    In Pinocchio an unlimited revolute joint is (cos, sin), a quaternion is (x, y, z, w), and the linear velocity of a
    free joint is in the axes of the body; in jtik it is in the axes of the joint.

    Args:
        robot: the robot.
        model: the ``pinocchio.Model``.
        rest: q (model.nq,) of the model's other joints, and of joints that are mimic joints of the robot; Pinocchio's
            neutral configuration by default.

    Raises:
        ArgumentError: when the model does not have a joint of the robot, or one of another size.
    """

    def __init__(self, robot: Robot, model: Any, *, rest: Any = None) -> None:
        self._robot, self._nv = robot, int(model.nv)
        self._rest = _neutral(model) if rest is None else np.array(rest, dtype=float)
        self._joints = []
        for joint in robot.independent_joints:
            name = joint.name
            if joint.type is JointType.FREE and not model.existJointName(name):
                name = ROOT
            number = model.getJointId(name) if model.existJointName(name) else 0
            found = model.joints[number] if number else None
            if found is None or found.nv != joint.type.nv:
                kind = f"a {joint.type.value} joint {joint.name!r}"
                raise ArgumentError("model", f"one without {kind}", f"a model with the joints of {robot!r}")
            mine, own = robot.q_slice(joint.name), robot.v_slice(joint.name)
            theirs, dof = slice(found.idx_q, found.idx_q + found.nq), slice(found.idx_v, found.idx_v + found.nv)
            self._joints.append((joint.type, mine, own, theirs, dof))

    def q(self, q: Array) -> Array:
        """The robot's configuration (nq,) for Pinocchio's (model.nq,).

        Args:
            q: configuration of the Pinocchio model.
        """
        mine = np.zeros(self._robot.nq)
        for kind, own, _, theirs, _ in self._joints:
            value = q[theirs]
            if kind.is_scalar:
                mine[own] = math.atan2(value[1], value[0]) if len(value) == 2 else value[0]
            else:
                mine[own] = np.concatenate([value[:-4], value[-4:][_TO_WXYZ]])
        return mine

    def theirs(self, q: Array) -> Array:
        """Pinocchio's configuration (model.nq,) for the robot's (nq,).

        Args:
            q: configuration of the robot.
        """
        found = self._rest.copy()
        for kind, own, _, theirs, _ in self._joints:
            value, size = q[own], theirs.stop - theirs.start
            if kind.is_scalar:
                found[theirs] = [math.cos(value[0]), math.sin(value[0])] if size == 2 else value
            else:
                found[theirs] = np.concatenate([value[:-4], value[-4:][_TO_XYZW]])
        return found

    def moves(self, q: Array) -> Array:
        """The matrix (model.nv, n) from the robot's velocities at its ``q`` to Pinocchio's.

        Args:
            q: configuration of the robot (nq,).
        """
        matrix = np.zeros((self._nv, self._robot.n))
        for kind, mine, own, _, dof in self._joints:
            block = np.eye(kind.nv)
            if kind is JointType.FREE:
                block[:3, :3] = pose_of(np.zeros(3), q[mine][3:])[:3, :3].T
            matrix[dof, own] = block
        return matrix


def _neutral(model: Any) -> Array:
    import pinocchio

    neutral: Array = pinocchio.neutral(model)
    return neutral


__getattr__ = renamed_classes(__name__, {"Correspondence": PinocchioCorrespondence})
