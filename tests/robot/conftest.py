from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jtik.robot import Joint, JointType, Mimic, Robot


def pose(translation=(0.0, 0.0, 0.0), rotvec=(0.0, 0.0, 0.0)):
    result = np.eye(4)
    result[:3, :3] = Rotation.from_rotvec(rotvec).as_matrix()
    result[:3, 3] = translation
    return result


def unit(*vector):
    return np.array(vector) / np.linalg.norm(vector)


def make_mixed():
    """Every type of joint, skew axes and origins, two fixed frames, a branch."""
    return Robot(
        [
            Joint("float", JointType.FREE, "world", "hull"),
            Joint(
                "turret",
                JointType.REVOLUTE,
                "hull",
                "turret",
                origin=pose((0.1, 0.2, 0.3), (0.3, -0.2, 0.5)),
                axis=unit(1, 2, 3),
                lower=-1.0,
                upper=2.0,
            ),
            Joint("mount", JointType.FIXED, "turret", "mount", origin=pose((0.0, 0.4, -0.1), (0.0, 1.1, 0.2))),
            Joint(
                "boom",
                JointType.PRISMATIC,
                "mount",
                "boom",
                origin=pose((0.2, 0.0, 0.1)),
                axis=unit(0, 1, -1),
                lower=0.1,
                upper=0.9,
                velocity_limit=0.5,
            ),
            Joint("shoulder", JointType.BALL, "boom", "arm", origin=pose((0.0, 0.3, 0.0), (0.7, 0.0, 0.0))),
            Joint("side", JointType.REVOLUTE, "hull", "side", origin=pose((-0.3, 0.0, 0.2)), axis=unit(0, -1, 0)),
            Joint(
                "elbow",
                JointType.REVOLUTE,
                "arm",
                "forearm",
                origin=pose((0.5, 0.0, 0.0), (0.0, np.pi / 2, 0.0)),
                axis=unit(1, 0, 0),
            ),
            Joint("wrist", JointType.REVOLUTE, "forearm", "hand", origin=pose((0.4, 0.1, 0.0)), axis=unit(-1, 0, 0)),
            Joint("tool", JointType.FIXED, "hand", "tool", origin=pose((0.0, 0.1, 0.2), (0.4, 0.4, 0.0))),
        ],
        name="mixed",
        base="world",
    )


def make_gripper():
    """A lift whose two fingers follow one joint, the second with a negative ratio."""
    return Robot(
        [
            Joint("lift", JointType.REVOLUTE, "base", "lift", axis=unit(0, 1, 0), origin=pose((0, 0, 0.5))),
            Joint(
                "left",
                JointType.PRISMATIC,
                "lift",
                "left",
                axis=unit(0, 1, 0),
                lower=0.0,
                upper=0.04,
                origin=pose((0.3, 0, 0)),
            ),
            Joint(
                "right",
                JointType.PRISMATIC,
                "lift",
                "right",
                axis=unit(0, 1, 0),
                origin=pose((0.3, 0, 0)),
                lower=-0.05,
                upper=0.0,
                velocity_limit=3.0,
                mimic=Mimic("left", -2.0, 0.01),
            ),
            Joint(
                "nail",
                JointType.REVOLUTE,
                "left",
                "nail",
                origin=pose((0.1, 0, 0)),
                axis=unit(0, 0, 1),
                mimic=Mimic("lift", 0.5, 0.2),
            ),
            Joint("nail_tip", JointType.FIXED, "nail", "nail_tip", origin=pose((0.05, 0.0, 0.01))),
        ],
        name="gripper",
    )


def make_arm():
    """Six revolute joints with three parallel axes and a spherical wrist-like end."""
    half = np.pi / 2
    rows = [(0, half, 0.16, 0), (-0.42, 0, 0, 0.3), (-0.39, 0, 0, 0), (0, half, 0.13, 0), (0, -half, 0.1, 0)]
    return Robot.from_dh([*rows, (0, 0, 0.1, 0)])


ROBOTS = {
    "mixed": make_mixed,
    "gripper": make_gripper,
    "arm": make_arm,
    "planar": lambda: Robot.planar([0.5, 0.4, 0.3]),
    "vehicle": lambda: Robot.vehicle(2, heading=True),
}


@pytest.fixture(scope="session", params=ROBOTS)
def robot(request):
    return ROBOTS[request.param]()


@pytest.fixture(scope="session")
def mixed():
    return make_mixed()


@pytest.fixture(scope="session")
def gripper():
    return make_gripper()


def poses_of_interest(robot, count=4):
    """Neutral, a displacement of 0.5 from it, and random configurations."""
    yield robot.neutral
    yield robot.integrate(robot.neutral, np.full(robot.n, 0.5))
    generator = np.random.default_rng(7)
    for _ in range(count):
        yield robot.random_configuration(generator)
