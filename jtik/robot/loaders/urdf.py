"""The joints of a URDF, read from its XML: what MuJoCo does not keep.

MuJoCo drops the names of fixed joints and the velocity limits. How it reads limits, ``continuous`` and ``mimic``
depends on its version. Origins, axes, masses and shapes are read by MuJoCo.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from xml.etree.ElementTree import Element

from jtik.errors import RobotFileError
from jtik.robot.loaders.robot_description import JointCoupling
from jtik.robot.loaders.source import Source

TYPES = ("revolute", "continuous", "prismatic", "fixed", "floating", "planar", "spherical")
"""The joint types that are accepted; "spherical" is a ball joint of PyBullet's dialect."""

LOOPS = ("loop_joint", "loop", "closed_loop")
"""Elements of dialects that close a kinematic loop."""

_SCALAR = ("revolute", "continuous", "prismatic")


@dataclass(frozen=True, kw_only=True)
class UrdfJoint:
    """One joint of a URDF.

    Attributes:
        name: its name.
        type: one of `TYPES`.
        parent: the link that carries it.
        child: the link that it moves.
        lower: lower limit [rad] or [m]; -inf when there is none.
        upper: upper limit [rad] or [m]; inf when there is none.
        velocity_limit: maximum speed [rad/s] or [m/s]; inf when there is none.
        effort_limit: maximum torque [N m] or force [N]; inf when there is none.
        coupling: the coupling to the joint that it mimics, or None.
    """

    name: str
    type: str
    parent: str
    child: str
    lower: float
    upper: float
    velocity_limit: float
    effort_limit: float
    coupling: JointCoupling | None


@dataclass(frozen=True, kw_only=True)
class UrdfTree:
    """The links and joints of a URDF.

    Attributes:
        root: the link that no joint moves.
        joints: the joints by the link that they move.
        notes: one sentence for each part that is not kept.
        changes: one sentence for each part that is read otherwise than it is written.
    """

    root: str
    joints: dict[str, UrdfJoint]
    notes: tuple[str, ...]
    changes: tuple[str, ...]


def read_tree(source: Source) -> UrdfTree:
    """The tree of a URDF.

    Raises:
        RobotFileError: when links and joints do not form a tree, or a joint cannot be used; it names the element.
    """
    links = _unique_names(source, "link")
    _unique_names(source, "joint")
    scalar = [joint.get("name", "") for joint in source.root.findall("joint") if joint.get("type") in _SCALAR]
    if not links:
        other = "; an SRDF belongs to a URDF, which has the links" if source.root.find("group") is not None else ""
        raise RobotFileError(source.label, "", f"not a robot: it has no link; accepted: at least one link{other}")
    joints: dict[str, UrdfJoint] = {}
    notes = [
        f"the <{element.tag}> {element.get('name', '')!r} is not kept: the loop stays open"
        for element in source.root.iter()
        if element.tag in LOOPS
    ]
    changes: list[str] = []
    for element in source.root.findall("joint"):
        joint = _read_joint(source, element, links, changes)
        if joint.child in joints:
            problem = f"moved by the joints {joints[joint.child].name!r} and {joint.name!r}, where one is accepted"
            raise RobotFileError(source.label, f"link {joint.child!r}", problem)
        if joint.coupling is not None and joint.coupling.leader not in scalar:
            leader = f"{joint.coupling.leader!r}, which is not a revolute, continuous or prismatic joint"
            notes.append(f"joint {joint.name!r} stays independent: it mimics {leader}")
            joint = replace(joint, coupling=None)
        joints[joint.child] = joint
    roots = [link for link in links if link not in joints]
    if not roots:
        raise RobotFileError(source.label, "", "not a tree: every link is a child; accepted: one root link")
    if len(roots) > 1:
        problem = f"not a tree: the links {', '.join(map(repr, roots))} have no parent; accepted: one root link"
        raise RobotFileError(source.label, "", problem)
    _check_connected(source, roots[0], joints)
    if "world" in joints:
        raise RobotFileError(source.label, "link 'world'", "only the root may have this name")
    return UrdfTree(root=roots[0], joints=joints, notes=tuple(notes), changes=tuple(changes))


def _read_joint(source: Source, element: Element, links: list[str], changes: list[str]) -> UrdfJoint:
    name = element.get("name", "")
    where = f"joint {name!r}"
    kind = element.get("type", "")
    if kind not in TYPES:
        raise RobotFileError(source.label, where, f"unknown type {kind!r}; accepted: {', '.join(TYPES)}")
    ends = []
    for end in ("parent", "child"):
        found = element.find(end)
        link = "" if found is None else found.get("link", "")
        if link not in links:
            raise RobotFileError(source.label, where, f"its {end} {link!r} is not a link of the file")
        ends.append(link)
    _check_triples(source, where, element)
    limit = element.find("limit")
    lower, upper, speed = _read_limits(source, where, kind, limit, changes)
    mimic = element.find("mimic")
    coupling = None
    if mimic is not None and kind in _SCALAR:
        coupling = JointCoupling(
            joint=name,
            leader=mimic.get("joint", ""),
            multiplier=_number(source, where, mimic, "multiplier", 1.0),
            offset=_number(source, where, mimic, "offset", 0.0),
        )
    return UrdfJoint(
        name=name,
        type=kind,
        parent=ends[0],
        child=ends[1],
        lower=lower,
        upper=upper,
        velocity_limit=speed,
        effort_limit=math.inf if limit is None or kind not in _SCALAR else _read_effort(where, limit, changes),
        coupling=coupling,
    )


def _check_triples(source: Source, where: str, joint: Element) -> None:
    """Check that origins and axes are three finite numbers; MuJoCo's error does not name the joint."""
    for tag, attribute in (("origin", "xyz"), ("origin", "rpy"), ("axis", "xyz")):
        element = joint.find(tag)
        text = None if element is None else element.get(attribute)
        if text is None:
            continue
        try:
            numbers = [float(word) for word in text.split()]
        except ValueError:
            numbers = []
        if len(numbers) != 3 or not all(map(math.isfinite, numbers)):
            problem = f"{attribute}={text!r} in <{tag}>; accepted: three numbers"
            raise RobotFileError(source.label, where, problem)


def _read_limits(
    source: Source, where: str, kind: str, limit: Element | None, changes: list[str]
) -> tuple[float, float, float]:
    """Lower, upper and velocity limit; infinite where there is none.

    Limits that are both zero, and a velocity of zero, count as none: exporters write them for joints without limits.
    Where both zeros and an effort are written, the joint is locked. A lower limit above the upper one means no limits,
    as in PyBullet.
    """
    if limit is None or kind not in _SCALAR:
        return -math.inf, math.inf, math.inf
    speed = abs(_number(source, where, limit, "velocity", 0.0, finite=False)) or math.inf
    lower = _number(source, where, limit, "lower", 0.0, finite=False)
    upper = _number(source, where, limit, "upper", 0.0, finite=False)
    if kind == "continuous" or (lower == upper == 0.0 and not _is_locked(source, where, limit)):
        return -math.inf, math.inf, speed
    if lower > upper:
        changes.append(f"{where} has no limits: its lower limit {lower:g} is above its upper limit {upper:g}")
        return -math.inf, math.inf, speed
    if lower == math.inf or upper == -math.inf:
        problem = f"its limits are lower {lower:g}, upper {upper:g}; accepted: a range with numbers in it"
        raise RobotFileError(source.label, where, problem)
    return lower, upper, speed


def _read_effort(where: str, limit: Element, changes: list[str]) -> float:
    """The effort limit; infinite where there is none, or zero, which exporters write for it, or no number."""
    text = limit.get("effort", "0")
    try:
        effort = abs(float(text))
    except ValueError:
        effort = math.nan
    if math.isnan(effort):
        changes.append(f"{where} has no effort limit: effort={text!r} in <limit> is not a number")
        return math.inf
    return effort or math.inf


def _is_locked(source: Source, where: str, limit: Element) -> bool:
    """Whether both limits and an effort other than zero are written."""
    written = limit.get("lower") is not None and limit.get("upper") is not None
    return written and _number(source, where, limit, "effort", 0.0, finite=False) != 0.0


def _number(
    source: Source, where: str, element: Element, attribute: str, default: float, *, finite: bool = True
) -> float:
    text = element.get(attribute)
    if text is None:
        return default
    try:
        value = float(text)
    except ValueError as error:
        problem = f"{attribute}={text!r} in <{element.tag}> is not a number"
        raise RobotFileError(source.label, where, problem) from error
    if math.isnan(value) or (finite and math.isinf(value)):
        raise RobotFileError(source.label, where, f"{attribute}={text!r} in <{element.tag}>; accepted: a number")
    return value


def _unique_names(source: Source, tag: str) -> list[str]:
    names: dict[str, None] = {}
    for element in source.root.findall(tag):
        name = element.get("name", "")
        if not name:
            raise RobotFileError(source.label, f"a <{tag}>", "it has no name; accepted: a name of its own")
        if name in names:
            raise RobotFileError(source.label, f"{tag} {name!r}", f"the name of two {tag}s, where each needs its own")
        names[name] = None
    return list(names)


def _check_connected(source: Source, root: str, joints: dict[str, UrdfJoint]) -> None:
    connected = {root}
    for link in joints:
        path: dict[str, None] = {}
        for above in _upward(link, joints):
            if above in connected:
                break
            if above in path:
                raise RobotFileError(source.label, f"link {above!r}", "not a tree: it is its own ancestor")
            path[above] = None
        connected.update(path)


def _upward(link: str, joints: dict[str, UrdfJoint]) -> Iterator[str]:
    while True:
        yield link
        link = joints[link].parent
