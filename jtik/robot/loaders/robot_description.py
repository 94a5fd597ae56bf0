"""What a file says about a robot: the arguments of `Robot`, and which joints follow which."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any

from jtik.geometry import Solid
from jtik.robot.body import Mass
from jtik.robot.loaders.tip import tool_frame
from jtik.robot.tree import Joint
from jtik.types import Array


@dataclass(frozen=True, kw_only=True)
class Follow:
    """``position(joint) = multiplier * position(leader) + offset``, as a file states it.

    Attributes:
        joint: name of the joint that follows.
        leader: name of the joint that it follows; None when it is held at ``offset``.
        multiplier: ratio of the positions; 0 holds it at ``offset``, too.
        offset: position [rad] or [m] when the leader is at zero.
    """

    joint: str
    leader: str | None
    multiplier: float
    offset: float


@dataclass(frozen=True, kw_only=True)
class RobotDescription:
    """A robot as read, before the joints that follow others are folded into them.

    Attributes:
        label: the file, or what stands for it.
        name: what the file calls it; empty when it does not say.
        base: the root frame.
        joints: the tree, depth first.
        follows: joints that follow others.
        masses: mass on each frame that has one.
        shapes: solids on each frame that has any.
        keyframes: names and positions of every moving joint, by joint name, (nq of the joint,).
        notes: what could not be kept, a sentence each.
    """

    label: str
    name: str
    base: str
    joints: tuple[Joint, ...]
    follows: tuple[Follow, ...] = ()
    masses: dict[str, Mass] = field(default_factory=dict)
    shapes: dict[str, list[Solid]] = field(default_factory=dict)
    keyframes: dict[str, dict[str, Array]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def tip(self) -> str:
        """The frame that works where none is named; see `tool_frame`."""
        return tool_frame(self.joints, self.base)

    def arguments(self) -> dict[str, Any]:
        """The arguments of `Robot`, but for the tip; to be called when nothing follows any more."""
        moving = [joint.name for joint in self.joints if joint.is_independent]
        return {
            "joints": self.joints,
            "base": self.base,
            "masses": self.masses,
            "shapes": self.shapes,
            "keyframes": {
                key: [number for joint in moving for number in positions[joint]]
                for key, positions in self.keyframes.items()
            },
        }


class Names:
    """Gives every frame, or every joint, a name of its own."""

    def __init__(self) -> None:
        self._taken: set[str] = set()

    def reserve(self, names: Iterable[str]) -> None:
        """Take names that a file gives, so that no made-up one gets in their way."""
        self._taken.update(name for name in names if name)

    def unique(self, wanted: str, suffix: str = "") -> str:
        """``wanted`` when it is free, else with " (suffix)" or a number behind it."""
        candidates = [wanted, f"{wanted} ({suffix})"] if suffix else [wanted]
        number = 2
        while candidates[0] in self._taken:
            candidates = candidates[1:] or [f"{wanted} ({suffix} {number})" if suffix else f"{wanted} ({number})"]
            number += 1
        self._taken.add(candidates[0])
        return candidates[0]
