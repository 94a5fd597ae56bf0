"""The class methods that build a `Robot`: from lengths, DH parameters, files, MuJoCo models and the gallery."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from jtik.arguments import flag, mapping, text
from jtik.constructors import lists_arguments
from jtik.errors import ArgumentError, RobotFileError
from jtik.robot import gallery
from jtik.robot.chains import dh_joints, planar_joints, vehicle_joints
from jtik.robot.dh import Convention, DHRowLike
from jtik.robot.tree import check_moves

if TYPE_CHECKING:
    from jtik.robot.loaders.robot_description import RobotDescription
    from jtik.robot.loaders.source import PathOrText


MOST_REPORTED = 10
"""How many parts of a file that are not kept its warning names."""


class Builders:
    """The class methods of `Robot` that build one."""

    if TYPE_CHECKING:

        def __init__(self, joints: Iterable[Any], **options: Any) -> None: ...

    @classmethod
    @lists_arguments
    def planar(
        cls,
        links: object,
        *,
        lower: object = -np.inf,
        upper: object = np.inf,
        velocity_limit: object = np.inf,
        name: str | None = None,
    ) -> Self:
        """A planar arm of revolute joints "joint1" ... at frames "link1" ..., with the end effector "tip".

        At q = 0 it is stretched along x. Positions are (x, y).

        Args:
            links: number of unit links, or their lengths [m].
            lower: lower limits [rad], one for all joints or one for each.
            upper: upper limits [rad].
            velocity_limit: maximum speeds [rad/s].
            name: name of the robot.

        Raises:
            ArgumentError: when a length is not positive or limits are crossed.
        """
        joints = planar_joints(links, (lower, upper, velocity_limit))
        return cls(joints, name=_named(name, f"planar{len(joints) - 1}"), planar=True)

    @classmethod
    @lists_arguments
    def from_dh(
        cls,
        rows: Iterable[DHRowLike],
        *,
        convention: Convention = "standard",
        base: object = None,
        tool: object = None,
        name: str = "dh",
    ) -> Self:
        """A serial chain from Denavit-Hartenberg parameters.

        Row K becomes "jointK", which moves the frame "linkK". This frame is attached to link K, with its z axis on the
        axis of joint K; in the modified convention it is the frame K of the textbooks. In both conventions the frame
        "tip" is the last frame of the textbooks, followed by the tool.

        Args:
            rows: for each joint a `DHRow`, a mapping with its fields, or (a, alpha, d, theta) of a revolute joint.
            convention: "standard" (Rz Tz Tx Rx) or "modified" (Craig: Rx Tx Rz Tz).
            base: pose (4, 4) [m] of the first frame in "base"; the identity when None.
            tool: pose (4, 4) [m] of the tip in the last frame; the identity when None.
            name: name of the robot.

        Raises:
            ArgumentError: when a row, the convention or a transform cannot be used.
        """
        joints = dh_joints(rows, convention, base, tool)
        check_moves(joints)
        return cls(joints, name=name)

    @classmethod
    @lists_arguments
    def vehicle(
        cls,
        links: object,
        *,
        heading: bool = False,
        lower: object = -np.inf,
        upper: object = np.inf,
        velocity_limit: object = np.inf,
        vehicle_lower: object = -np.inf,
        vehicle_upper: object = np.inf,
        vehicle_velocity_limit: object = np.inf,
        name: str | None = None,
    ) -> Self:
        """A planar arm on a vehicle.

        The joints are the prismatic "x" and "y", the revolute "heading" if there is one, then the revolute "joint1" ...
        The frame "vehicle" belongs to the vehicle. The frames "link1" ... are at the joints of the arm, the first of
        them at the origin of the vehicle, and "tip" is at the end.

        Args:
            links: number of unit links, or their lengths [m].
            heading: whether the vehicle rotates.
            lower: lower limits of the arm's joints [rad], one for all joints or one for each.
            upper: upper limits of the arm's joints [rad].
            velocity_limit: maximum speeds of the arm's joints [rad/s].
            vehicle_lower: lower limits of x, y [m] and heading [rad], one for all or one for each.
            vehicle_upper: upper limits of x, y [m] and heading [rad].
            vehicle_velocity_limit: maximum speeds of x, y [m/s] and heading [rad/s].
            name: name of the robot.

        Raises:
            ArgumentError: when a length is not positive or limits are crossed.
        """
        arm = (lower, upper, velocity_limit)
        carriage = (vehicle_lower, vehicle_upper, vehicle_velocity_limit)
        joints = vehicle_joints(links, heading, arm, carriage)
        return cls(joints, name=_named(name, f"vehicle{len(joints) - 1}"), planar=True)

    @classmethod
    @lists_arguments
    def from_urdf(
        cls,
        path_or_xml: PathOrText,
        *,
        tip: str | None = None,
        name: str | None = None,
        free_base: bool = False,
        planar_base: bool = False,
        xacro_arguments: Mapping[str, str] | None = None,
        srdf: PathOrText | None = None,
    ) -> Self:
        """The robot of a URDF file or text.

        Frames are the links, with their names; the root link is the base. Joints keep their names, limits and speeds.
        ``mimic`` joints follow their leaders, floating joints become free joints, and a planar joint becomes the
        prismatic joints "NAME_TX" and "NAME_TY" and the revolute joint "NAME_RZ". Limits that are all zero, and speeds
        of zero, count as none; with an effort beside them, zeros lock the joint. A follower stays within its own
        limits: they reduce those of its leader. Masses, inertias and effort limits are kept. Collision primitives
        become shapes, and so do capsules around meshes whose STL or OBJ files are found; mesh files are optional.

        Args:
            path_or_xml: the path of a file, or text that starts with "<". A XACRO is expanded by the package xacro,
                which evaluates the expressions in it.
            tip: the frame of the end effector; when None the first moving frame with the name of a tool ("tool0",
                "tcp", "ee", "hand" ...), else the end of the longest chain of joints, without fingers.
            name: name of the robot; that of the file when None.
            free_base: whether the root link moves freely, by the joint "free_base", in a frame "world".
            planar_base: whether the root link moves in the x-y plane of a frame "world" and rotates about z, by the
                joints "planar_base_x", "planar_base_y" and "planar_base_heading".
            xacro_arguments: the arguments of a XACRO, by name.
            srdf: the path of an SRDF, or its text: its ``disable_collisions`` become `disabled_collisions`, its states
                of groups become `keyframes`, in which joints of other groups are at `neutral`.

        Raises:
            RobotFileError: when there is no such file, it is not a URDF, an element cannot be used, the SRDF is none or
                that of another robot, or one is a XACRO and the package xacro is not installed.
            UnknownNameError: when ``tip`` is not a frame.

        Warns:
            UserWarning: one for all that is not kept, which `ignored` lists, or is read otherwise than it is written:
                joints that mimic one they cannot follow, reduced limits, masses without inertias, scales of meshes.
        """
        from jtik.robot.loaders import load_urdf

        flag("free_base", free_base, "whether the root link moves freely")
        flag("planar_base", planar_base, "whether the root link moves in the plane")
        if xacro_arguments is not None:
            mapping("xacro_arguments", xacro_arguments, "a dict from the names of arguments to their values, or None")
        description = load_urdf(
            path_or_xml, free_base=free_base, planar_base=planar_base, xacro_arguments=xacro_arguments, srdf=srdf
        )
        return cls._described(description, tip, name)

    @classmethod
    @lists_arguments
    def from_mjcf(cls, path_or_xml: PathOrText, *, tip: str | None = None, name: str | None = None) -> Self:
        """The robot of a MuJoCo (MJCF) file or text.

        Frames are the bodies and the sites, with their names, and "world" is the base. A site with the name of a body
        becomes "NAME (site)". Several joints on a body become a chain whose inner frames have the names of the joints.
        q is MuJoCo's ``qpos`` without the joints that follow others: a linear equality of joints makes one of them a
        mimic joint, and so does one of a fixed tendon of two joints. Ranges of ball joints, closed loops, and other
        constraints are not kept; `ignored` lists them. `neutral` is ``qpos0``. Free bodies without further joints
        beside a robot are objects: they stay where the file has them, and their joints are not in q. `full` is the
        scene with them, `full_configuration` MuJoCo's order of it. Masses and inertias, but those of objects, limits of
        actuator forces, and keyframes are kept. Geoms become shapes: those that collide, or all of them where none
        does. Mesh files are optional; the mass of a mesh is that of the file, or zero.

        Args:
            path_or_xml: the path of a file, or text that starts with "<".
            tip: the frame of the end effector; chosen as in `from_urdf` when None.
            name: name of the robot; that of the file when None.

        Raises:
            RobotFileError: when there is no such file, it is not an MJCF, or an element cannot be used.
            UnknownNameError: when ``tip`` is not a frame.

        Warns:
            UserWarning: one for all that is not kept, which `ignored` lists.
        """
        from jtik.robot.loaders import load_mjcf

        return cls._described(load_mjcf(path_or_xml), tip, name)

    @classmethod
    @lists_arguments
    def from_mujoco(cls, model: Any, *, tip: str | None = None, name: str | None = None) -> Self:
        """The robot of a compiled ``mujoco.MjModel``; see `from_mjcf`.

        Args:
            model: the model. Bodies that MuJoCo's compiler fused into others do not exist in it.
            tip: the frame of the end effector; chosen as in `from_urdf` when None.
            name: name of the robot; that of the model when None.

        Raises:
            ArgumentError: when it is not a ``mujoco.MjModel``.
            RobotFileError: when it has no body, or a limit that is NaN.
            UnknownNameError: when ``tip`` is not a frame.
        """
        from jtik.robot.loaders import load_mujoco

        return cls._described(load_mujoco(model), tip, name)

    @classmethod
    @lists_arguments
    def _described(cls, description: RobotDescription, tip: str | None, name: str | None) -> Self:
        reported = (*description.notes, *description.changes)
        if reported:
            more = (
                [f"and {len(reported) - MOST_REPORTED} more: see Robot.ignored"]
                if len(reported) > MOST_REPORTED
                else []
            )
            warnings.warn(f"{description.label}: {'; '.join([*reported[:MOST_REPORTED], *more])}", stacklevel=3)
        arguments = description.arguments()
        name, tip = _named(name, description.name), None if tip is None else text("tip", tip, "a frame, or None")
        try:
            robot: Any = cls(**arguments, name=name, tip=description.tip if tip is None else tip)
        except ArgumentError as error:
            raise RobotFileError(description.label, "", str(error)) from error
        if description.objects:
            robot = robot.subset([joint for joint in robot.joint_names if joint not in description.objects])
        result: Self = robot
        return result

    @classmethod
    @lists_arguments
    def builtin(cls, name: str) -> Self:
        """A robot that comes with jtik, by its name.

        "panda" (Franka Emika Panda with its hand), "ur5e" and "ur5" (Universal Robots), "iiwa14" (KUKA LBR iiwa 14
        R820), "xarm7" (UFACTORY), "gen3" (Kinova, 7 joints), "jaco2" (Kinova, 6 joints), "vehicle_panda" (a Panda on an
        omnidirectional vehicle), "vehicle3" (planar vehicle with three links) and "planar10" (ten unit links). The
        figures are those of the makers: see `jtik.robot.gallery`, whose ``names()`` lists the names. Every robot has
        the frame "tip" and the keyframe "home"; the real ones have the solids of their links, and, but for "iiwa14",
        their masses and inertias, from the maker's robot description or a publication.

        Args:
            name: one of these names.

        Raises:
            UnknownNameError: when there is no such robot; it suggests the closest name.
        """
        return cls(**gallery.describe(text("name", name, "the name of a robot")).arguments())


def _named(name: str | None, default: str) -> str:
    """The argument ``name``; the default for None or an empty text."""
    return (None if name is None else text("name", name, "the name of the robot, or None")) or default
