"""FrameTask: errors, Jacobians, the rows to keep, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik

from ..conftest import DIFFERENCES, EXACT, differences, report_at
from .conftest import ROBOTS, built, dh_arm, expected_error, planar, solver

KINDS = ("position", "orientation", "pose")


@pytest.mark.thinned
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ROBOTS)
def test_error_in_space(name, kind, rng):
    robot = ROBOTS[name]()
    ik = built(robot, jtik.FrameTask, "tip", kind)
    for _ in range(10):
        q, other = robot.random_configuration(rng), robot.random_configuration(rng)
        target = robot.pose(other)
        # 1e-10: a random rotation may be within 1e-2 of pi, where rounding errors are 100 times larger
        assert report_at(ik, q, _target(kind, target)).error == pytest.approx(
            expected_error(robot, kind, q, target), abs=1e-10
        )


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("heading", [False, True])
def test_error_in_the_plane(kind, heading, rng):
    robot = jtik.Robot.vehicle(3, heading=heading)
    ik = built(robot, jtik.FrameTask, "tip", kind)
    for _ in range(10):
        q, target = robot.random_configuration(rng), robot.pose(robot.random_configuration(rng))
        found = report_at(ik, q, target)
        assert found.error == pytest.approx(expected_error(robot, kind, q, target), abs=EXACT)
        assert found.position_error == pytest.approx(
            0 if kind == "orientation" else np.linalg.norm(found.error[:2]), abs=EXACT
        )
        assert found.orientation_error == pytest.approx(0 if kind == "position" else abs(found.error[-1]), abs=EXACT)


@pytest.mark.thinned
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", [*ROBOTS, "plane"])
def test_jacobian_is_the_derivative_of_the_error(name, kind, rng):
    robot = jtik.Robot.vehicle(3, heading=True) if name == "plane" else ROBOTS[name]()
    ik = built(robot, jtik.FrameTask, "tip", kind)
    for _ in range(5):
        q = robot.random_configuration(rng)
        target = robot.pose(robot.integrate(q, rng.uniform(-0.3, 0.3, robot.n)))
        target = target if name == "plane" else _target(kind, target)
        numeric = differences(lambda at, t=target: report_at(ik, at, t).error, robot, q)
        assert report_at(ik, q, target).jacobian == pytest.approx(numeric, abs=DIFFERENCES)


@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_on_the_target_itself(name, rng):
    """The logarithm at the identity: angular rows in the target's axes, which are the frame's own there."""
    robot = ROBOTS[name]()
    ik = built(robot, jtik.FrameTask, "tip", "pose")
    q = robot.random_configuration(rng)
    pose = robot.pose(q)
    geometric = robot.jacobian(q)
    geometric[3:] = pose[:3, :3].T @ geometric[3:]
    assert report_at(ik, q, pose).jacobian == pytest.approx(geometric, abs=1e-11)


def test_any_frame_may_be_the_one_of_the_task(rng):
    robot = planar(4)
    q = robot.random_configuration(rng)
    found = report_at(solver(robot, jtik.FrameTask("link3")), q, (0.0, 0.0))
    assert found.error == pytest.approx(robot.position(q, "link3"), abs=EXACT)
    assert not found.jacobian[:, 2:].any()


def _target(kind, pose):
    return {"position": pose[:3, 3], "orientation": pose[:3, :3], "pose": pose}[kind]


class TestAxes:
    ALL = ("x", "y", "z", "rx", "ry", "rz")

    @pytest.mark.quick(3)
    @pytest.mark.parametrize("axes", ["x", "zy", ["rz"], ("rx", "ry"), ["x", "y", "z", "rx"], ["ry", "x"], [*ALL]])
    def test_keep_the_rows_named_in_the_order_named(self, axes, rng):
        robot = dh_arm(6, 3)
        q, target = robot.random_configuration(rng), robot.pose(robot.random_configuration(rng))
        all_rows = report_at(built(robot, jtik.FrameTask, "tip", "pose"), q, target)
        kept = report_at(solver(robot, jtik.FrameTask("tip", "pose", axes=axes)), q, target)
        rows = [self.ALL.index(axis) for axis in axes]
        assert kept.error.tolist() == all_rows.error[rows].tolist()
        assert kept.jacobian == pytest.approx(all_rows.jacobian[rows], abs=EXACT)

    def test_without_rz_the_rotation_about_the_tools_z_is_free(self, rng):
        robot = dh_arm(7, 4)
        ik = solver(robot, jtik.FrameTask("tip", "pose", axes=("x", "y", "z", "rx", "ry")))
        start = robot.random_configuration(rng)
        target = robot.pose(start + rng.uniform(-0.2, 0.2, robot.n))
        target[:3, :3] = target[:3, :3] @ Rotation.from_rotvec([0, 0, 0.8]).as_matrix()
        solution = ik.solve(target, q0=start)
        assert solution.converged
        reached = robot.pose(solution.q)
        assert reached[:3, 3] == pytest.approx(target[:3, 3], abs=2e-6)
        assert reached[:3, 2] == pytest.approx(target[:3, 2], abs=2e-6)
        assert not np.allclose(reached[:3, 0], target[:3, 0], atol=1e-3)

    @pytest.mark.parametrize(
        ("kind", "axes"),
        [("position", "q"), ("position", ["rx"]), ("orientation", "x"), ("pose", ""), ("pose", "xx")],
    )
    def test_unknown_repeated_or_no_axes_are_refused(self, kind, axes):
        with pytest.raises(jtik.ArgumentError, match="axes.*distinct names from") as caught:
            solver(dh_arm(), jtik.FrameTask("tip", kind, axes=axes))
        assert caught.value.argument == "axes"

    def test_a_planar_robot_has_no_z(self):
        with pytest.raises(jtik.ArgumentError, match=r"axes.*\['x', 'y', 'rz'\]"):
            solver(planar(3), jtik.FrameTask("tip", "pose", axes="xz"))


class TestInvalidInput:
    def test_an_unknown_frame_lists_the_frames(self):
        with pytest.raises(jtik.UnknownNameError) as caught:
            solver(planar(2), jtik.FrameTask("hand"))
        assert caught.value.name == "hand"
        assert set(caught.value.known) == set(planar(2).frame_names)
        assert "link1" in str(caught.value)

    @pytest.mark.parametrize("kind", ["velocity", None, 3])
    def test_an_unknown_kind_lists_the_kinds(self, kind):
        with pytest.raises(jtik.ArgumentError, match="kind.*'position', 'orientation' or 'pose'"):
            jtik.FrameTask("tip", kind)

    @pytest.mark.parametrize("priority", [-1, 0.5, "high"])
    def test_priorities_are_non_negative_integers(self, priority):
        with pytest.raises(jtik.ArgumentError, match="priority"):
            jtik.FrameTask("tip", priority=priority)

    def test_options_are_keyword_only(self):
        with pytest.raises(TypeError):
            jtik.FrameTask("tip", "position", "xy")
