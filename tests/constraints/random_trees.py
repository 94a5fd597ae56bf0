"""Random trees with every joint type before and after every other, and kinematics of their own for many samples."""

from __future__ import annotations

import math

import numpy as np
from scipy.spatial.transform import Rotation

import jtik
from jtik.robot import Joint, JointType, Mimic

TYPES = (JointType.REVOLUTE, JointType.PRISMATIC, JointType.BALL, JointType.FREE)


def tree(rng, size):
    """A tree of ``size`` joints of all types, some of them mimic, and listed in any order."""
    joints, frames = [], ["base"]
    for i in range(size):
        kind = TYPES[rng.choice(4, p=(0.4, 0.4, 0.12, 0.08))]
        leaders = [joint.name for joint in joints if joint.type.is_scalar and joint.mimic is None]
        mimic, limits = None, {}
        if kind.is_scalar and leaders and rng.random() < 0.3:
            mimic = Mimic(str(rng.choice(leaders)), rng.choice([-1, 1]) * rng.uniform(0.5, 3.0), rng.uniform(-0.5, 0.5))
            if rng.random() < 0.4:  # limits of its own, which the leader at zero keeps
                limits = {"lower": -rng.uniform(0.8, 3.0), "upper": rng.uniform(0.8, 3.0)}
        elif kind.is_scalar:
            sides = rng.random(2) < 0.4
            lower = -rng.uniform(0.8, 3.0) if sides[0] else -math.inf
            limits = {"lower": lower, "upper": rng.uniform(0.8, 3.0) if sides[1] else math.inf}
        origin = np.eye(4)
        origin[:3, :3] = Rotation.random(random_state=int(rng.integers(1 << 30))).as_matrix()
        origin[:3, 3] = rng.uniform(-0.4, 0.4, 3)
        axis = rng.standard_normal(3)
        parent = frames[-1] if rng.random() < 0.8 else str(rng.choice(frames))
        joints.append(
            Joint(
                f"joint{i}",
                kind,
                parent,
                f"frame{i}",
                origin=origin,
                axis=axis / np.linalg.norm(axis),
                mimic=mimic,
                **limits,
            )
        )
        frames.append(f"frame{i}")
    # the end is off the last axis, so that every joint moves it
    end = np.eye(4)
    end[:3, 3] = 0.3, 0.2, 0.1
    joints.append(Joint("end", JointType.FIXED, frames[-1], "end", origin=end))
    order = rng.permutation(len(joints))
    return jtik.Robot([joints[i] for i in order], tip="end")


def far_out(robot, rng):
    """A configuration within the limits, with prismatic joints and free bases without limits up to 5 m out."""
    q = robot.random_configuration(rng)
    for joint in robot.joints:
        place = robot.q_slice(joint.name) if joint.is_independent else slice(0)
        if joint.type is JointType.FREE:
            q[place.start : place.start + 3] *= rng.uniform(0, 5)
        elif joint.type is JointType.PRISMATIC:
            q[place] = np.clip(q[place] * rng.uniform(0, 5), robot.lower[place], robot.upper[place])
    return q


def positions(robot, q):
    """Positions of all frames by name, (samples, 3) each, for configurations (samples, nq)."""
    found = {robot.base: (Rotation.identity(len(q)), np.zeros((len(q), 3)))}
    waiting = list(robot.joints)
    while waiting:
        ready = [joint for joint in waiting if joint.parent in found]
        for joint in ready:
            found[joint.child] = _after(*found[joint.parent], joint, q, robot)
            waiting.remove(joint)
    return {frame: place for frame, (_, place) in found.items()}


def _after(rotation, place, joint, q, robot):
    """Rotation and position of a joint's child."""
    origin = np.array(joint.origin)
    place = place + rotation.apply(origin[:3, 3])
    rotation = rotation * Rotation.from_matrix(origin[:3, :3])
    if joint.type is JointType.FIXED:
        return rotation, place
    own = q[:, robot.q_slice(joint.name)]
    if joint.mimic is not None:
        own = joint.mimic.multiplier * own + joint.mimic.offset
    if joint.type is JointType.REVOLUTE:
        return rotation * Rotation.from_rotvec(own * joint.axis), place
    if joint.type is JointType.PRISMATIC:
        return rotation, place + rotation.apply(own * joint.axis)
    if joint.type is JointType.FREE:
        place, own = place + rotation.apply(own[:, :3]), own[:, 3:]
    return rotation * Rotation.from_quat(own, scalar_first=True), place


def path(robot, start, end, samples):
    """Configurations on the straight path of a step, (samples, nq): quaternions turn about one axis."""
    share = np.linspace(0, 1, samples)[:, None]
    q = start + share * (end - start)
    for joint in robot.joints:
        if joint.type.quaternion_start is not None and joint.mimic is None:
            place = robot.q_slice(joint.name)
            place = slice(place.start + joint.type.quaternion_start, place.stop)
            first, last = (Rotation.from_quat(each[place], scalar_first=True) for each in (start, end))
            q[:, place] = (first * Rotation.from_rotvec(share * (first.inv() * last).as_rotvec())).as_quat(
                scalar_first=True
            )
    return q
