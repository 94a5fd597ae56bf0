"""The forms a target may take, and what is refused."""

from __future__ import annotations

import mink
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik.task.targets import read_fast, read_placement

from ..conftest import report_at
from .conftest import built, dh_arm, expected_error, planar


class SE3:
    """An object with ``as_matrix()``, as other libraries have it."""

    def __init__(self, matrix):
        self._matrix = matrix

    def as_matrix(self):
        return self._matrix


class TestTargets:
    def test_forms_of_one_target_in_space_give_the_same_error(self, rng):
        robot = dh_arm(6, 6)
        q, pose = robot.random_configuration(rng), robot.pose(robot.random_configuration(rng))
        R, rotation = pose[:3, :3].copy(), Rotation.from_matrix(pose[:3, :3])
        quaternion = np.roll(rotation.as_quat(), 1)
        placements = [
            pose,
            pose.tolist(),
            np.asfortranarray(pose),
            SE3(pose),
            (pose[:3, 3], quaternion),
            [pose[:3, 3].tolist(), (-quaternion).tolist()],
            np.concatenate([pose[:3, 3], quaternion]),
            [*pose[:3, 3].tolist(), *(-quaternion).tolist()],
            (pose[:3, 3], rotation),
            [tuple(pose[:3, 3]), rotation],
            (pose[:3, 3], mink.SO3(quaternion)),
            (pose[:3, 3], R),
            mink.SE3.from_matrix(pose),
        ]
        forms = {
            "position": [pose[:3, 3], pose[:3, 3].tolist(), tuple(pose[:3, 3]), *placements],
            "orientation": [
                R,
                R.tolist(),
                np.asfortranarray(R),
                SE3(R),
                rotation,
                quaternion,
                quaternion.tolist(),
                -quaternion,
                mink.SO3(quaternion),
                *placements,
            ],
            "pose": placements,
        }
        for kind, targets in forms.items():
            ik = built(robot, jtik.FrameTask, "tip", kind)
            for target in targets:
                assert report_at(ik, q, target).error == pytest.approx(expected_error(robot, kind, q, pose), abs=1e-10)

    def test_forms_of_one_target_in_the_plane_give_the_same_error(self, rng):
        robot = planar(3)
        q, other = robot.random_configuration(rng), robot.random_configuration(rng)
        pose, (x, y), angle = robot.pose(other), robot.position(other), float(other.sum())
        quaternion = (np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2))
        placements = [
            pose,
            SE3(pose),
            ((x, y), quaternion),
            ((x, y, 0.0), quaternion),
            (x, y, 0.0, *quaternion),
            ((x, y), Rotation.from_euler("z", angle)),
            mink.SE3.from_matrix(pose),
        ]
        forms = {
            "position": [(x, y), np.array([x, y]), *placements],
            "orientation": [
                angle,
                [angle],
                np.float64(angle),
                angle + 4 * np.pi,
                pose[:3, :3],
                quaternion,
                *placements,
            ],
            "pose": [(x, y, angle), (x, y, angle - 2 * np.pi), *placements],
        }
        for kind, targets in forms.items():
            ik = built(robot, jtik.FrameTask, "tip", kind)
            for target in targets:
                assert report_at(ik, q, target).error == pytest.approx(expected_error(robot, kind, q, pose), abs=1e-11)

    @pytest.mark.parametrize("revolutions", [-3, -1, 0, 1, 2])
    @pytest.mark.parametrize(("angle", "target"), [(3.1, -3.1), (-3.1, 3.1), (0.1, -0.1), (1.0, 4.0)])
    def test_a_planar_angle_has_the_smallest_error(self, angle, target, revolutions):
        ik = built(planar(2), jtik.FrameTask, "tip", "orientation")
        wanted = (angle - target + np.pi) % (2 * np.pi) - np.pi
        found = report_at(ik, [angle + 2 * np.pi * revolutions, 0.0], target).error[0]
        assert found == pytest.approx(wanted, abs=1e-11)
        assert abs(found) <= np.pi

    BENT = np.eye(4)
    BENT[0, 0] = 1.1
    MIRROR = np.diag([1.0, 1.0, -1.0, 1.0])

    @pytest.mark.parametrize(
        ("kind", "target"),
        [
            ("position", (1.0, 2.0)),
            ("position", (1.0, 2.0, 3.0, 4.0)),
            ("position", 1.0),
            ("position", np.eye(3)),
            ("position", (1.0, np.nan, 0.0)),
            ("position", (1.0, np.inf, 0.0)),
            ("position", "there"),
            ("position", None),
            ("position", [[1.0], [2.0, 3.0]]),
            ("orientation", 0.3),
            ("orientation", (1.0, 0.0, 0.0)),
            ("orientation", BENT[:3, :3]),
            ("orientation", MIRROR[:3, :3]),
            ("orientation", np.zeros((3, 3))),
            ("pose", (1.0, 2.0, 3.0)),
            ("pose", np.ones(12)),
            ("pose", BENT),
            ("pose", MIRROR),
            ("pose", np.full((4, 4), np.nan)),
            ("position", MIRROR),
            ("position", Rotation.identity()),
            ("orientation", Rotation.identity(2)),
            ("orientation", (1.0, 0.0, 0.0, 0.2)),
            ("orientation", (0.0, 0.0, 0.0, 0.0)),
            ("orientation", (1.0, 0.0, np.nan, 0.0)),
            ("pose", ((0.0, 0.0, 0.0), (2.0, 0.0, 0.0, 0.0))),
            ("pose", ((0.0, 0.0, np.inf), (1.0, 0.0, 0.0, 0.0))),
            ("pose", ((0.0, 0.0), (1.0, 0.0, 0.0, 0.0))),
            ("pose", ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))),
            ("pose", ((0.0, 0.0, 0.0), "upright")),
            ("pose", (1.0, 0.0, 0.0, 0.0)),
            ("pose", (0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0)),
            ("pose", (0.0, np.nan, 0.0, 1.0, 0.0, 0.0, 0.0)),
            ("position", (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)),
            ("pose", ((0.0, 0.0, 0.0), Rotation.identity(2))),
            ("pose", ((0.0, 0.0), Rotation.identity())),
            ("pose", ((0.0, 0.0, 0.0), SE3(np.eye(4)))),
            ("pose", (1.0, Rotation.identity())),
            ("pose", np.eye(4, dtype=complex)),
            ("pose", np.eye(4).astype(str)),
        ],
    )
    def test_an_invalid_target_is_refused_by_name(self, kind, target):
        ik = built(dh_arm(), jtik.FrameTask, "tip", kind)
        for call in (ik.solve, lambda invalid: ik.step(ik.robot.neutral, invalid)):
            with pytest.raises(jtik.ArgumentError, match="(?s)^target: .*accepted: .*") as caught:
                call(target)
            assert caught.value.argument == "target"
            assert any(
                word in caught.value.accepted for word in ("(x, y, z)", "(3, 3)", "(4, 4)", "rotation", "norm 1")
            )

    @pytest.mark.parametrize(
        ("kind", "target"),
        [
            ("position", (1.0, 2.0, 3.0)),
            ("position", 1.0),
            ("position", [np.nan, 0.0]),
            ("orientation", (1.0, 2.0)),
            ("orientation", np.nan),
            ("pose", (1.0, 2.0)),
            ("pose", (1.0, 2.0, np.inf)),
            ("pose", MIRROR),
            ("pose", ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0))),
            ("pose", ((0.0, 0.0), (0.0, 1.0, 0.0, 0.0))),
            ("pose", (0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0)),
            ("pose", (0.0, 0.0, 0.0, 0.6, 0.8, 0.0, 0.0)),
            ("pose", ((0.0, 0.0), Rotation.from_rotvec([0.1, 0.0, 0.0]))),
            ("orientation", Rotation.from_rotvec([0.1, 0.0, 0.0])),
            ("orientation", (0.6, 0.8, 0.0, 0.0)),
            ("position", (1.0, 0.0, 0.0, 0.0)),
        ],
    )
    def test_an_invalid_planar_target_is_refused_by_name(self, kind, target):
        ik = built(planar(2), jtik.FrameTask, "tip", kind)
        with pytest.raises(jtik.ArgumentError, match="(?s)^target: .*accepted: .*"):
            ik.solve(target)

    def test_an_object_whose_matrix_is_no_rotation_is_refused(self):
        ik = built(dh_arm(), jtik.FrameTask, "tip", "pose")
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.solve(SE3(self.BENT))

    def test_a_pose_off_the_plane_is_no_planar_target(self):
        """Reading the angle of a tilted rotation would silently aim at something else."""
        tilted = np.eye(4)
        tilted[:3, :3] = Rotation.from_rotvec([0.5, 0, 0]).as_matrix()
        ik = built(planar(3), jtik.FrameTask, "tip", "pose")
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.solve(tilted)

    def test_a_pose_with_an_invalid_last_row_is_refused(self):
        scaled = np.eye(4)
        scaled[3, 3] = 2.0
        ik = built(dh_arm(), jtik.FrameTask, "tip", "pose")
        with pytest.raises(jtik.ArgumentError, match="target"):
            ik.solve(scaled)

    def test_a_target_printed_with_six_digits_is_accepted(self):
        R = np.round(Rotation.from_rotvec([0.3, -0.4, 0.5]).as_matrix(), 6)
        ik = built(dh_arm(), jtik.FrameTask, "tip", "orientation")
        assert np.isfinite(report_at(ik, ik.robot.neutral, R).error).all()

    def test_a_target_is_copied(self, rng):
        robot = planar(3)
        target = np.array([1.0, 1.0])
        ik = built(robot, jtik.FrameTask)
        first = ik.solve(target, q0=[0.3, 0.3, 0.3])
        ik.solve([2.0, 0.5], q0=[0.3, 0.3, 0.3])
        assert target.tolist() == [1.0, 1.0]
        assert robot.position(first.q) == pytest.approx(target, abs=2e-6)

    def test_a_quaternion_printed_with_six_digits_is_accepted_and_normalised(self):
        rotation = Rotation.from_rotvec([0.3, -0.4, 0.5])
        printed = np.round(np.roll(rotation.as_quat(), 1), 6)
        ik = built(dh_arm(), jtik.FrameTask, "tip", "orientation")
        R = read_placement(printed, "orientation", 3, "").reshape(3, 3).T
        assert pytest.approx(np.eye(3), abs=1e-15) == R @ R.T
        assert pytest.approx(rotation.as_matrix(), abs=2e-6) == R
        assert np.isfinite(report_at(ik, ik.robot.neutral, printed).error).all()


class TestFastForms:
    """Valid arrays are read on a fast path; it gives what `read_placement` gives, and None where that refuses."""

    SHAPES = (
        (("position", (3,))),
        ("position", (4, 4)),
        ("orientation", (3, 3)),
        ("orientation", (4, 4)),
        ("pose", (4, 4)),
    )

    @pytest.mark.parametrize(("kind", "shape"), SHAPES)
    def test_both_paths_give_the_same_numbers_as_a_copy(self, kind, shape, rng):
        for rotation in Rotation.random(20, random_state=5):
            pose = np.eye(4)
            pose[:3, :3], pose[:3, 3] = rotation.as_matrix(), rng.standard_normal(3)
            target = {(4, 4): pose, (3, 3): pose[:3, :3], (3,): pose[:3, 3]}[shape]
            numbers = read_fast(target, kind)
            assert numbers.tolist() == read_placement(target, kind, 3, "").tolist()
            assert not np.shares_memory(numbers, target)

    @pytest.mark.parametrize("size", [1e-8, 4e-7, 6e-7, 1e-5, 0.1, np.nan, np.inf, 1e200])
    def test_the_fast_path_accepts_nothing_that_is_refused_otherwise(self, size):
        for row in range(4):
            for column in range(4):
                for side in (1, -1):
                    pose = np.eye(4)
                    pose[row, column] += side * size
                    try:
                        wanted = read_placement(pose, "pose", 3, "").tolist()
                    except jtik.ArgumentError:
                        assert read_fast(pose, "pose") is None
                        continue
                    numbers = read_fast(pose, "pose")
                    assert numbers is None or numbers.tolist() == wanted

    @pytest.mark.parametrize(
        "target", [np.eye(4).tolist(), np.eye(4, dtype=int), np.eye(4, dtype=object), np.eye(5), None]
    )
    def test_other_forms_are_not_read_on_the_fast_path(self, target):
        assert read_fast(target, "pose") is None


class Above(jtik.FrameTask):
    """A task whose targets are 0.05 m above what is given."""

    def read_target(self, robot, target):
        numbers = super().read_target(robot, target).copy()
        numbers[robot.dimension - 1] += 0.05
        return numbers


class TestOwnReader:
    """A subclass that reads targets in its own way reads all of them so, also those that have faster ways."""

    @pytest.mark.parametrize("compiled", [False, True])
    def test_poses(self, compiled, rng):
        robot = dh_arm(7, 3)
        ik = jtik.InverseKinematics(robot, Above("tip", "pose"), strategy="damped", compiled=compiled)
        poses = np.array([robot.pose(0.5 * robot.random_configuration(rng)) for _ in range(4)])
        wanted = poses[:, :3, 3] + [0, 0, 0.05]
        batches = [ik.solve_batch(poses, restarts=30, lanes=lanes).q for lanes in (False, True, True)]
        for found in (*batches, [ik.solve(pose, restarts=30).q for pose in poses]):
            assert [robot.position(q) for q in found] == pytest.approx(wanted, abs=2e-6)
        assert ik.step(batches[0][0], poses[0], dt=0.01).q == pytest.approx(batches[0][0], abs=1e-4)

    def test_vectors(self):
        robot = planar(3)
        ik = jtik.InverseKinematics(robot, Above(kind="position"))
        for target in (np.array([1.2, 0.6]), [1.2, 0.6]):
            assert robot.position(ik.solve(target).q) == pytest.approx([1.2, 0.65], abs=2e-6)
        found = ik.solve_batch(np.array([[1.2, 0.6]])).q[0]
        assert robot.position(found) == pytest.approx([1.2, 0.65], abs=2e-6)

    def test_faster_ways_of_the_same_class_are_used(self):
        class Both(Above):
            def read_target(self, robot, target):
                raise AssertionError

            def read_matrices(self, robot, targets):
                return super(Above, self).read_matrices(robot, targets)

        robot = dh_arm(7, 3)
        found = jtik.InverseKinematics(robot, Both("tip", "pose")).tasks.read_table(np.array([robot.pose(robot.home)]))
        assert found is not None
