"""Robots made from a robot: with fewer free joints, with a tool, on a base."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Self

from jtik.arguments import instances, mapping, non_negative_number
from jtik.arguments import name as read_name
from jtik.errors import ArgumentError
from jtik.geometry import Solid
from jtik.robot.configuration_space import ConfigurationSpace
from jtik.robot.joint_type import JointType
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.pose_input import read_pose
from jtik.robot.subset import Reduction, locked_joints
from jtik.robot.tree import Joint, check_moves, frozen
from jtik.types import Array

if TYPE_CHECKING:
    from jtik.robot.model import Robot


TIP, FLANGE = "tip", "flange"
"""A name that means the tip of a robot where no frame has it; and what such a frame is called once there is a tool."""


class Variants(ConfigurationSpace):
    """The methods of `Robot` that make another robot from it."""

    _joints: tuple[Joint, ...]

    if TYPE_CHECKING:

        def _options(self) -> dict[str, Any]: ...

    def subset(self, joints: Iterable[str], *, at: object = None) -> Self:
        """This robot with only ``joints`` free and every other joint locked; all frames remain.

        The result keeps this robot as `full`. `full_configuration` and `reduced` convert configurations.

        Args:
            joints: names of the joints that stay free.
            at: the configuration at which the others are locked, in any form that `configuration` accepts; `neutral`
                when None.

        Raises:
            ArgumentError: when ``at`` is not a configuration, or no joint stays free.
            UnknownNameError: when there is no such joint.
        """
        robot: Any = self
        q = self.neutral if at is None else self.configuration(at, argument="at")
        kept = locked_joints(robot, joints, q)
        check_moves(kept)
        neutral = {joint.name: self.neutral[self.q_slice(joint.name)] for joint in kept if joint.is_independent}
        options = self._options() | {"neutral": neutral, "keyframes": None}
        make: Callable[..., Robot] = type(robot)
        part: Any = reduced_robot(partial(make, kept, **options), robot, q)
        part._keyframes.update({key: frozen(part.reduced(q)) for key, q in robot.keyframes.items()})
        result: Self = part
        return result

    def with_tool(
        self,
        pose: object,
        *,
        name: str = "tool",
        mass: float | Mass | None = None,
        shapes: Sequence[Solid] = (),
        frame: str | None = None,
    ) -> Self:
        """This robot with a tool: a new frame, which is the tip of the result.

        A frame called "tip", as built-in arms have one, is called "flange" from then on, so that "tip" means the tool.

        Args:
            pose: pose (4, 4) [m] of the tool in ``frame``, or in another form of the targets of `FrameTask`.
            name: name of the new frame.
            mass: mass of the tool [kg] at the origin of its frame, or a `Mass` with its centre in that frame.
            shapes: solids of the tool, in its frame, for clearances.
            frame: the frame that carries the tool; the tip when None.

        Raises:
            ArgumentError: when ``pose`` is not a pose, there is a frame with that name already, or the mass or a shape
                cannot be used.
            UnknownNameError: when there is no frame ``frame``.
        """
        robot: Any = self
        name, carrier = read_name("name", name), robot.frame(frame)
        others = [each for each in robot.frame_names if each != TIP]
        if name in others:
            raise ArgumentError("name", name, f"a name of its own, none of {', '.join(others)}")
        solids = instances("shapes", shapes, Solid, "solids, such as jtik.Sphere or jtik.Box")
        full = _outermost(robot)
        flange = _unique(FLANGE, {*others, name})
        joints, options = _renamed(full, {TIP: flange})
        new = _fixed(full, name, flange if carrier == TIP else carrier, name, pose)
        options["tip"] = name
        if mass is not None:
            options["masses"] = {**options["masses"], name: _mass(mass, "mass")}
        options["shapes"] = {**options["shapes"], name: solids}
        return self._rebuilt((*joints, new), options)

    def with_masses(self, masses: Mapping[str, float | Mass]) -> Self:
        """This robot with other masses; those on frames that are not named stay.

        Args:
            masses: for each frame a mass [kg] at its origin, or a `Mass` with its centre and inertia in that frame.

        Raises:
            ArgumentError: when a mass cannot be used.
            UnknownNameError: when there is no such frame.
        """
        accepted = "a dict from frame to a non-negative mass [kg] or a jtik.robot.Mass"
        named = mapping("masses", masses, accepted)
        given = {frame: _mass(mass, f"masses[{frame!r}]") for frame, mass in named.items()}
        full = _outermost(self)
        return self._rebuilt(full.joints, full._options() | {"masses": {**full._options()["masses"], **given}})

    def with_base(self, pose: object, *, name: str = "world") -> Self:
        """This robot mounted at a pose: a new base frame carries the present one.

        Poses, targets and obstacles are then in the new frame. Masses, shapes and keyframes stay.

        Args:
            pose: pose (4, 4) [m] of the present base in the new one, or in another form of the targets of `FrameTask`.
            name: name of the new base frame; with a number appended where there is a frame with that name already.

        Raises:
            ArgumentError: when ``pose`` is not a pose.
        """
        robot: Any = self
        unique, full = _unique(read_name("name", name), robot.frame_names), _outermost(robot)
        new = _fixed(full, "mount", unique, robot.base, pose)
        return self._rebuilt((new, *full.joints), full._options() | {"base": unique})

    def _rebuilt(self, joints: tuple[Joint, ...], options: dict[str, Any]) -> Self:
        """The robot of these joints, reduced to the joints of this one where it was made by `subset`."""
        if self.full is not self:
            inner = self.full._rebuilt(joints, options)
            return inner.subset(self.joint_names, at=self._locked())
        build: Any = type(self)
        robot: Self = build(joints, **options)
        return robot

    def _locked(self) -> Array:
        assert self._reduction is not None
        return self._reduction.locked


def _mass(mass: float | Mass, argument: str) -> Mass:
    accepted = f"a non-negative mass [kg], a jtik.robot.Mass{', or None' if argument == 'mass' else ''}"
    return mass if isinstance(mass, Mass) else Mass(non_negative_number(argument, mass, accepted))


def _outermost(robot: Any) -> Any:
    """The robot from which, by one subset after the other, this one was made."""
    while robot.full is not robot:
        robot = robot.full
    return robot


def _renamed(robot: Any, names: Mapping[str, str]) -> tuple[tuple[Joint, ...], dict[str, Any]]:
    """Joints and options of a robot, with other names of frames where ``names`` has one."""

    def new(frame: str) -> str:
        return names.get(frame, frame)

    joints = tuple(replace(joint, parent=new(joint.parent), child=new(joint.child)) for joint in robot.joints)
    options = robot._options()
    options["base"] = new(options["base"])
    for of_frames in ("masses", "shapes", "meshes"):
        options[of_frames] = {new(frame): value for frame, value in options[of_frames].items()}
    disabled = options["disabled_collisions"].items()
    options["disabled_collisions"] = {(new(first), new(second)): reason for (first, second), reason in disabled}
    return joints, options


def _fixed(robot: Any, name: str, parent: str, child: str, pose: object) -> Joint:
    """A fixed joint at ``pose``, with a name of its own."""
    own = _unique(name, {joint.name for joint in robot.joints})
    return Joint(own, JointType.FIXED, parent, child, origin=read_pose(pose, "pose"))


def _unique(name: str, taken: Collection[str]) -> str:
    """The name, with a number appended where it is taken."""
    unique, number = name, 2
    while unique in taken:
        unique, number = f"{name} ({number})", number + 1
    return unique


def reduced_robot(build: Callable[[], Robot], full: Robot, locked: Array) -> Robot:
    """A robot made by `Robot.subset`, or restored from a pickle of one.

    Args:
        build: makes the robot.
        full: the robot it was made from.
        locked: configuration (full.nq,) at which the joints of ``full`` are locked.
    """
    robot = build()
    object.__setattr__(robot, "_reduction", Reduction.of(full, locked, robot.joint_names))
    return robot
