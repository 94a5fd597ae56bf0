"""Loads a `RobotDescription` from a URDF, an MJCF or a compiled MuJoCo model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from itertools import pairwise
from typing import Any

import mujoco
import numpy as np

from jtik.errors import ArgumentError, RobotFileError
from jtik.robot.joint_type import JointType
from jtik.robot.loaders.compiled import ModelReader
from jtik.robot.loaders.couplings import with_mimic_joints
from jtik.robot.loaders.robot_description import Names, RobotDescription
from jtik.robot.loaders.source import PathOrText, Source, open_source
from jtik.robot.loaders.spec import MINIMUM_MASS, compile_source
from jtik.robot.loaders.srdf import with_srdf
from jtik.robot.loaders.urdf import UrdfTree, read_tree
from jtik.robot.loaders.urdf_links import mujoco_text
from jtik.robot.loaders.visuals import urdf_meshes
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.tree import Joint
from jtik.types import Array


def load_urdf(
    path_or_xml: PathOrText,
    *,
    free_base: bool = False,
    planar_base: bool = False,
    xacro_arguments: Mapping[str, str] | None = None,
    srdf: PathOrText | None = None,
) -> RobotDescription:
    """A URDF; see `Robot.from_urdf`."""
    if free_base and planar_base:
        raise ArgumentError("planar_base", "True together with free_base=True", "one of the two")
    source = open_source(path_or_xml, kind="URDF", root="robot", arguments=xacro_arguments)
    tree = read_tree(source)
    bare = mujoco_text(source)
    compiled = compile_source(source, text=bare.text, edit=_leave_to_xml)
    root = max(0, mujoco.mj_name2id(compiled.model, mujoco.mjtObj.mjOBJ_BODY, tree.root))
    reader = ModelReader(compiled.model, source.label, root=root, meshes=compiled.meshes, negligible_mass=MINIMUM_MASS)
    with _named(source.label):
        read = reader.read()
        joints = [_as_stated(joint, tree) for joint in read.joints]
        masses = {link: _with_inertia(mass, bare.inertias.get(link)) for link, mass in read.masses.items()}
    couplings = [joint.coupling for joint in tree.joints.values() if joint.coupling is not None]
    description = replace(
        read,
        joints=tuple(joints),
        couplings=tuple(couplings),
        meshes=urdf_meshes(source),
        masses=masses,
        neutral=None,  # a URDF has none; that of the MuJoCo model has other joint types
        name=_name(source),
        notes=(*tree.notes, *bare.notes),
        changes=(*tree.changes, *bare.changes),
    )
    if free_base:
        description = _on_base(description, FREE_BASE)
    if planar_base:
        description = _on_base(description, PLANAR_BASE)
    description = with_mimic_joints(description)
    return description if srdf is None else with_srdf(description, srdf)


def load_mjcf(path_or_xml: PathOrText) -> RobotDescription:
    """An MJCF; see `Robot.from_mjcf`."""
    source = open_source(path_or_xml, kind="MJCF", root="mujoco")
    compiled = compile_source(source)
    reader = ModelReader(compiled.model, source.label, meshes=compiled.meshes, negligible_mass=MINIMUM_MASS)
    with _named(source.label):
        read = _some_body(reader.read())
    if not compiled.has_inertias:
        points = {frame: Mass(mass.mass, mass.center) for frame, mass in read.masses.items()}
        change = "its masses count as point masses: MuJoCo refuses their inertias"
        read = replace(read, masses=points, changes=(*read.changes, change))
    if compiled.against_tendons:
        note = f"its tendons are not kept: MuJoCo refuses them: {compiled.against_tendons}"
        read = replace(read, notes=(*read.notes, note))
    changes = [
        f"body {name!r} has no mass of a non-negative number: it counts as massless" for name in compiled.without_mass
    ]
    return with_mimic_joints(replace(read, name=_name(source), changes=(*read.changes, *changes)))


def load_mujoco(model: Any) -> RobotDescription:
    """A compiled model; see `Robot.from_mujoco`."""
    if not isinstance(model, mujoco.MjModel):
        raise ArgumentError("model", model, "a mujoco.MjModel")
    label = "the MjModel given"
    with _named(label):
        return with_mimic_joints(_some_body(ModelReader(model, label).read()))


PLANAR_BASE = {
    "planar_base_x": (JointType.PRISMATIC, (1.0, 0.0, 0.0)),
    "planar_base_y": (JointType.PRISMATIC, (0.0, 1.0, 0.0)),
    "planar_base_heading": (JointType.REVOLUTE, (0.0, 0.0, 1.0)),
}
"""The joints of a base that moves in the x-y plane and rotates about z: their types and axes."""

FREE_BASE = {"free_base": (JointType.FREE, (0.0, 0.0, 1.0))}
"""The joint of a base that moves freely; it has no axis."""


@contextmanager
def _named(label: str) -> Iterator[None]:
    """Raises an `ArgumentError` as a `RobotFileError` that names the file."""
    try:
        yield
    except UnicodeDecodeError as error:
        problem = "a name in it, or in a file that it includes, is not UTF-8; accepted: files in UTF-8"
        raise RobotFileError(label, "", problem) from error
    except ArgumentError as error:
        raise RobotFileError(label, "", str(error)) from error


def _some_body(description: RobotDescription) -> RobotDescription:
    if not description.joints:
        raise RobotFileError(description.label, "", "not a robot: it has no body; accepted: at least one body")
    return description


def _name(source: Source) -> str:
    given = source.root.get("name") or source.root.get("model")
    return given or (source.path.stem if source.path is not None else "robot")


def _leave_to_xml(spec: Any) -> None:
    """Change in a spec what MuJoCo refuses."""
    for joint in spec.joints:
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
    if stated.type in ("floating", "spherical"):
        kind = JointType.FREE if stated.type == "floating" else JointType.BALL
        return replace(joint, name=stated.name, type=kind)
    joint = replace(joint, lower=stated.lower, upper=stated.upper)
    return replace(joint, velocity_limit=stated.velocity_limit, effort_limit=stated.effort_limit)


def _with_inertia(mass: Mass, per_mass: Array | None) -> Mass:
    """The mass with an inertia, which is given per mass; a point mass without one."""
    return Mass(mass.mass, mass.center, np.zeros((3, 3)) if per_mass is None else mass.mass * per_mass)


def _on_base(description: RobotDescription, base_joints: Mapping[str, tuple[JointType, Any]]) -> RobotDescription:
    """The same robot with its root on joints, by their names, in a frame "world"."""
    frames, names = Names(), Names()
    frames.reserve([description.base, *(joint.child for joint in description.joints)])
    names.reserve(joint.name for joint in description.joints)
    world = frames.unique("world")
    between = [frames.unique(name) for name in list(base_joints)[:-1]]
    links = pairwise([world, *between, description.base])
    added = [
        Joint(names.unique(name), kind, parent, child, axis=np.array(axis))
        for (name, (kind, axis)), (parent, child) in zip(base_joints.items(), links, strict=True)
    ]
    return replace(description, base=world, joints=(*added, *description.joints))
