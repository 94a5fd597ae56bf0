"""Random trees of joints for sweeps, with forward kinematics of their own in NumPy.

Revolute, prismatic, ball and mimic joints come before and after each other in every order; limits are there, one-sided
or absent; lengths are from a tenth of a millimetre to a kilometre.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

import jtik
from jtik.robot import Joint, JointType, Mimic

SCALES = (1e-4, 1e-2, 1.0, 1.0, 1.0, 30.0, 1e3)
"""Lengths of a link [m]; a metre is drawn more often."""


@dataclass(frozen=True)
class Tree:
    """A random robot, its joints, and kinematics that share no code with jtik.

    Attributes:
        robot: the robot.
        joints: its joints, in the order of q.
        scale: length of a link [m].
        tips: frames of end effectors, the deepest first.
    """

    robot: jtik.Robot
    joints: tuple[Joint, ...]
    scale: float
    tips: tuple[str, ...]

    @property
    def own(self) -> list[Joint]:
        """The joints that have entries in q."""
        return [joint for joint in self.joints if joint.type is not JointType.FIXED and joint.mimic is None]

    def positions(self, q: np.ndarray) -> dict[str, np.ndarray]:
        """The position of each joint that moves, (..., 1) or (..., 4), a mimic joint's from its leader."""
        result, at = {}, 0
        for joint in self.own:
            size = 4 if joint.type is JointType.BALL else 1
            result[joint.name] = q[..., at : at + size]
            at += size
        for joint in self.joints:
            if joint.mimic is not None:
                result[joint.name] = joint.mimic.multiplier * result[joint.mimic.joint] + joint.mimic.offset
        return result

    def columns(self) -> dict[str, slice]:
        """The velocity entries of each joint, a mimic joint's those of its leader."""
        result, at = {}, 0
        for joint in self.own:
            size = 3 if joint.type is JointType.BALL else 1
            result[joint.name] = slice(at, at + size)
            at += size
        return result | {joint.name: result[joint.mimic.joint] for joint in self.joints if joint.mimic is not None}

    def poses(self, q: np.ndarray) -> dict[str, np.ndarray]:
        """The pose (..., 4, 4) of every frame, for one configuration or for many."""
        values, result = self.positions(q), {"base": np.broadcast_to(np.eye(4), (*q.shape[:-1], 4, 4))}
        for joint in self.joints:  # parents come first
            result[joint.child] = result[joint.parent] @ joint.origin @ motion(joint, values.get(joint.name))
        return result

    def jacobian(self, q: np.ndarray, frame: str) -> np.ndarray:
        """The geometric Jacobian (6, n): linear rows, then angular ones."""
        poses, columns = self.poses(q), self.columns()
        J, end, carrier = np.zeros((6, self.robot.n)), poses[frame][:3, 3], {j.child: j for j in self.joints}
        while frame != "base":
            joint = carrier[frame]
            frame, pose = joint.parent, poses[joint.child]
            if joint.type is JointType.FIXED:
                continue
            gain = 1.0 if joint.mimic is None else joint.mimic.multiplier
            before = (poses[joint.parent] @ joint.origin)[:3, :3]
            axes = pose[:3, :3].T if joint.type is JointType.BALL else [before @ joint.axis]
            for k, axis in enumerate(axes):
                turns = joint.type is not JointType.PRISMATIC
                moment = np.cross(axis, end - pose[:3, 3]) if turns else axis
                J[:, columns[joint.name].start + k] += gain * np.concatenate([moment, axis if turns else 0 * axis])
        return J

    def between(self, start: np.ndarray, end: np.ndarray, shares: np.ndarray) -> np.ndarray:
        """The configurations (k, nq) at these shares of the path between two along which all joints move evenly."""
        shares, at = np.asarray(shares)[:, None], 0
        q = (1 - shares) * start + shares * end
        for joint in self.own:
            size = 4 if joint.type is JointType.BALL else 1
            if size == 4:
                a, b = (scipy_rotation(each[at : at + 4]) for each in (start, end))
                turned = a * Rotation.from_rotvec(shares * (a.inv() * b).as_rotvec())
                q[:, at : at + 4] = np.roll(turned.as_quat(), 1, axis=1)
            at += size
        return q

    def change(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """The displacement (n,) between two configurations, of ball joints in the moving frame."""
        parts, at = [], 0
        for joint in self.own:
            size = 4 if joint.type is JointType.BALL else 1
            before, after = start[at : at + size], end[at : at + size]
            turned = size == 4
            parts.append(
                (scipy_rotation(before).inv() * scipy_rotation(after)).as_rotvec() if turned else after - before
            )
            at += size
        return np.concatenate(parts)

    def outside(self, q: np.ndarray) -> float:
        """The largest violation of a limit, a mimic joint's among them; relative for a position above 1."""
        values, worst = self.positions(q), 0.0
        for joint in self.joints:
            if joint.type in (JointType.REVOLUTE, JointType.PRISMATIC):
                value = values[joint.name]
                beyond = np.maximum(joint.lower - value, value - joint.upper) / np.maximum(1.0, np.abs(value))
                worst = max(worst, float(beyond.max()))
        return worst

    def links(self, q: np.ndarray) -> np.ndarray:
        """Both ends of every link of the skeleton, (..., k, 2, d) [m]."""
        poses, d = self.poses(q), self.robot.dimension
        ends = [np.stack([poses[end][..., :d, 3] for end in segment], axis=-2) for segment in self.robot.segments]
        return np.stack(ends, axis=-3)

    def distances(self, q: np.ndarray, centers: np.ndarray, radii: np.ndarray) -> np.ndarray:
        """Distance of each link to each ball, (..., k, b) [m]."""
        links = self.links(q)
        a, along = links[..., :, None, 0, :], (links[..., 1, :] - links[..., 0, :])[..., :, None, :]
        squared = np.maximum((along**2).sum(-1), 1e-300)
        share = np.clip(((centers - a) * along).sum(-1) / squared, 0, 1)
        return np.linalg.norm(a + share[..., None] * along - centers, axis=-1) - radii


def scipy_rotation(quaternion: np.ndarray) -> Rotation:
    """The rotation of a quaternion (w, x, y, z)."""
    return Rotation.from_quat(np.roll(quaternion, -1, axis=-1))


def motion(joint: Joint, value: np.ndarray | None) -> np.ndarray:
    """The motion (..., 4, 4) of a joint at a position (..., 1) or (..., 4)."""
    if value is None:
        return np.eye(4)
    T = np.zeros((*value.shape[:-1], 4, 4)) + np.eye(4)
    if joint.type is JointType.REVOLUTE:
        T[..., :3, :3] = Rotation.from_rotvec(value * joint.axis).as_matrix()
    elif joint.type is JointType.PRISMATIC:
        T[..., :3, 3] = value * joint.axis
    else:
        T[..., :3, :3] = scipy_rotation(value).as_matrix()
    return T


def random_tree(rng: np.random.Generator) -> Tree:
    """A tree of four to eight moving joints and perhaps a branch; planar once in four times."""
    planar, scale = bool(rng.random() < 0.25), float(rng.choice(SCALES))
    types = [JointType.REVOLUTE, JointType.PRISMATIC] + [JointType.BALL] * (not planar)
    weights = np.array([0.65, 0.35]) if planar else np.array([0.6, 0.25, 0.15])
    joints, count = list[Joint](), int(rng.integers(4, 9))
    branch = int(rng.integers(1, count)) if rng.random() < 0.4 else count
    for k in range(count + (2 if branch < count else 0)):
        parent = f"link{k - 1}" if k else "base"
        if k == count:
            parent = f"link{branch - 1}"
        kind = types[rng.choice(len(types), p=weights)]
        leaders = [joint for joint in joints if joint.type is kind and joint.mimic is None]
        mimic = None
        if kind is not JointType.BALL and leaders and rng.random() < 0.2:
            leader = leaders[rng.integers(len(leaders))]
            offset = float(rng.uniform(-0.2, 0.2)) * (scale if kind is JointType.PRISMATIC else 1.0)
            mimic = Mimic(leader.name, float(rng.choice([-1, 1]) * rng.uniform(0.3, 2.0)), offset)
        lower, upper = limits(rng, kind, scale)
        if mimic is not None:  # its range contains that of the leader's middle
            lower, upper = (-np.inf, np.inf) if rng.random() < 0.5 else (4 * min(lower, 0), 4 * max(upper, 0))
        joints.append(
            Joint(
                f"joint{k}",
                kind,
                parent,
                f"link{k}",
                origin=origin(rng, planar, scale),
                axis=axis(rng, planar, kind),
                lower=lower,
                upper=upper,
                mimic=mimic,
            )
        )
    ends = [count - 1] + ([count + 1] if branch < count else [])
    for k in ends:
        place = origin(rng, planar, scale)
        joints.append(Joint(f"mount{k}", JointType.FIXED, f"link{k}", f"tip{k}", origin=place))
    tips = tuple(f"tip{k}" for k in ends)
    robot = jtik.Robot(joints, planar=planar, tip=tips[0])
    return Tree(robot, tuple(joints), scale, tips)


def limits(rng: np.random.Generator, kind: JointType, scale: float) -> tuple[float, float]:
    """Limits on both sides, on one, or none, with 0 between them."""
    if kind is JointType.BALL:
        return -np.inf, np.inf
    size = scale if kind is JointType.PRISMATIC else 1.0
    lower, upper = -float(rng.uniform(0.2, 2.5)) * size, float(rng.uniform(0.2, 2.5)) * size
    choice = rng.random()
    return (lower if choice < 0.6 else -np.inf), (upper if choice < 0.45 or 0.6 < choice < 0.75 else np.inf)


def origin(rng: np.random.Generator, planar: bool, scale: float) -> np.ndarray:
    """The pose of a joint in its parent: a link of about ``scale``, once in five times none; axes often aligned."""
    T = np.eye(4)
    length = 0.0 if rng.random() < 0.2 else scale * rng.uniform(0.3, 1.2)
    if planar:
        T[:3, :3] = Rotation.from_rotvec([0, 0, rng.uniform(-1, 1)]).as_matrix()
        T[:2, 3] = length * np.array([1.0, 0.0])
        return T
    aligned = rng.random() < 0.5
    turn = np.pi / 2 * rng.integers(0, 2) * np.eye(3)[rng.integers(3)] if aligned else rng.normal(size=3)
    T[:3, :3] = Rotation.from_rotvec(turn).as_matrix()
    direction = np.eye(3)[rng.integers(3)] if aligned else rng.normal(size=3)
    T[:3, 3] = length * direction / np.linalg.norm(direction)
    return T


def axis(rng: np.random.Generator, planar: bool, kind: JointType) -> np.ndarray:
    """The axis of a joint: one of the coordinates, or any."""
    if planar:
        turn = rng.uniform(-np.pi, np.pi)
        return np.array([0.0, 0.0, 1.0]) if kind is JointType.REVOLUTE else np.array([np.cos(turn), np.sin(turn), 0.0])
    direction = np.eye(3)[rng.integers(3)] if rng.random() < 0.6 else rng.normal(size=3)
    return direction / np.linalg.norm(direction)


def random_configuration(tree: Tree, rng: np.random.Generator, *, at_limit: float = 0.0) -> np.ndarray:
    """A configuration within the limits of all joints; each joint is at a limit with the probability ``at_limit``."""
    q, robot, at = [], tree.robot, 0
    for joint in tree.own:
        if joint.type is JointType.BALL:
            quaternion = rng.normal(size=4)
            q.append(quaternion / np.linalg.norm(quaternion))
            at += 4
            continue
        size = 2.0 * (tree.scale if joint.type is JointType.PRISMATIC else 1.0)
        lower, upper = max(robot.lower[at], -size), min(robot.upper[at], size)
        ends = [each for each in (robot.lower[at], robot.upper[at]) if np.isfinite(each)]
        value = rng.choice(ends) if ends and rng.random() < at_limit else rng.uniform(min(lower, upper), upper)
        q.append(np.array([value]))
        at += 1
    return np.concatenate(q)
