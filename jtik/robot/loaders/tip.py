"""The frame of the end effector of a robot from a file, where none is named."""

from __future__ import annotations

import re
from collections.abc import Sequence

from jtik.robot.tree import Joint

TOOL_NAMES = ("tool0", "tcp", "attachment_site", "end_effector", "eef", "ee", "tool", "tip")
"""Names of tool frames, the most reliable first; also as a separate word in a longer name."""


def tool_frame(joints: Sequence[Joint], base: str) -> str:
    """The frame of the end effector.

    It is the first moving frame with a name of `TOOL_NAMES`; without one, the end of the longest chain of joints and of
    the frames fixed to it. Frames beyond coupled joints, such as fingers, are left out.
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
    candidates = [frame for frame in moved if frame not in beyond] or moved or list(depth)
    for name in TOOL_NAMES:
        word = re.compile(rf"(?<![a-z0-9]){name}(?![a-z0-9])", re.IGNORECASE)
        found = [frame for frame in candidates if word.search(frame)]
        if found:
            return found[0]
    return max(candidates, key=lambda frame: depth[frame])
