"""Loads a `RobotDescription` from a URDF, an MJCF or a compiled MuJoCo model."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import mujoco

from jtik.errors import ArgumentError, RobotFileError
from jtik.robot.joint_type import JointType
from jtik.robot.loaders.compiled import ModelReader
from jtik.robot.loaders.couplings import with_mimic_joints
from jtik.robot.loaders.robot_description import Names, RobotDescription
from jtik.robot.loaders.source import PathOrText, Source, open_source
from jtik.robot.loaders.spec import MINIMUM_MASS, compile_source
from jtik.robot.loaders.urdf import UrdfTree, read_tree
from jtik.robot.tree import Joint


def load_urdf(path_or_xml: PathOrText, *, free_base: bool) -> RobotDescription:
    """A URDF; see `Robot.from_urdf`."""
    source = open_source(path_or_xml, kind="URDF", root="robot")
    tree = read_tree(source)

    def leave_to_xml(spec: Any) -> None:
        _leave_to_xml(spec, tree)

    compiled = compile_source(source, edit=leave_to_xml)
    root = max(0, mujoco.mj_name2id(compiled.model, mujoco.mjtObj.mjOBJ_BODY, tree.root))
    reader = ModelReader(compiled.model, source.label, root=root, meshes=compiled.meshes, negligible_mass=MINIMUM_MASS)
    with _named(source.label):
        read = reader.read()
        joints = [_as_stated(joint, tree) for joint in read.joints]
    couplings = [joint.coupling for joint in tree.joints.values() if joint.coupling is not None]
    description = replace(
        read,
        joints=tuple(joints),
        couplings=tuple(couplings),
        neutral=None,  # a URDF has none; that of the MuJoCo model has other joint types
        name=_name(source),
        notes=tree.notes,
    )
    return with_mimic_joints(_on_free_base(description) if free_base else description)


def load_mjcf(path_or_xml: PathOrText) -> RobotDescription:
    """An MJCF; see `Robot.from_mjcf`."""
    source = open_source(path_or_xml, kind="MJCF", root="mujoco")
    compiled = compile_source(source)
    reader = ModelReader(compiled.model, source.label, meshes=compiled.meshes, negligible_mass=MINIMUM_MASS)
    with _named(source.label):
        read = _some_body(reader.read())
    return with_mimic_joints(replace(read, name=_name(source)))


def load_mujoco(model: Any) -> RobotDescription:
    """A compiled model; see `Robot.from_mujoco`."""
    if not isinstance(model, mujoco.MjModel):
        raise ArgumentError("model", model, "a mujoco.MjModel")
    label = "the MjModel given"
    with _named(label):
        return with_mimic_joints(_some_body(ModelReader(model, label).read()))


@contextmanager
def _named(label: str) -> Iterator[None]:
    """Raises an `ArgumentError` as a `RobotFileError` that names the file."""
    try:
        yield
    except ArgumentError as error:
        raise RobotFileError(label, "", str(error)) from error


def _some_body(description: RobotDescription) -> RobotDescription:
    if not description.joints:
        raise RobotFileError(description.label, "", "not a robot: it has no body; accepted: at least one body")
    return description


def _name(source: Source) -> str:
    given = source.root.get("name") or source.root.get("model")
    return given or (source.path.stem if source.path is not None else "robot")


def _leave_to_xml(spec: Any, tree: UrdfTree) -> None:
    """Remove from a spec what is read from the URDF itself, and what MuJoCo refuses."""
    for equality in spec.equalities:
        spec.delete(equality)
    for joint in spec.joints:
        joint.limited = mujoco.mjtLimited.mjLIMITED_FALSE
        joint.range = (0.0, 0.0)
        if joint.type == mujoco.mjtJoint.mjJNT_FREE:
            # MuJoCo allows free joints in the world only; `_as_stated` restores the type
            joint.type = mujoco.mjtJoint.mjJNT_BALL
    for body in spec.bodies:
        if not body.explicitinertial:
            body.explicitinertial, body.mass = True, 0.0


def _as_stated(joint: Joint, tree: UrdfTree) -> Joint:
    """The joint with the name, type, limits and speed that the URDF states."""
    stated = tree.joints.get(joint.child)
    if stated is None or stated.type == "planar":
        return joint
    if stated.type == "fixed":
        return replace(joint, name=stated.name)
    if stated.type == "floating":
        return replace(joint, name=stated.name, type=JointType.FREE)
    return replace(joint, lower=stated.lower, upper=stated.upper, velocity_limit=stated.velocity_limit)


def _on_free_base(description: RobotDescription) -> RobotDescription:
    """The same robot with its root on a free joint in a frame "world"."""
    frames, names = Names(), Names()
    frames.reserve([description.base, *(joint.child for joint in description.joints)])
    names.reserve(joint.name for joint in description.joints)
    world = frames.unique("world")
    free = Joint(names.unique("free_base"), JointType.FREE, world, description.base)
    return replace(description, base=world, joints=(free, *description.joints))
