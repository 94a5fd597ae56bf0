"""The independent check against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik.study.independent_check import IndependentCheck
from jtik.task import TaskStack

EXACT = 1e-12


def check_of(robot, *tasks):
    stack = TaskStack.of(robot, tasks)
    return IndependentCheck(robot, stack), stack


class TestPlanar:
    Q = np.array([0.3, 0.5, -0.9])

    def tip(self):
        angles = np.cumsum(self.Q)
        return np.array([np.cos(angles).sum(), np.sin(angles).sum()]), angles[-1]

    def test_pose_errors_agree_with_the_closed_form(self):
        check, tasks = check_of(jtik.Robot.planar(3), jtik.FrameTask("tip", "pose"))
        position, angle = self.tip()
        target = [position[0] + 0.3, position[1] - 0.4, angle + 0.2 - 2 * math.pi]
        found = check.errors(self.Q, tasks.read_target(target))
        np.testing.assert_allclose(found, (0.5, 0.2), atol=EXACT)
        assert check.independent
        assert (check.has_position, check.has_orientation) == (True, True)

    @pytest.mark.parametrize(("kind", "expected"), [("position", (0.5, 0.0)), ("orientation", (0.0, 0.2))])
    def test_only_the_rows_of_the_task_count(self, kind, expected):
        check, tasks = check_of(jtik.Robot.planar(3), jtik.FrameTask("tip", kind))
        position, angle = self.tip()
        target = [position[0] + 0.3, position[1] - 0.4] if kind == "position" else angle - 0.2
        np.testing.assert_allclose(check.errors(self.Q, tasks.read_target(target)), expected, atol=EXACT)
        assert (check.has_position, check.has_orientation) == (kind == "position", kind == "orientation")

    def test_only_the_axes_of_the_task_count(self):
        check, tasks = check_of(jtik.Robot.planar(3), jtik.FrameTask("tip", axes="y"))
        position, _ = self.tip()
        found = check.errors(self.Q, tasks.read_target(position + np.array([7.0, 0.25])))
        np.testing.assert_allclose(found, (0.25, 0.0), atol=EXACT)


class TestSpatial:
    def setup_method(self):
        self.arm = jtik.Robot.builtin("ur5e")
        self.q = np.array([0.4, -1.1, 1.3, 0.2, 0.7, -0.5])
        self.pose = self.arm.pose(self.q)

    @pytest.mark.parametrize("angle", [0.0, 1e-9, 1e-3, 1.0, 3.0, math.pi - 1e-6])
    def test_orientation_errors_are_rotation_angles(self, angle):
        check, tasks = check_of(self.arm, jtik.FrameTask("tip", "pose"))
        axis = np.array([2.0, -1.0, 2.0]) / 3
        target = self.pose.copy()
        target[:3, :3] = self.pose[:3, :3] @ Rotation.from_rotvec(angle * axis).as_matrix()
        target[:3, 3] += [0.02, 0.0, -0.01]
        position, orientation = check.errors(self.q, tasks.read_target(target))
        assert position == pytest.approx(math.hypot(0.02, 0.01), abs=EXACT)
        assert orientation == pytest.approx(angle, abs=1e-8 if angle > 3 else 1e-11)

    def test_a_rotation_about_a_free_axis_is_ignored(self):
        check, tasks = check_of(self.arm, jtik.FrameTask("tip", "orientation", axes=("rx", "ry")))
        target = self.pose[:3, :3] @ Rotation.from_rotvec([0, 0, 0.8]).as_matrix()
        assert check.errors(self.q, tasks.read_target(target))[1] == pytest.approx(0, abs=EXACT)

    def test_errors_of_several_tasks_are_combined(self):
        elbow = jtik.FrameTask("forearm_link", name="elbow")
        up = jtik.AxisTask("tip", axis=(0, 0, 1), name="up")
        check, tasks = check_of(self.arm, elbow, up)
        there = self.arm.position(self.q, "forearm_link") + np.array([0.0, 0.03, 0.04])
        direction = self.pose[:3, :3] @ Rotation.from_rotvec([0.3, 0, 0]).as_matrix() @ [0, 0, 1]
        found = check.errors(self.q, tasks.read_target({"elbow": there, "up": direction}))
        np.testing.assert_allclose(found, (0.05, 0.3), atol=1e-9)
        assert not check.independent

    def test_errors_do_not_depend_on_earlier_calls(self):
        check, tasks = check_of(self.arm, jtik.FrameTask("tip"))
        here = tasks.read_target(self.pose[:3, 3])
        for q in (self.q, np.zeros(6), self.q):
            expected = np.linalg.norm(self.arm.position(q) - self.pose[:3, 3])
            assert check.errors(q, here)[0] == pytest.approx(expected, abs=EXACT)

    def test_nan_is_never_on_target(self):
        check, tasks = check_of(self.arm, jtik.FrameTask("tip"))
        assert math.isnan(check.errors(np.full(6, np.nan), tasks.read_target(self.pose[:3, 3]))[0])


def test_errors_of_a_free_base_use_its_quaternion():
    free = jtik.Robot([jtik.Joint("float", jtik.JointType.FREE, "base", "body")], name="brick")
    check, tasks = check_of(free, jtik.FrameTask("body", "pose"))
    q = np.array([1.0, 2.0, 3.0, *Rotation.from_rotvec([0, 0.4, 0]).as_quat(scalar_first=True)])
    found = check.errors(q, tasks.read_target(np.eye(4)))
    np.testing.assert_allclose(found, (math.sqrt(14), 0.4), atol=EXACT)
    assert math.isnan(check.margin(q))
    assert check.within(q)


class TestLimits:
    ARM = jtik.Robot.planar(2, lower=-1.0, upper=3.0)

    @pytest.mark.parametrize(
        ("q", "margin", "within"),
        [((1.0, 1.0), 0.5, True), ((0.0, 2.8), 0.05, True), ((-1.0, 1.0), 0.0, True), ((3.4, 1.0), -0.1, False)],
    )
    def test_the_limit_margin_is_relative_to_the_range(self, q, margin, within):
        check, _ = check_of(self.ARM, jtik.FrameTask("tip"))
        assert check.margin(np.array(q)) == pytest.approx(margin)
        assert check.within(np.array(q)) == within

    def test_rounding_beyond_a_limit_is_allowed(self):
        check, _ = check_of(self.ARM, jtik.FrameTask("tip"))
        assert check.within(np.array([3.0 + 1e-12, 0.0]))
        assert not check.within(np.array([3.0 + 1e-7, 0.0]))
