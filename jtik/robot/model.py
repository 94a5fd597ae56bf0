"""The robot: an immutable tree of joints with kinematics in numbers and in symbols."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any

import numpy as np

from jtik.errors import ArgumentError, ImmutableError, UnknownNameError
from jtik.geometry import Solid
from jtik.robot import skeleton
from jtik.robot.body import Mass, masses_on, shapes_on
from jtik.robot.builders import Builders
from jtik.robot.kinematics import Kinematics
from jtik.robot.layout import Layout
from jtik.robot.space import ConfigurationSpace
from jtik.robot.subset import locked_joints
from jtik.robot.tree import Joint, check_moves, check_planar, check_tree, frozen
from jtik.robot.twins import Twins
from jtik.symbolic import SX, Expression, is_equal
from jtik.types import Array


class Robot(ConfigurationSpace, Builders):
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
