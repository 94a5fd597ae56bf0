"""Metrics of a configuration against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.study.metrics import ConfigurationMetrics, condition, measures_of
from jtik.task import TaskStack
from jtik_formulations import JointCentering, ObstacleAvoidance


def test_H_V_and_condition_have_closed_forms():
    arm, q = jtik.Robot.planar(2), np.array([0.7, math.pi / 2])
    tasks = TaskStack.of(arm, jtik.FrameTask("tip", stiffness=[4.0, 1.0]))
    metrics = ConfigurationMetrics(arm, tasks, 3.0 * JointCentering(preferred=[0.5, 1.0]))
    away = np.array([0.1, -0.2])
    H, V, number = metrics.at(q, tasks.read_target(arm.position(q) - away))
    ik = jtik.InverseKinematics(arm, tasks.tasks, criteria=3.0 * JointCentering(preferred=[0.5, 1.0]))
    assert pytest.approx(ik.solve(arm.position(q), q0=q, max_iterations=0).cost) == H
    assert pytest.approx((4 * 0.1**2 + 0.2**2) / 2) == V
    # elbow at a right angle: J' J = [[2, 1], [1, 1]]
    assert number == pytest.approx(math.sqrt((3 + math.sqrt(5)) / (3 - math.sqrt(5))))


def test_the_condition_of_a_singular_jacobian_is_infinite():
    assert condition(np.array([[1.0, 2.0], [2.0, 4.0]])) == math.inf
    assert math.isnan(condition(np.array([[1.0, math.nan], [2.0, 4.0]])))


def test_a_scene_without_obstacles_has_no_clearance():
    """Nor has one whose obstacles are all absent; one that appears has."""
    robot = jtik.Robot.planar(2)
    criterion = ObstacleAvoidance([], capacity=2)
    found = ConfigurationMetrics(robot, TaskStack.of(robot, jtik.FrameTask()), None, measures_of(criterion, []))
    assert np.isnan(found.clearance([np.zeros(2)]))
    live = {"gains": np.array([1.0, 0.0]), "centers": np.array([[3.0, 0.0], [0.0, 0.0]])}
    found.set({f"obstacle_avoidance.{name}": value for name, value in live.items()})
    assert found.clearance([np.zeros(2)]) == pytest.approx(1.0, abs=1e-12)
