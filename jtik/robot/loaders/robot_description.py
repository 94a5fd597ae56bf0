"""The content of a robot file: the arguments of `Robot`, and the couplings of its joints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from jtik.geometry import Solid
from jtik.robot.loaders.tip import tool_frame
from jtik.robot.masses_and_shapes import Mass
from jtik.robot.mesh import Mesh
from jtik.robot.tree import Joint
from jtik.types import Array


@dataclass(frozen=True, kw_only=True)
class JointCoupling:
    """The coupling ``position(joint) = multiplier * position(leader) + offset`` of a file.

    Attributes:
        joint: name of the follower.
        leader: name of the joint that it follows; None for the constant position ``offset``.
        multiplier: ratio of the positions; 0 for the constant position ``offset``.
        offset: position [rad] or [m] when the leader is at zero.
    """

    joint: str
    leader: str | None
    multiplier: float
    offset: float


@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """A robot as read from a file, before its couplings become mimic joints.

    Attributes:
        label: the path of the file, or a name for a text or a model, for errors.
        name: name of the robot in the file; empty without one.
        base: name of the root frame.
        joints: the tree, depth first.
        couplings: the couplings of joints.
        masses: the mass on each frame that has one.
        shapes: the solids on each frame that has any.
        meshes: the meshes on each frame that has any, for pictures.
        keyframes: for each keyframe the position of moving joints, by joint name, (nq of the joint,); the other joints
            are at `neutral`.
        neutral: the position of every moving joint in the neutral configuration, by joint name; None where the file
            has none.
        objects: names of the free joints of objects, which are not parts of the robot.
        disabled_collisions: pairs of frames whose collisions are not considered, each with its reason.
        notes: one sentence for each part of the file that is not kept.
        changes: one sentence for each part that is kept, but changed or completed.
    """

    label: str
    name: str
    base: str
    joints: tuple[Joint, ...]
    couplings: tuple[JointCoupling, ...] = ()
    masses: dict[str, Mass] = field(default_factory=dict)
    shapes: dict[str, list[Solid]] = field(default_factory=dict)
    meshes: dict[str, list[Mesh]] = field(default_factory=dict)
    keyframes: dict[str, dict[str, Array]] = field(default_factory=dict)
    neutral: dict[str, Array] | None = None
    objects: tuple[str, ...] = ()
    disabled_collisions: dict[tuple[str, str], str] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    changes: tuple[str, ...] = ()

    @property
    def tip(self) -> str:
        """The frame of the end effector where none is named; see `tool_frame`."""
        apart: set[str] = set()
        for joint in self.joints:
            if joint.name in self.objects or joint.parent in apart:
                apart.add(joint.child)
        return tool_frame([joint for joint in self.joints if joint.child not in apart], self.base)

    def arguments(self) -> dict[str, Any]:
        """The arguments of `Robot` without the tip; call it when no couplings are left."""
        moving = [joint.name for joint in self.joints if joint.is_independent]

        def configuration(positions: dict[str, Array]) -> dict[str, Array]:
            return {joint: positions[joint] for joint in moving if joint in positions}

        return {
            "joints": self.joints,
            "base": self.base,
            "masses": self.masses,
            "shapes": self.shapes,
            "meshes": self.meshes,
            "keyframes": {key: configuration(positions) for key, positions in self.keyframes.items()},
            "neutral": None if self.neutral is None else configuration(self.neutral),
            "ignored": self.notes,
            "disabled_collisions": self.disabled_collisions,
        }


class Names:
    """Gives every frame, or every joint, a unique name."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def reserve(self, names: Iterable[str]) -> None:
        """Reserve the names of a file, so that no generated name equals one of them."""
        self._taken.update(name for name in names if name)

    def unique(self, preferred: str, suffix: str = "") -> str:
        """``preferred`` when it is free, else with " (suffix)" or a number appended."""
        candidates = [preferred, f"{preferred} ({suffix})"] if suffix else [preferred]
        number = 2
        while candidates[0] in self._taken:
            candidates = candidates[1:] or [f"{preferred} ({suffix} {number})" if suffix else f"{preferred} ({number})"]
            number += 1
        self._taken.add(candidates[0])
        return candidates[0]
