"""Which frame of a robot from a file is meant where none is named."""

from __future__ import annotations

import re
from collections.abc import Sequence

from jtik.robot.tree import Joint

TOOL_NAMES = ("tool0", "tcp", "attachment_site", "end_effector", "eef", "ee", "tool", "tip")
"""What the frame of a tool is called, the surest first; as a word of its own in a longer name, too."""


def tool_frame(joints: Sequence[Joint], base: str) -> str:
    """The frame that works.

    The first moving frame that is called like a tool, by `TOOL_NAMES`; without one, the end of the longest chain
    of joints and of what is fixed to it. Frames behind joints that follow others or lead them, as fingers do, are
    left out.
    """
    depth = {base: (0, 0)}
    coupled = {name for joint in joints if joint.mimic is not None for name in (joint.name, joint.mimic.joint)}
    beyond = set()
    for joint in joints:
        moving, fixed = depth[joint.parent]
        depth[joint.child] = (moving + 1, 0) if joint.is_moving else (moving, fixed + 1)
        if joint.parent in beyond or joint.name in coupled:
            beyond.add(joint.child)
    moved = [frame for frame, (moving, _) in depth.items() if moving]
    working = [frame for frame in moved if frame not in beyond] or moved or list(depth)
    for name in TOOL_NAMES:
        word = re.compile(rf"(?<![a-z0-9]){name}(?![a-z0-9])", re.IGNORECASE)
        found = [frame for frame in working if word.search(frame)]
        if found:
            return found[0]
    return max(working, key=lambda frame: depth[frame])
