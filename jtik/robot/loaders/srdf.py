"""SRDF: the pairs of links whose collisions are disabled, and named states of groups of joints as keyframes.

Groups, end effectors, virtual and passive joints are not read: a state names its joints.
``disable_default_collisions`` of a link disables all its pairs, ``enable_collisions`` enables one again.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NoReturn
from xml.etree.ElementTree import Element

import numpy as np

from jtik.errors import RobotFileError
from jtik.robot.loaders.robot_description import RobotDescription
from jtik.robot.loaders.source import PathOrText, Source, open_source
from jtik.types import Array


def with_srdf(description: RobotDescription, path_or_xml: PathOrText) -> RobotDescription:
    """The same robot with the disabled collisions and the keyframes of an SRDF.

    Links and joints that the robot does not have are noted: one SRDF is often shared by variants of a robot.

    Args:
        description: the robot, whose couplings are mimic joints.
        path_or_xml: the path of an SRDF file, or text that starts with "<". A XACRO is expanded.

    Raises:
        RobotFileError: when there is no such file, it is not an SRDF, an element of it cannot be used, or none of its
            links and joints is one of the robot's.
    """
    source = open_source(path_or_xml, kind="SRDF", root="robot", argument="srdf")
    if source.root.find("joint") is not None or source.root.find("link") is not None:
        raise RobotFileError(source.label, "", "not SRDF: it has links or joints of its own, as a URDF has")
    reader = _Reader(source, description)
    disabled = reader.disabled()
    keyframes = reader.keyframes()
    reader.check_is_of_this_robot()
    return replace(
        description,
        disabled_collisions=disabled,
        keyframes=keyframes,
        notes=(*description.notes, *reader.notes()),
    )


class _Reader:
    """Reads one SRDF for one robot."""

    def __init__(self, source: Source, description: RobotDescription) -> None:
        self._source = source
        self._links = (description.base, *(joint.child for joint in description.joints))
        self._joints = {joint.name: joint for joint in description.joints}
        self._known = 0
        self._unknown_links: dict[str, None] = {}
        self._unknown_joints: dict[str, None] = {}

    def disabled(self) -> dict[tuple[str, str], str]:
        """The pairs of the robot's links that are disabled, with the reasons that are written."""
        pairs: dict[frozenset[str], str] = {}
        for element in self._source.root.findall("disable_default_collisions"):
            (link,) = self._named_links(element, "link")
            if self._has_link(link):
                pairs |= {frozenset((link, other)): "by default" for other in self._links if other != link}
        for tag in ("enable_collisions", "disable_collisions"):
            for element in self._source.root.findall(tag):
                links = self._named_links(element, "link1", "link2")
                if links[0] == links[1]:
                    self._fail(element, f"the link {links[0]!r} twice; accepted: two links")
                known = [self._has_link(link) for link in links]  # each of them, for the note
                if not all(known):
                    continue
                if tag == "enable_collisions":
                    pairs.pop(frozenset(links), None)
                else:
                    pairs[frozenset(links)] = element.get("reason", "")
        order = {link: i for i, link in enumerate(self._links)}
        return {(min(pair, key=order.get), max(pair, key=order.get)): reason for pair, reason in pairs.items()}  # type: ignore[arg-type]

    def keyframes(self) -> dict[str, dict[str, Array]]:
        """The states, by name; joints that a state does not name have no entry.

        States of the same name of several groups are one keyframe where no joint has two positions, else the later
        ones are called "NAME (GROUP)".
        """
        found: dict[str, dict[str, Array]] = {}
        for element in self._source.root.findall("group_state"):
            name, group = self._attribute(element, "name"), element.get("group", "")
            positions = self._positions(element)
            if not positions:
                continue
            before = found.get(name, {})
            if any(not np.array_equal(before[joint], positions[joint]) for joint in before.keys() & positions.keys()):
                name, before = f"{name} ({group})", {}
            found[name] = {**before, **positions}
        return found

    def _positions(self, state: Element) -> dict[str, Array]:
        positions: dict[str, Array] = {}
        for element in state.findall("joint"):
            name, text = element.get("name"), element.get("value")
            if name is None or text is None:
                self._fail(state, "a <joint> without name or value; accepted: both")
            numbers = _numbers(text)
            if numbers is None:
                self._fail(state, f"joint {name!r} has the value {text!r}; accepted: finite numbers")
            joint = self._joints.get(name)
            if joint is None and len(numbers) == 7 and "free_base" in self._joints:
                joint = self._joints["free_base"]  # its virtual joint
            if joint is None:
                self._unknown_joints[name] = None
                continue
            self._known += 1
            if not joint.is_independent:
                continue
            if len(numbers) != joint.type.nq:
                self._fail(state, f"joint {name!r} has {len(numbers)} numbers, where {joint.type.nq} are accepted")
            if joint.type.quaternion_start is not None:
                numbers = np.concatenate([numbers[:-4], numbers[-1:], numbers[-4:-1]])  # x, y, z, w in a file
                if not numbers[-4:].any():
                    self._fail(state, f"joint {name!r} has a zero quaternion; accepted: x, y, z, w of one")
            positions[joint.name] = numbers
        return positions

    def check_is_of_this_robot(self) -> None:
        """Raise RobotFileError where the robot has none of the links and joints that the file names."""
        missing = [*self._unknown_links, *self._unknown_joints]
        if missing and not self._known:
            problem = f"the robot has none of its links and joints, such as {missing[0]!r}; accepted: its own SRDF"
            raise RobotFileError(self._source.label, "", problem)

    def notes(self) -> list[str]:
        """One sentence for the links, and one for the joints, that the robot does not have."""
        label = self._source.label
        return [
            f"{label} names {what} that the robot does not have: {', '.join(names)}"
            for what, names in (("links", self._unknown_links), ("joints", self._unknown_joints))
            if names
        ]

    def _has_link(self, link: str) -> bool:
        if link in self._links:
            self._known += 1
            return True
        self._unknown_links[link] = None
        return False

    def _named_links(self, element: Element, *attributes: str) -> tuple[str, ...]:
        return tuple(self._attribute(element, attribute) for attribute in attributes)

    def _attribute(self, element: Element, attribute: str) -> str:
        found = element.get(attribute)
        if not found:
            self._fail(element, f"it has no {attribute}; accepted: {attribute}=, a name")
        return found

    def _fail(self, element: Element, problem: str) -> NoReturn:
        raise RobotFileError(self._source.label, _title(element), problem)


def _title(element: Element) -> str:
    """The tag of an element, and the names in it."""
    names = [element.get(key) for key in ("name", "link", "link1", "link2")]
    return " ".join([element.tag, *(repr(name) for name in names if name)])


def _numbers(text: str) -> Array | None:
    try:
        numbers = np.array([float(word) for word in text.split()])
    except ValueError:
        return None
    return numbers if len(numbers) and all(map(math.isfinite, numbers)) else None
