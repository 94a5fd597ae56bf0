"""The frame of the end effector of a robot from a file, where none is named."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence

from jtik.robot.tree import Joint

TOOL_NAMES = ("tool0", "tcp", "attachment_site", "end_effector", "eef", "ee", "tool", "gripper", "hand", "tip")
"""Names of tool frames, the most reliable first; also as a separate word in a longer name."""

_AT_THE_END = ("gripper", "hand")
"""Names that only count as the last word of a frame, before "link": a "hand_camera" is not a tool."""

_OF_FINGERS, _ALSO_OF_FINGERS = ("tip",), re.compile(r"finger|thumb|knuckle|phalan", re.IGNORECASE)
"""Names that fingers have, too, and the words of frames that are parts of fingers."""


def tool_frame(joints: Sequence[Joint], base: str) -> str:
    """The frame of the end effector.

    It is the first moving frame with a name of `TOOL_NAMES`; without one, the end of the longest chain of joints and of
    the frames fixed to it, where fingers are left out. Fingers are what coupled joints move, unless a joint that is not
    coupled moves beyond them, all of them are in series, or the frames left are moved by fewer than half of the
    independent joints of the longest chain: then the couplings are those of a linkage.
    """
    depth = {base: (0, 0)}
    for joint in joints:
        moving, fixed = depth[joint.parent]
        depth[joint.child] = (moving + 1, 0) if joint.is_moving else (moving, fixed + 1)
    moved = [frame for frame, (moving, _) in depth.items() if moving]
    fingers = _fingers(joints, base)
    outside = [frame for frame in moved if frame not in fingers] or moved or list(depth)
    for name in TOOL_NAMES:
        tool = next((frame for frame in _with_fingers_last(name, outside, moved) if _is_named(frame, name)), None)
        if tool is not None:
            return tool
    return max(outside, key=lambda frame: depth[frame])


def _with_fingers_last(name: str, outside: Iterable[str], moved: Iterable[str]) -> Iterable[str]:
    """The frames that may be called ``name``: those outside fingers before the others."""
    yield from outside
    if name not in _OF_FINGERS:
        yield from (frame for frame in moved if not _ALSO_OF_FINGERS.search(frame))


def _is_named(frame: str, name: str) -> bool:
    end = r"(_?link)?$" if name in _AT_THE_END else "(?![a-z0-9])"
    return re.search(f"(?<![a-z0-9]){name}{end}", frame, re.IGNORECASE) is not None


def _fingers(joints: Sequence[Joint], base: str) -> set[str]:
    """The frames of fingers: those that coupled joints move, unless the couplings are those of a linkage."""
    coupled = {name for joint in joints if joint.mimic is not None for name in (joint.name, joint.mimic.joint)}
    path: dict[str, tuple[Joint, ...]] = {base: ()}
    for joint in joints:
        path[joint.child] = (*path[joint.parent], joint)
    carriers = {
        above.name
        for joint in joints
        if joint.is_moving and joint.name not in coupled
        for above in path[joint.parent]
        if above.name in coupled
    }
    if any(coupled <= {joint.name for joint in way} for way in path.values()):
        return set()
    roots = coupled - carriers
    fingers = {frame for frame, way in path.items() if any(joint.name in roots for joint in way)}
    left = max(_independent(way) for frame, way in path.items() if frame not in fingers)
    return set() if 0 < left < max(map(_independent, path.values())) / 2 else fingers


def _independent(path: Sequence[Joint]) -> int:
    return sum(joint.is_independent for joint in path)
