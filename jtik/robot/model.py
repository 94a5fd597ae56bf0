"""The robot: an immutable tree of joints with kinematics in numbers and in symbols."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from jtik.errors import ArgumentError, Array, ImmutableError, RobotFileError, UnknownNameError
from jtik.geometry import Solid
from jtik.robot import gallery, skeleton
from jtik.robot.body import Mass, masses_on, shapes_on
from jtik.robot.chains import dh_joints, planar_joints, vehicle_joints
from jtik.robot.dh import Convention, Row
from jtik.robot.kinematics import Kinematics
from jtik.robot.layout import Layout
from jtik.robot.space import ConfigurationSpace
from jtik.robot.subset import locked_joints
from jtik.robot.tree import Joint, check_moves, check_planar, check_tree, frozen
from jtik.robot.twins import Twins
from jtik.symbolic import SX, Expression, is_equal

if TYPE_CHECKING:
    from jtik.robot.loaders import Description
    from jtik.robot.loaders.source import PathOrText


class Robot(ConfigurationSpace):
    """A robot as its kinematics: joints, the frames they carry, and limits.

    A configuration q has nq numbers and a velocity n; they differ where there are ball or free joints.
    Methods that take q accept numbers and give NumPy arrays, or a CasADi expression and give expressions.
    Frames that are None mean the tip. Robots cannot change, compare by identity and can be pickled.

    Args:
        joints: the tree; q follows the order given. Fixed joints keep fixed frames. Where none moves q is empty.
        name: what to call the robot.
        planar: whether the workspace is the x-y plane, so that positions are (x, y).
        base: name of the root frame.
        tip: the frame that works; the last joint's child when None.
        masses: the mass on each frame that has one, for the centre of mass.
        shapes: solids on the frames, in the frames' coordinates, for clearances.
        keyframes: named configurations (nq,).

    Raises:
        ArgumentError: when the joints are no tree, or leave the plane of a planar robot.
        UnknownNameError: when a parent frame, a mimicked joint, the tip or the frame of a mass or shape does not exist.
    """

    _sealed = False

    def __init__(
        self,
        joints: Iterable[Joint],
        *,
        name: str = "robot",
        planar: bool = False,
        base: str = "base",
        tip: str | None = None,
        masses: Mapping[str, Mass] | None = None,
        shapes: Mapping[str, Sequence[Solid]] | None = None,
        keyframes: Mapping[str, object] | None = None,
    ) -> None:
        self._joints = tuple(joints)
        check_tree(self._joints, base)
        if planar:
            check_planar(self._joints)
        self._name, self._planar, self._base = name, bool(planar), base
        self._layout = Layout.of(self._joints)
        self._carrier = {joint.child: joint for joint in self._joints}
        self._paths: dict[str, tuple[Joint, ...]] = {base: ()}
        self._tip = self.frame_names[-1] if tip is None else tip
        if self._tip not in self.frame_names[self.n > 0 :]:
            raise UnknownNameError("tip frame", self._tip, self._carrier)
        self._masses = masses_on(self.frame_names, masses)
        self._shapes = shapes_on(self.frame_names, shapes)
        self._twins = Twins(self)
        self._keyframes = {
            key: frozen(self.configuration(q, argument=f"keyframes[{key!r}]")) for key, q in (keyframes or {}).items()
        }
        self._latest: list[tuple[Expression, Kinematics]] = []
        self._sealed = True

    def __setattr__(self, attribute: str, value: object) -> None:
        if self._sealed:
            raise ImmutableError(repr(self), attribute)
        super().__setattr__(attribute, value)

    def __delattr__(self, attribute: str) -> None:
        raise ImmutableError(repr(self), attribute)

    def __reduce__(self) -> tuple[Any, ...]:
        options: dict[str, Any] = {
            "name": self.name,
            "planar": self._planar,
            "base": self.base,
            "tip": self.tip,
            "masses": self._masses,
            "shapes": self._shapes,
            "keyframes": self._keyframes,
        }
        return partial(type(self), self._joints, **options), ()

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, n={self.n}, nq={self.nq}, tip={self.tip!r})"

    @classmethod
    def planar(
        cls,
        links: object,
        *,
        lower: object = -np.inf,
        upper: object = np.inf,
        velocity_limit: object = np.inf,
        name: str | None = None,
    ) -> Robot:
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
    ) -> Robot:
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
    ) -> Robot:
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
    ) -> Robot:
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
    def from_mjcf(cls, path_or_xml: PathOrText, *, tip: str | None = None, name: str | None = None) -> Robot:
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
    def from_mujoco(cls, model: Any, *, tip: str | None = None, name: str | None = None) -> Robot:
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
    def _described(cls, description: Description, tip: str | None, name: str | None) -> Robot:
        if description.notes:
            warnings.warn(f"{description.label}: {'; '.join(description.notes)}", stacklevel=3)
        arguments = description.arguments()
        try:
            return cls(**arguments, name=name or description.name, tip=description.tip if tip is None else tip)
        except ArgumentError as error:
            raise RobotFileError(description.label, "", str(error)) from error

    @classmethod
    def builtin(cls, name: str) -> Robot:
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

    def subset(self, joints: Iterable[str], *, at: object = None) -> Robot:
        """This robot with only ``joints`` free and every other one locked; all frames remain.

        Args:
            joints: names of the joints that stay free.
            at: the configuration (nq,) at which the others are locked; `neutral` when None.

        Raises:
            ArgumentError: when ``at`` is not a configuration, or no joint stays free.
            UnknownNameError: when there is no such joint.
        """
        kept = locked_joints(self, joints, at)
        check_moves(kept)
        part = type(self)(
            kept,
            name=self.name,
            planar=self._planar,
            base=self.base,
            tip=self.tip,
            masses=self._masses,
            shapes=self._shapes,
        )
        places = [self.q_slice(joint) for joint in part.joint_names]
        part._keyframes.update(
            {key: frozen(np.concatenate([q[place] for place in places])) for key, q in self._keyframes.items()}
        )
        return part

    @property
    def name(self) -> str:
        """What the robot is called."""
        return self._name

    @property
    def dimension(self) -> int:
        """Length of a position: 2 for a planar robot, else 3."""
        return 2 if self._planar else 3

    @property
    def joints(self) -> tuple[Joint, ...]:
        """All joints, fixed and mimic ones among them, in the order given."""
        return self._joints

    @property
    def frame_names(self) -> tuple[str, ...]:
        """All frames, the base first."""
        return (self._base, *self._carrier)

    @property
    def base(self) -> str:
        """The root frame."""
        return self._base

    @property
    def tip(self) -> str:
        """The frame meant where none is named."""
        return self._tip

    @property
    def masses(self) -> Mapping[str, Mass]:
        """The mass on each frame that has one."""
        return MappingProxyType(self._masses)

    @property
    def shapes(self) -> Mapping[str, tuple[Solid, ...]]:
        """The solids on each frame that has any, in the frame's coordinates."""
        return MappingProxyType(self._shapes)

    @property
    def keyframes(self) -> Mapping[str, Array]:
        """Named configurations (nq,), read-only; those of a subset are of its own joints."""
        return MappingProxyType(self._keyframes)

    @cached_property
    def moving_frames(self) -> tuple[str, ...]:
        """Frames at the joints, and the tip, whose origins move: the points to keep away from obstacles."""
        return skeleton.moving_frames(self)

    @cached_property
    def segments(self) -> tuple[tuple[str, str], ...]:
        """Pairs of frames (inner, outer) between which a link of the skeleton lies."""
        return skeleton.segments(self)

    def frame(self, frame: str | None) -> str:
        """``frame`` itself, or the tip for None.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        if frame is None:
            return self._tip
        if frame != self._base and frame not in self._carrier:
            raise UnknownNameError("frame", frame, self.frame_names)
        return frame

    def path(self, frame: str | None = None) -> tuple[Joint, ...]:
        """The joints from the base to ``frame``.

        Raises:
            UnknownNameError: when there is no such frame.
        """
        frame = self.frame(frame)
        if frame not in self._paths:
            above, chain = frame, []
            while above not in self._paths:
                chain.append(self._carrier[above])
                above = chain[-1].parent
            self._paths[frame] = (*self._paths[above], *reversed(chain))
        return self._paths[frame]

    def configuration(self, q: object, *, argument: str = "q") -> Array:
        """A checked copy of a configuration given as numbers, (nq,).

        Raises:
            ArgumentError: when it has another shape, is not finite, or has a zero quaternion; it names ``argument``.
        """
        array: Array = self._twins.checked(argument, np.asarray(q))
        return array

    def at(self, q: Expression) -> Kinematics:
        """The kinematics at the symbolic configuration ``q`` (nq, 1); the same one again for the same ``q``.

        Raises:
            ArgumentError: when ``q`` is not an SX expression of that shape.
        """
        if not isinstance(q, SX) or q.shape != (self.nq, 1):
            given = f"{type(q).__name__} of shape {getattr(q, 'shape', '?')}"
            raise ArgumentError("q", given, f"a casadi.SX of shape ({self.nq}, 1)")
        for seen, kinematics in self._latest:
            if is_equal(seen, q, 0):
                return kinematics
        own = SX(q)  # a copy: an SX can be changed in place
        kinematics = Kinematics(self, own)
        self._latest[:] = [(own, kinematics)]
        return kinematics

    def pose(self, q: Expression, frame: str | None = None) -> Any:
        """T_base_frame, shape (4, 4) [m].

        Raises:
            ArgumentError: when ``q`` has another shape than (nq,) or is not finite.
            UnknownNameError: when there is no such frame.
        """
        return self._twins.of_frame("pose", q, frame)

    def position(self, q: Expression, frame: str | None = None) -> Any:
        """The frame's origin in the base frame [m], shape (3,), or (2,) of a planar robot.

        Raises:
            ArgumentError: when ``q`` has another shape than (nq,) or is not finite.
            UnknownNameError: when there is no such frame.
        """
        return self._twins.of_frame("position", q, frame)

    def jacobian(self, q: Expression, frame: str | None = None) -> Any:
        """The geometric Jacobian at the frame's origin in base axes, linear rows first, shape (6, n).

        Raises:
            ArgumentError: when ``q`` has another shape than (nq,) or is not finite.
            UnknownNameError: when there is no such frame.
        """
        return self._twins.of_frame("jacobian", q, frame)

    def center_of_mass(self, q: Expression) -> Any:
        """The centre of mass in the base frame [m], shape (3,), or (2,) of a planar robot.

        Raises:
            ArgumentError: when the robot has no masses, or ``q`` has another shape than (nq,) or is not finite.
        """
        return self._twins.of_frame("center_of_mass", q, None)

    def tangent(self, q: Expression) -> Any:
        """The tangent map T(q) with dq/dt = T(q) v, shape (nq, n).

        Raises:
            ArgumentError: when ``q`` has another shape than (nq,) or is not finite.
        """
        return self._twins.of_layout("tangent", q)

    def integrate(self, q: Expression, dq: Expression) -> Any:
        """The configuration after the displacement ``dq`` (n,) [rad] or [m] from ``q``, shape (nq,).

        Limits are not applied. Quaternions come out with norm 1.

        Raises:
            ArgumentError: when an argument has another shape or is not finite.
        """
        return self._twins.of_layout("integrate", q, dq)

    def difference(self, start: Expression, end: Expression) -> Any:
        """The shortest displacement (n,) [rad] or [m] with ``integrate(start, displacement) == end``.

        Raises:
            ArgumentError: when an argument has another shape than (nq,) or is not finite.
        """
        return self._twins.of_layout("difference", start, end)
