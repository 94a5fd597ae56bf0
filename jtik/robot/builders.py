"""Where robots come from: arms by their lengths or parameters, files, MuJoCo's models, the gallery."""

from __future__ import annotations

import warnings
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from jtik.errors import ArgumentError, RobotFileError
from jtik.robot import gallery
from jtik.robot.chains import dh_joints, planar_joints, vehicle_joints
from jtik.robot.dh import Convention, Row
from jtik.robot.tree import check_moves

if TYPE_CHECKING:
    from jtik.robot.loaders.description import Description
    from jtik.robot.loaders.source import PathOrText


class Builders:
    """The class methods of `Robot` that build one."""

    if TYPE_CHECKING:

        def __init__(self, joints: Iterable[Any], **options: Any) -> None: ...

    @classmethod
    def planar(
        cls,
        links: object,
        *,
        lower: object = -np.inf,
        upper: object = np.inf,
        velocity_limit: object = np.inf,
        name: str | None = None,
    ) -> Self:
        """A planar arm of hinges "joint1" ... at frames "link1" ..., ending in the frame "tip".

        At q = 0 it lies stretched along x. Positions are (x, y).

        Args:
            links: number of unit links, or their lengths [m].
            lower: lower limits [rad], one for all joints or one each.
            upper: upper limits [rad].
            velocity_limit: greatest speeds [rad/s].
            name: what to call the robot.

        Raises:
            ArgumentError: when a length is not positive or limits are crossed.
        """
        joints = planar_joints(links, (lower, upper, velocity_limit))
        return cls(joints, name=name or f"planar{len(joints) - 1}", planar=True)

    @classmethod
    def from_dh(
        cls,
        rows: Iterable[Row],
        *,
        convention: Convention = "standard",
        base: object = None,
        tool: object = None,
        name: str = "dh",
    ) -> Self:
        """A serial chain from Denavit-Hartenberg parameters.

        Row K becomes "jointK", which moves the frame "linkK": attached to link K with its z axis on the axis
        of joint K. In the modified convention that is the textbook's frame K. The frame "tip" is the
        textbook's last frame, then the tool, in both conventions.

        Args:
            rows: for each joint a `DHRow`, a mapping with its fields, or (a, alpha, d, theta) if revolute.
            convention: "standard" (Rz Tz Tx Rx) or "modified" (Craig: Rx Tx Rz Tz).
            base: pose (4, 4) [m] of the first frame in "base"; the identity when None.
            tool: pose (4, 4) [m] of the tip in the last frame; the identity when None.
            name: what to call the robot.

        Raises:
            ArgumentError: when a row, the convention or a transform cannot be used.
        """
        joints = dh_joints(rows, convention, base, tool)
        check_moves(joints)
        return cls(joints, name=name)

    @classmethod
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
        """A planar arm on a vehicle: slides "x" and "y", perhaps the hinge "heading", then "joint1" ...

        The frame "vehicle" is the vehicle's; "link1" ... sit at the arm's joints, the first of them on the
        vehicle's origin, and "tip" at the end.

        Args:
            links: number of unit links, or their lengths [m].
            heading: whether the vehicle turns.
            lower: lower limits of the arm's joints [rad], one for all or one each.
            upper: upper limits of the arm's joints [rad].
            velocity_limit: greatest speeds of the arm's joints [rad/s].
            vehicle_lower: lower limits of x, y [m] and heading [rad], one for all or one each.
            vehicle_upper: upper limits of x, y [m] and heading [rad].
            vehicle_velocity_limit: greatest speeds of x, y [m/s] and heading [rad/s].
            name: what to call the robot.

        Raises:
            ArgumentError: when a length is not positive or limits are crossed.
        """
        arm = (lower, upper, velocity_limit)
        carriage = (vehicle_lower, vehicle_upper, vehicle_velocity_limit)
        joints = vehicle_joints(links, heading, arm, carriage)
        return cls(joints, name=name or f"vehicle{len(joints) - 1}", planar=True)

    @classmethod
    def from_urdf(
        cls,
        path_or_xml: PathOrText,
        *,
        tip: str | None = None,
        name: str | None = None,
        free_base: bool = False,
    ) -> Self:
        """The robot of a URDF file or text.

        Frames are the links, by their names; the root link is the base. Joints keep their names, limits and speeds;
        ``mimic`` joints follow their leaders, floating joints are free, planar ones become the slides "NAME_TX" and
        "NAME_TY" and the hinge "NAME_RZ". Limits that are all zero, and speeds of zero, count as none. Masses are
        kept, and the primitives that collide become shapes; so do capsules around meshes whose STL or OBJ files are
        found: no file needs to be there.

        Args:
            path_or_xml: the path of a file, or text that starts with "<".
            tip: the frame that works; when None the first moving frame called like a tool ("tool0", "tcp", "ee" ...),
                else the end of the longest chain of joints, fingers not counted.
            name: what to call the robot; what the file says when None.
            free_base: whether the root link moves freely, by the joint "free_base", in a frame "world".

        Raises:
            RobotFileError: when there is no such file, or it is no URDF, or an element cannot be used.
            UnknownNameError: when ``tip`` is no frame.

        Warns:
            UserWarning: when a joint mimics one that it cannot follow, and stays independent.
        """
        from jtik.robot.loaders import load_urdf

        return cls._described(load_urdf(path_or_xml, free_base=free_base), tip, name)

    @classmethod
    def from_mjcf(cls, path_or_xml: PathOrText, *, tip: str | None = None, name: str | None = None) -> Self:
        """The robot of a MuJoCo (MJCF) file or text.

        Frames are the bodies and the sites, by their names, and "world" is the base; a site called like a body is
        "NAME (site)". Several joints on a body are a chain whose inner frames have the joints' names. q is MuJoCo's
        ``qpos`` without the joints that follow others: linear equalities of joints are folded into the joint that
        leads. Limits of ball joints and loops that constraints close are left out. Masses and keyframes are kept, and
        geoms become shapes: those that collide, or all where none does. Mesh files need not be there; a mesh weighs
        what the file says, else nothing.

        Args:
            path_or_xml: the path of a file, or text that starts with "<".
            tip: the frame that works; chosen as in `from_urdf` when None.
            name: what to call the robot; what the file says when None.

        Raises:
            RobotFileError: when there is no such file, or it is no MJCF, or an element cannot be used.
            UnknownNameError: when ``tip`` is no frame.

        Warns:
            UserWarning: when a joint follows another by a polynomial of higher order, and stays independent.
        """
        from jtik.robot.loaders import load_mjcf

        return cls._described(load_mjcf(path_or_xml), tip, name)

    @classmethod
    def from_mujoco(cls, model: Any, *, tip: str | None = None, name: str | None = None) -> Self:
        """The robot of a compiled ``mujoco.MjModel``; see `from_mjcf`.

        Args:
            model: the model. Bodies that its compiler fused into others are gone.
            tip: the frame that works; chosen as in `from_urdf` when None.
            name: what to call the robot; the model's name when None.

        Raises:
            ArgumentError: when it is no ``mujoco.MjModel``.
            RobotFileError: when it has no body, or a limit that is NaN.
            UnknownNameError: when ``tip`` is no frame.
        """
        from jtik.robot.loaders import load_mujoco

        return cls._described(load_mujoco(model), tip, name)

    @classmethod
    def _described(cls, description: Description, tip: str | None, name: str | None) -> Self:
        if description.notes:
            warnings.warn(f"{description.label}: {'; '.join(description.notes)}", stacklevel=3)
        arguments = description.arguments()
        try:
            return cls(**arguments, name=name or description.name, tip=description.tip if tip is None else tip)
        except ArgumentError as error:
            raise RobotFileError(description.label, "", str(error)) from error

    @classmethod
    def builtin(cls, name: str) -> Self:
        """A robot that comes with jtik, by its name.

        "panda" (Franka Emika Panda with its hand), "ur5e" and "ur5" (Universal Robots), "iiwa14" (KUKA LBR iiwa 14
        R820), "xarm7" (UFACTORY), "gen3" (Kinova, 7 joints), "jaco2" (Kinova, 6 joints), "vehicle_panda" (a Panda on an
        omnidirectional vehicle), "vehicle3" (planar vehicle with three links) and "planar10" (ten unit links). Figures
        are the makers': see `jtik.robot.gallery`, whose ``names()`` lists them. All have the frame "tip" and the
        keyframe "home"; the real ones carry the solids of their links.

        Args:
            name: one of those names.

        Raises:
            UnknownNameError: when there is no such robot; it suggests the closest name.
        """
        return cls(**gallery.describe(name).arguments())
