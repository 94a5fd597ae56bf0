"""The robot: an immutable tree of joints with kinematics in numbers and in symbols."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any

from jtik.arguments import flag, instance, instances, mapping, several, text
from jtik.constructors import Constructed
from jtik.errors import ArgumentError, ImmutableError, UnknownNameError
from jtik.geometry import Solid
from jtik.robot import skeleton
from jtik.robot.builders import Builders
from jtik.robot.collisions import CollisionPairs, Collisions
from jtik.robot.collisions.robot_pairs import disabled_pairs
from jtik.robot.drawable import Drawable
from jtik.robot.evaluator import Evaluator
from jtik.robot.home import home_of
from jtik.robot.joint_layout import JointLayout
from jtik.robot.kinematics import JacobianRows, Kinematics, jacobian_rows
from jtik.robot.mass_properties import MassProperties
from jtik.robot.masses_and_shapes import Mass, masses_on, shapes_on
from jtik.robot.mesh import Mesh, meshes_on
from jtik.robot.tree import Joint, check_planar, check_tree, frozen
from jtik.robot.variants import Variants, reduced_robot
from jtik.symbolic import SX, Expression, is_equal
from jtik.types import Array


class Robot(Variants, Builders, Drawable, MassProperties, Collisions, metaclass=Constructed):
    """A kinematic model: a tree of joints, the frames they carry, and limits.

    A configuration q has nq numbers and a velocity n numbers; the two differ for ball and free joints. Methods that
    take q return NumPy arrays for numbers, in any form that `configuration` accepts, and CasADi expressions for an
    expression (nq, 1). A frame that is None means the tip. Robots are immutable, compare by identity and can be
    pickled.

    Args:
        joints: the tree; q follows the order given. Fixed joints add fixed frames; without moving joints q is empty.
        name: name of the robot.
        planar: whether the workspace is the x-y plane, so that positions are (x, y).
        base: name of the root frame.
        tip: name of the end effector's frame; the last joint's child when None.
        masses: the mass, with its inertia, on each frame that has one: for the centre of mass, gravity torques and the
            mass matrix.
        shapes: solids on the frames, in the coordinates of the frames, for clearances.
        meshes: meshes on the frames, for pictures.
        keyframes: named configurations, in any form that `configuration` accepts.
        neutral: the neutral configuration, in any form that `configuration` accepts; it is clamped to the limits. Zero
            and identity quaternions when None.
        ignored: one sentence for each part of its description that the robot does not have.
        disabled_collisions: pairs of frames whose collisions `collision_pairs` leaves out, each with its reason.

    Raises:
        ArgumentError: when the joints do not form a tree, or leave the plane of a planar robot.
        UnknownNameError: when a parent frame, a mimicked joint, the tip or the frame of a mass, shape or mesh does not
            exist.

    Example:
        >>> panda = jtik.Robot.builtin("panda")
        >>> panda.position(panda.home, "tip").round(3)  # [m]
        array([0.307, 0.   , 0.487])
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
        meshes: Mapping[str, Sequence[Mesh]] | None = None,
        keyframes: Mapping[str, object] | None = None,
        neutral: object = None,
        ignored: Sequence[str] = (),
        disabled_collisions: Mapping[tuple[str, str], str] | None = None,
    ) -> None:
        self._joints = several("joints", joints, "a list of jtik.Joint")
        for joint in self._joints:
            instance("joints", joint, Joint, "a list of jtik.Joint")
        planar, base = flag("planar", planar, "whether the workspace is the x-y plane"), text("base", base)
        check_tree(self._joints, base)
        if planar:
            check_planar(self._joints)
        self._name, self._planar, self._base = text("name", name, "the name of the robot"), planar, base
        self._layout = JointLayout.of(self._joints)
        if neutral is not None:
            self._layout = self._layout.with_neutral(self.configuration(neutral, argument="neutral"))
        self._carrier = {joint.child: joint for joint in self._joints}
        self._paths: dict[str, tuple[Joint, ...]] = {base: ()}
        self._tip = self.frame_names[-1] if tip is None else text("tip", tip, "the name of a frame, or None")
        if self._tip not in self.frame_names[self.n > 0 :]:
            raise UnknownNameError("tip frame", self._tip, self._carrier)
        self._ignored = instances("ignored", ignored, str, "sentences")
        self._masses = masses_on(self.frame_names, masses)
        self._shapes = shapes_on(self.frame_names, shapes)
        self._meshes = meshes_on(self.frame_names, meshes)
        self._disabled_collisions = disabled_pairs(self.frame_names, disabled_collisions)
        self._judged: dict[tuple[str, float, float], CollisionPairs] = {}
        self._evaluator = Evaluator(self)
        accepted = "a dict from name to configuration, or None"
        named = {} if keyframes is None else mapping("keyframes", keyframes, accepted)
        self._keyframes = {
            key: frozen(self.configuration(q, argument=f"keyframes[{key!r}]")) for key, q in named.items()
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
        build = partial(type(self), self._joints, **self._options())
        if self._reduction is None:
            return build, ()
        return partial(reduced_robot, build, self._reduction.full, self._reduction.locked), ()

    def _options(self) -> dict[str, Any]:
        """The arguments that make this robot from its joints."""
        return {
            "name": self.name,
            "planar": self._planar,
            "base": self.base,
            "tip": self.tip,
            "masses": self._masses,
            "shapes": self._shapes,
            "meshes": self._meshes,
            "keyframes": self._keyframes,
            "neutral": self.neutral,
            "ignored": self._ignored,
            "disabled_collisions": self._disabled_collisions,
        }

    def __repr__(self) -> str:
        return f"Robot({self.name!r}, n={self.n}, nq={self.nq}, tip={self.tip!r})"

    @property
    def name(self) -> str:
        """The name of the robot."""
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
        """The names of all frames, the base first."""
        return (self._base, *self._carrier)

    @property
    def base(self) -> str:
        """The name of the root frame."""
        return self._base

    @property
    def tip(self) -> str:
        """The frame of the end effector, which is meant where no frame is named."""
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
    def meshes(self) -> Mapping[str, tuple[Mesh, ...]]:
        """The meshes on each frame that has any, for pictures: files, which are read when they are drawn."""
        return MappingProxyType(self._meshes)

    @property
    def keyframes(self) -> Mapping[str, Array]:
        """Named configurations (nq,), read-only; on a robot made by `subset`, of its free joints."""
        return MappingProxyType(self._keyframes)

    @property
    def ignored(self) -> tuple[str, ...]:
        """One sentence for each part of the robot's file that is not kept, such as a closed loop."""
        return self._ignored

    @cached_property
    def home(self) -> Array:
        """Where a solve starts by default, (nq,): the keyframe "home" or, without one, `neutral` off its limits.

        A revolute or prismatic joint within a fifth of its range of a limit is moved to the middle of the range.
        A joint with one limit, or a longer range, counts as one with a range of 2 pi or 2 m from that limit. Read-only.
        """
        return home_of(self)

    @cached_property
    def moving_frames(self) -> tuple[str, ...]:
        """Frames at the joints, and the tip, whose origins move: the points that obstacle avoidance considers."""
        return skeleton.moving_frames(self)

    @cached_property
    def segments(self) -> tuple[tuple[str, str], ...]:
        """Pairs of frames (inner, outer) between which a link of the skeleton lies."""
        return skeleton.segments(self)

    def frame(self, frame: str | None) -> str:
        """``frame`` itself, or the tip for None, and for "tip" where no frame has that name.

        Raises:
            ArgumentError: when it is no text.
            UnknownNameError: when there is no such frame.
        """
        if frame is None:
            return self._tip
        if not isinstance(frame, str):
            raise ArgumentError("frame", repr(frame), "the name of a frame, or None for the tip")
        if frame != self._base and frame not in self._carrier:
            if frame == "tip":
                return self._tip
            raise UnknownNameError("frame", frame, self.frame_names, hint=f"the tip is {self._tip!r}")
        return frame

    def path(self, frame: str | None = None) -> tuple[Joint, ...]:
        """The joints from the base to ``frame``, the tip when None.

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

    def at(self, q: Expression) -> Kinematics:
        """The kinematics at the symbolic configuration ``q`` (nq, 1); the same one again for the same ``q``.

        Raises:
            ArgumentError: when ``q`` is not an SX expression of that shape.
        """
        if not isinstance(q, SX) or q.shape != (self.nq, 1):
            given = f"{type(q).__name__} of shape {getattr(q, 'shape', '?')}"
            raise ArgumentError("q", given, f"a casadi.SX of shape ({self.nq}, 1)")
        for latest, kinematics in self._latest:
            if is_equal(latest, q, 0):
                return kinematics
        own = SX(q)  # a copy, since an SX can be changed in place
        kinematics = Kinematics(self, own)
        self._latest[:] = [(own, kinematics)]
        return kinematics

    def pose(self, q: Expression, frame: str | None = None) -> Any:
        """T_base_frame, shape (4, 4) [m].

        Args:
            q: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).
            frame: name of the frame; the tip when None.

        Raises:
            ArgumentError: when ``q`` has another shape than (nq,) or is not finite.
            UnknownNameError: when there is no such frame.
        """
        return self._evaluator.of_frame("pose", q, frame)

    def position(self, q: Expression, frame: str | None = None) -> Any:
        """The frame's origin in the base frame [m], shape (3,), or (2,) of a planar robot.

        Args:
            q: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).
            frame: name of the frame; the tip when None.

        Raises:
            ArgumentError: when ``q`` has another shape than (nq,) or is not finite.
            UnknownNameError: when there is no such frame.
        """
        return self._evaluator.of_frame("position", q, frame)

    def jacobian(self, q: Expression, frame: str | None = None, *, rows: JacobianRows = None) -> Any:
        """The geometric Jacobian of the frame's origin, in base axes.

        Symbolic results are indexed by rows, as NumPy arrays are: ``J[:3]`` has shape (3, n).

        Args:
            q: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).
            frame: name of the frame; the tip when None.
            rows: "linear" for the derivative of `position` [m/rad] or [m/m], shape (3, n), or (2, n) of a planar robot;
                "angular" for the angular velocity [rad/rad] or [rad/m], shape (3, n), or (1, n), about z, of a planar
                robot; None for all six, shape (6, n), linear rows first.

        Raises:
            ArgumentError: when ``q`` has another shape or is not finite, or ``rows`` is something else.
            UnknownNameError: when there is no such frame.
        """
        selected = jacobian_rows(rows, self.dimension)
        J = self._evaluator.of_frame("jacobian", q, frame)
        return J if selected is None else J[selected]

    def tangent(self, q: Expression) -> Any:
        """The tangent map T(q) with dq/dt = T(q) v at a configuration ``q`` (nq,), shape (nq, n).

        Raises:
            ArgumentError: when ``q`` has another shape than (nq,) or is not finite.
        """
        return self._evaluator.of_layout("tangent", q)

    def integrate(self, q: Expression, dq: Expression) -> Any:
        """The configuration after a displacement, shape (nq,).

        Limits are not applied. Quaternions come out with norm 1.

        Args:
            q: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).
            dq: displacement (n,) [rad] or [m], or an expression (n, 1).

        Raises:
            ArgumentError: when an argument has another shape or is not finite.
        """
        return self._evaluator.of_layout("integrate", q, dq)

    def difference(self, start: Expression, end: Expression) -> Any:
        """The shortest displacement (n,) [rad] or [m] with ``integrate(start, displacement) == end``.

        Args:
            start: a configuration, in any form that `configuration` accepts, or an expression (nq, 1).
            end: another one.

        Raises:
            ArgumentError: when an argument has another shape than (nq,) or is not finite.
        """
        return self._evaluator.of_layout("difference", start, end)
