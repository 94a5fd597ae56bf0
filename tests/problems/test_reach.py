"""The bound on the reach, against sampled configurations and closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.problems import reach

from ..conftest import planar
from .conftest import gallery, mujoco_pose


@pytest.mark.parametrize("name", ["panda", "ur5e"])
def test_no_configuration_exceeds_the_bound(name):
    robot = gallery(name)
    center, bound = reach.center(robot, robot.tip), reach.bound(robot, robot.tip)
    sampled = [mujoco_pose(robot, robot.random_configuration(seed))[:3, 3] for seed in range(200)]
    assert max(np.linalg.norm(position - center) for position in sampled) < bound


def test_the_bound_of_a_planar_arm_is_its_length():
    robot = jtik.Robot.planar([0.5, 0.3, 0.2])
    assert reach.bound(robot, "tip") == pytest.approx(1.0)
    assert reach.center(robot, "tip").tolist() == [0.0, 0.0]
    assert reach.is_free_chain(robot, "tip")
    assert not reach.is_free_chain(planar(4, lower=-2.0, upper=2.0), "tip")


@pytest.mark.parametrize(("limits", "bound"), [({"lower": -0.7, "upper": 0.2}, 0.7), ({}, math.inf)])
def test_a_prismatic_joint_adds_its_larger_limit(limits, bound):
    rail = jtik.Joint("rail", jtik.JointType.PRISMATIC, "base", "cart", axis=np.array([1.0, 0, 0]), **limits)
    robot = jtik.Robot([rail, jtik.Joint("end", jtik.JointType.FIXED, "cart", "tip")], planar=True)
    assert reach.bound(robot, "tip") == bound
    assert reach.size(robot, "tip") == (bound if math.isfinite(bound) else reach.UNBOUNDED_LENGTH)
