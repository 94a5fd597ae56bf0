"""LookAtTask: an axis of a frame points at a point."""

from __future__ import annotations

import numpy as np
import pytest

import jtik

from ..conftest import DIFFERENCES, EXACT, differences, report_at
from .conftest import ROBOTS, built, dh_arm, floating_arm, planar


def sight(robot, q, target):
    return target - robot.position(q)


@pytest.mark.parametrize("name", ROBOTS)
def test_error_is_that_of_the_axis_in_the_line_of_sight(name, rng):
    robot = ROBOTS[name]()
    axis = (0.3, -0.5, 0.8)
    gaze, direction = built(robot, jtik.LookAtTask, "tip", axis), built(robot, jtik.AxisTask, "tip", axis)
    for _ in range(5):
        q, target = robot.random_configuration(rng), rng.uniform(-2, 2, 3)
        wanted = report_at(direction, q, sight(robot, q, target))
        found = report_at(gaze, q, target)
        assert found.error == pytest.approx(wanted.error, abs=EXACT)
        assert found.orientation_error == pytest.approx(wanted.orientation_error, abs=EXACT)


@pytest.mark.thinned
@pytest.mark.parametrize("where", ["ahead", "behind", "beside", "close"])
@pytest.mark.parametrize("name", ROBOTS)
def test_jacobian_is_the_derivative_of_the_error(name, where, rng):
    """On the axis, where the error is zero; almost behind; beside; and close, where the motion of the origin counts."""
    robot = ROBOTS[name]()
    ik = built(robot, jtik.LookAtTask)
    q = robot.random_configuration(rng)
    seen = {"ahead": (0, 0, 0.7), "behind": (0.05, -0.1, -0.9), "beside": (1.0, 2.0, -0.3), "close": (0.1, 0.1, 0.1)}
    target = (robot.pose(q) @ [*seen[where], 1.0])[:3]
    numeric = differences(lambda at: report_at(ik, at, target).error, robot, q)
    found = report_at(ik, q, target)
    assert found.jacobian == pytest.approx(numeric, abs=10 * DIFFERENCES)  # lengths of 0.1 m, cubed
    assert (found.orientation_error < EXACT) == (where == "ahead")


def test_rows_are_the_position_of_the_point_in_the_image(rng):
    """For a camera along z and a point on its right, +x, the rotation to it is about +y; e is the opposite rotation."""
    robot = dh_arm()
    q = robot.random_configuration(rng)
    ik = built(robot, jtik.LookAtTask)
    right, up = ((robot.pose(q) @ [*seen, 1.0, 1.0])[:3] for seen in ((0.1, 0.0), (0.0, 0.1)))
    assert report_at(ik, q, right).error == pytest.approx([0.0, -np.arctan(0.1)], abs=EXACT)
    assert report_at(ik, q, up).error == pytest.approx([np.arctan(0.1), 0.0], abs=EXACT)


@pytest.mark.parametrize("make", [dh_arm, floating_arm])
def test_a_point_is_looked_at(make, rng):
    robot = make()
    ik = built(robot, jtik.LookAtTask, "tip", (1, 0, 0))
    for _ in range(5):
        target = rng.uniform(-1, 1, 3)
        solution = ik.solve(target, q0=robot.random_configuration(rng))
        line = sight(robot, solution.q, target)
        assert solution.converged
        assert robot.pose(solution.q)[:3, 0] == pytest.approx(line / np.linalg.norm(line), abs=2e-6)


def test_a_point_exactly_behind_is_looked_at(rng):
    robot = dh_arm()
    q = robot.random_configuration(rng)
    target = (robot.pose(q) @ [0, 0, -0.5, 1])[:3]
    ik = built(robot, jtik.LookAtTask)
    assert report_at(ik, q, target).error == pytest.approx([np.pi, 0.0], abs=1e-6)
    assert ik.solve(target, q0=q).converged


@pytest.mark.parametrize("make", [dh_arm, floating_arm, lambda: planar(3)])
def test_a_point_on_top_of_the_origin_is_looked_at_by_every_axis(make, rng):
    robot = make()
    q = robot.random_configuration(rng)
    ik = built(robot, jtik.LookAtTask, "tip", (1, 0, 0))
    for offset in (0.0, 1e-10):
        found = report_at(ik, q, robot.position(q) + offset)
        assert not found.error.any()
        assert not found.jacobian.any()
        assert found.converged


@pytest.mark.parametrize("offset", [2e-9, 1e-6, 1e-3])
def test_close_to_the_origin_everything_stays_finite(offset, rng):
    robot = floating_arm()
    q = robot.random_configuration(rng)
    found = report_at(built(robot, jtik.LookAtTask), q, robot.position(q) + offset)
    assert np.isfinite(found.error).all()
    assert np.isfinite(found.jacobian).all()


class TestInThePlane:
    def test_error_and_jacobian(self, rng):
        robot = planar(3)
        ik = built(robot, jtik.LookAtTask, "tip", (1, 0))
        for _ in range(5):
            q, target = robot.random_configuration(rng), rng.uniform(-3, 3, 2)
            line = sight(robot, q, target)
            wanted = (q.sum() - np.arctan2(line[1], line[0]) + np.pi) % (2 * np.pi) - np.pi
            found = report_at(ik, q, target)
            assert found.error == pytest.approx([wanted], abs=EXACT)
            J = robot.jacobian(q)
            normal = np.array([-line[1], line[0]]) / (line @ line)
            assert found.jacobian == pytest.approx(np.ones((1, 3)) + normal @ J[:2], abs=1e-11)

    def test_an_axis_out_of_the_plane_is_refused(self):
        with pytest.raises(jtik.ArgumentError, match="axis.*in the plane"):
            built(planar(3), jtik.LookAtTask)


def test_a_pose_counts_as_its_position(rng):
    robot = dh_arm()
    q, pose = robot.random_configuration(rng), robot.pose(robot.random_configuration(rng))
    ik = built(robot, jtik.LookAtTask)
    wanted = report_at(ik, q, pose[:3, 3]).error.tolist()
    assert report_at(ik, q, pose).error.tolist() == wanted
    assert report_at(ik, q, (pose[:3, 3], (1, 0, 0, 0))).error.tolist() == wanted


@pytest.mark.parametrize("target", [(1, 0), 1.0, np.eye(3), "there", None, (np.nan, 0, 1), np.zeros((4, 4))])
def test_an_invalid_point_is_refused(target):
    with pytest.raises(jtik.ArgumentError, match="(?s)^target: .*accepted: .*"):
        built(dh_arm(), jtik.LookAtTask).solve(target)
