"""The part of a target that a task does not use, in error messages and in ``unused``."""

from __future__ import annotations

import mink
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik.task.stack import TaskStack

from .conftest import dh_arm, planar


class SE3:
    """An object with ``as_matrix()``, as other libraries have it."""

    def __init__(self, matrix):
        self._matrix = matrix

    def as_matrix(self):
        return self._matrix


POSES = (
    "(4, 4) or (3, 4), seven numbers (x, y, z, qw, qx, qy, qz), a pair (position, rotation), or a pose of SciPy, mink, "
    "Pinocchio, spatialmath, Drake or ROS"
)
ROTATIONS = "a matrix (3, 3), a quaternion (w, x, y, z), or a rotation of one of these libraries"
ACCEPTED = {
    ("position", 3): f"(x, y, z) [m], or a pose: {POSES}; of a pose only the position is used",
    ("orientation", 3): f"a rotation: {ROTATIONS}; or a pose: {POSES}; of a pose only the orientation is used",
    ("pose", 3): f"a pose: {POSES}, where the rotation is {ROTATIONS}",
    ("position", 2): f"(x, y) [m], or a pose: {POSES}; of a pose only the position is used",
    ("orientation", 2): f"an angle [rad], a rotation about z, or a pose: {POSES}; of a pose only the orientation is "
    "used",
    ("pose", 2): f"(x, y, angle) [m, rad], or a pose: {POSES}",
}


class TestUnused:
    """What a task does not use of a target is said in the error, and by ``unused`` for a target that is accepted."""

    POSE = np.eye(4)
    SEVEN = (0.1, 0.2, 0.3, 1.0, 0.0, 0.0, 0.0)
    PAIR = ((0.1, 0.2, 0.3), Rotation.identity())

    @pytest.mark.parametrize(("kind", "dimension"), ACCEPTED)
    def test_the_error_says_what_is_accepted_and_what_is_used_of_it(self, kind, dimension):
        robot = planar(3) if dimension == 2 else dh_arm()
        with pytest.raises(jtik.ArgumentError) as caught:
            jtik.FrameTask("tip", kind).read_target(robot, "there")
        assert str(caught.value) == f"target: given there; accepted: {ACCEPTED[kind, dimension]}"

    @pytest.mark.parametrize("target", [POSE, POSE.tolist(), SEVEN, list(SEVEN), PAIR, SE3(POSE), mink.SE3.identity()])
    def test_of_a_pose(self, target):
        robot = dh_arm()
        for kind, unused in (
            ("position", "orientation of the target"),
            ("orientation", "position of the target"),
            ("pose", None),
        ):
            task = jtik.FrameTask("tip", kind)
            task.read_target(robot, target)
            assert task.unused(robot, target) == unused
        assert jtik.RelativeFrameTask("tip", "link2", "position").unused(robot, target) == "orientation of the target"
        assert jtik.LookAtTask("tip").unused(robot, target) == "orientation of the target"

    @pytest.mark.parametrize(
        ("task", "target"),
        [
            (jtik.FrameTask(), (0.1, 0.2, 0.3)),
            (jtik.FrameTask(), np.zeros(3)),
            (jtik.FrameTask(kind="orientation"), (1.0, 0.0, 0.0, 0.0)),
            (jtik.FrameTask(kind="orientation"), np.eye(3)),
            (jtik.FrameTask(kind="orientation"), Rotation.identity()),
            (jtik.LookAtTask(), (0.1, 0.2, 0.3)),
            (jtik.AxisTask(), (0.1, 0.2, 0.3)),
            (jtik.CenterOfMassTask(axes="xy"), (0.1, 0.2, 0.3)),
        ],
    )
    def test_nothing_of_a_target_that_fits(self, task, target):
        assert task.unused(dh_arm(), target) is None

    def test_of_the_targets_of_several_tasks(self):
        stack = TaskStack.of(dh_arm(), [jtik.FrameTask(name="hand"), jtik.FrameTask("link2", "pose", name="elbow")])
        assert stack.unused({"hand": self.POSE, "elbow": self.POSE}) == "hand: orientation of the target"
        assert stack.unused({"hand": np.zeros(3), "elbow": self.POSE}) is None
        two = TaskStack.of(dh_arm(), [jtik.FrameTask(name="a"), jtik.FrameTask("link2", "orientation", name="b")])
        both = "a: orientation of the target; b: position of the target"
        assert two.unused({"a": self.SEVEN, "b": self.PAIR}) == both
        assert TaskStack.of(dh_arm(), jtik.FrameTask()).unused(self.POSE) == "orientation of the target"
