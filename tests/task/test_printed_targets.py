"""Targets as people print them, and as the objects of other libraries and of ROS."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

import jtik

from .conftest import dh_arm, planar

ROTATION = Rotation.from_rotvec([0.3, -0.4, 0.5])
POSE = np.eye(4)
POSE[:3, :3], POSE[:3, 3] = ROTATION.as_matrix(), (0.1, -0.2, 0.3)
W, X, Y, Z = np.roll(ROTATION.as_quat(), 1).tolist()
NUMBERS = np.concatenate([POSE[:3, 3], POSE[:3, :3].ravel(order="F")])


class Drake:
    """A pose with the methods of ``pydrake.math.RigidTransform``."""

    def GetAsMatrix4(self):
        return POSE

    def rotation(self):
        return None

    def translation(self):
        return POSE[:3, 3]


class Spatial:
    """A pose or a rotation with the attribute of spatialmath's."""

    def __init__(self, array):
        self.A = array


def point(*xyz):
    return SimpleNamespace(**dict(zip("xyz", xyz, strict=True)))


def quaternion(w, x, y, z):
    return SimpleNamespace(x=x, y=y, z=z, w=w)


ROS_POSE = SimpleNamespace(position=point(0.1, -0.2, 0.3), orientation=quaternion(W, X, Y, Z))
ROS_TRANSFORM = SimpleNamespace(translation=point(0.1, -0.2, 0.3), rotation=quaternion(W, X, Y, Z))
POSES = {
    "(3, 4)": POSE[:3],
    "(3, 4) list": POSE[:3].tolist(),
    "seven numbers": [0.1, -0.2, 0.3, W, X, Y, Z],
    "scipy": RigidTransform.from_matrix(POSE),
    "drake": Drake(),
    "spatialmath": Spatial(POSE),
    "ros pose": ROS_POSE,
    "ros stamped pose": SimpleNamespace(header=None, pose=ROS_POSE),
    "ros pose with covariance": SimpleNamespace(pose=SimpleNamespace(pose=ROS_POSE, covariance=[0.0])),
    "ros transform": ROS_TRANSFORM,
    "ros stamped transform": SimpleNamespace(header=None, transform=ROS_TRANSFORM),
    "pair": (point(0.1, -0.2, 0.3), quaternion(W, X, Y, Z)),
    "pair with spatialmath": ([0.1, -0.2, 0.3], Spatial(POSE[:3, :3])),
}


@pytest.mark.parametrize("form", POSES)
@pytest.mark.parametrize(("kind", "part"), [("position", slice(3)), ("orientation", slice(3, 12)), ("pose", slice(12))])
def test_a_pose_of_another_library_is_a_target(form, kind, part):
    task = jtik.FrameTask("tip", kind)
    assert task.read_target(dh_arm(), POSES[form]) == pytest.approx(NUMBERS[part], abs=1e-12)
    unused = {"position": "orientation of the target", "orientation": "position of the target", "pose": None}
    assert task.unused(dh_arm(), POSES[form]) == unused[kind]


@pytest.mark.parametrize(
    "rotation", [quaternion(W, X, Y, Z), Spatial(POSE[:3, :3]), Spatial(np.array([W, X, Y, Z])), ROTATION]
)
def test_a_rotation_of_another_library_is_a_target(rotation):
    assert jtik.FrameTask("tip", "orientation").read_target(dh_arm(), rotation) == pytest.approx(NUMBERS[3:], abs=1e-12)


def test_a_point_of_ros_is_a_position():
    assert jtik.FrameTask().read_target(dh_arm(), point(1.0, 2.0, 3.0)).tolist() == [1.0, 2.0, 3.0]


def test_pinocchios_poses_are_targets():
    pin = pytest.importorskip("pinocchio")
    task = jtik.FrameTask("tip", "pose")
    assert task.read_target(dh_arm(), pin.SE3(POSE)) == pytest.approx(NUMBERS, abs=1e-12)
    pair = (POSE[:3, 3], pin.Quaternion(POSE[:3, :3]))
    assert task.read_target(dh_arm(), pair) == pytest.approx(NUMBERS, abs=1e-12)


def test_poses_of_the_plane_are_targets_of_a_planar_robot():
    c, s = np.cos(0.3), np.sin(0.3)
    target = Spatial(np.array([[c, -s, 0.5], [s, c, 0.7], [0, 0, 1]]))
    for kind, numbers in (("position", [0.5, 0.7]), ("orientation", [0.3]), ("pose", [0.5, 0.7, 0.3])):
        assert jtik.FrameTask("tip", kind).read_target(planar(3), target) == pytest.approx(numbers, abs=1e-12)


@pytest.mark.parametrize(
    ("printed", "exact"),
    [
        ([0.7071, 0, 0.7071, 0], Rotation.from_euler("y", 90, degrees=True)),
        (np.round([W, X, Y, Z], 2), ROTATION),
        (np.round(ROTATION.as_matrix(), 4), ROTATION),
        (np.round(ROTATION.as_matrix(), 3), ROTATION),
        (0.99991 * np.array([W, X, Y, Z]), ROTATION),
    ],
)
def test_numbers_with_few_digits_are_normalised(printed, exact):
    for kind, target in (("orientation", printed), ("pose", ([0.1, 0.2, 0.3], printed))):
        R = jtik.FrameTask("tip", kind).read_target(dh_arm(), target)[-9:].reshape(3, 3).T
        assert pytest.approx(np.eye(3), abs=1e-14) == R.T @ R
        angle = (Rotation.from_matrix(R) * exact.inv()).magnitude()
        assert angle < 0.02


@pytest.mark.parametrize(
    ("target", "complaint"),
    [
        ([1.0, 0.0, 0.2, 0.0], r"norm 1, to 0.01; this one has the norm 1.0198"),
        ([0.0, 0.0, 0.0, 0.0], r"this one has the norm 0"),
        (np.diag([1.0, 1.0, 1.002]), r"this one differs from the nearest rotation by 0.002"),
        (np.diag([1.0, 1.0, -1.0]), r"this one has the determinant -1"),
        (quaternion(0.0, 0.0, 0.0, 0.0), r"this one has the norm 0"),
    ],
)
def test_what_is_farther_off_is_refused_and_the_error_says_how_far(target, complaint):
    with pytest.raises(jtik.ArgumentError, match=complaint):
        jtik.FrameTask("tip", "orientation").read_target(dh_arm(), target)
