"""Two arms that reach across each other: clearances between them, and the error that they cost each strategy."""

from __future__ import annotations

import functools
import itertools
import math

import numpy as np
import pytest

import jtik
from jtik.robot import Joint, JointType
from jtik.symbolic import norm

from ..conftest import shared_solver

SAFE, GAP, STEPS, DT = 0.1, 0.8, 400, 0.015
BODIES = ("iiwa_link_3", "iiwa_link_4", "iiwa_link_5", "iiwa_link_6", "iiwa_link_ee")
HOME = np.tile([0.0, 0.5, 0.0, -1.2, 0.0, 1.0, 0.0], 2)


@functools.cache
def two_arms():
    """Two iiwa 14 side by side, 0.8 m apart."""
    one, joints = jtik.Robot.builtin("iiwa14"), []
    for side, y in (("left", GAP / 2), ("right", -GAP / 2)):
        mount = np.eye(4)
        mount[1, 3] = y
        joints.append(Joint(f"{side} mount", JointType.FIXED, "world", f"{side} {one.base}", origin=mount))
        for joint in one.joints:
            joints.append(
                Joint(
                    f"{side} {joint.name}",
                    joint.type,
                    f"{side} {joint.parent}",
                    f"{side} {joint.child}",
                    origin=joint.origin,
                    axis=joint.axis,
                    lower=joint.lower,
                    upper=joint.upper,
                )
            )
    return jtik.Robot(joints, base="world")


def points(position, side):
    """Joints of an arm from the elbow on, and the centres of the links between them."""
    ends = [position(f"{side} {frame}") for frame in BODIES]
    return [*ends, *[0.5 * (a + b) for a, b in itertools.pairwise(ends)]]


class BetweenArms:
    """Distances of points of one arm to points of the other."""

    name = "between"

    def parameters(self, robot):
        return {}

    def distances(self, kinematics, parameters):
        left, right = (points(kinematics.position, side) for side in ("left", "right"))
        return [[norm(a - b) for b in right] for a in left]


def gap(q):
    left, right = (np.array(points(functools.partial(two_arms().position, q), side)) for side in ("left", "right"))
    return np.linalg.norm(left[:, None] - right, axis=-1).min()


@functools.cache
def crossing(strategy, sweeps):
    """Mean error [m] along sweeps of the hands across each other, and the smallest distance on the way [m]."""
    ik = shared_solver(
        two_arms(),
        [jtik.FrameTask(f"{side} iiwa_link_ee", name=side) for side in ("left", "right")],
        strategy=strategy,
        clearances=jtik.Clearance(BetweenArms(), safe=SAFE),
        limits=jtik.Limits(velocity=2.0),
    )
    q, errors, smallest = HOME, [], math.inf
    for angle in np.linspace(0, 2 * math.pi * sweeps, STEPS * sweeps):
        target = {
            "left": np.array([0.55 + 0.02 * math.sin(3 * angle), 0.35 * math.cos(angle), 0.5 + 0.05 * math.sin(angle)]),
            "right": np.array([0.57, -0.35 * math.cos(angle), 0.5 - 0.05 * math.sin(2 * angle)]),
        }
        after = ik.step(q, target, dt=DT).q
        smallest = min(smallest, *[gap(q + share * (after - q)) for share in (0.33, 0.67, 1.0)])
        q = after
        for side, place in target.items():
            errors.append(np.linalg.norm(two_arms().position(q, f"{side} iiwa_link_ee") - place))
    return np.mean(errors), smallest


@pytest.mark.quick(0, slow=2)
@pytest.mark.parametrize(
    ("strategy", "sweeps"),
    [
        ("hybrid+qp", 1),
        *(
            pytest.param(name, 2, marks=pytest.mark.slow)
            for name in ("hybrid+qp", "lexicographic_qp", "damped+qp", "newton+qp", "weighted_qp")
        ),
    ],
)
def test_the_arms_avoid_each_other_and_no_distance_falls_below_safe(strategy, sweeps):
    """The mean error [m] of a pair that locks is above 0.14, and 0.087 of one that passes on the wrong side."""
    error, smallest = crossing(strategy, sweeps)
    assert smallest >= SAFE - 1e-9
    assert error <= 1.5 * 0.009
