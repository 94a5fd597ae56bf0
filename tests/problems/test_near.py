"""Generators `near_singular` and `near_limits` against NumPy and closed forms."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik import problems

from ..conftest import planar, planar_jacobian, planar_points
from .conftest import gallery, mujoco_jacobian


@pytest.mark.parametrize("n", [2, 5, 10])
def test_a_planar_near_singular_start_is_nearly_straight_with_its_target_on_its_line(n):
    for case in problems.near_singular(planar(n), jtik.FrameTask(), 5):
        J = planar_jacobian(case.q0)
        U, sigma, _ = np.linalg.svd(J)
        assert case.known["sigma_min"] == pytest.approx(sigma[-1], abs=1e-12)
        assert case.known["sigma_max"] == pytest.approx(sigma[0], rel=1e-9)
        # an offset of at most 1e-3 rad moves the columns of J by at most 1e-3 times the length beyond
        assert 0 < sigma[-1] < 1e-3 * n**1.5
        points = planar_points(case.q0)
        displacement = case.target - points[-1]
        assert 0.05 * n / 16 * 0.9 < np.linalg.norm(displacement) < 0.3 * n * 1.1
        assert abs(displacement @ U[:, -1]) == pytest.approx(np.linalg.norm(displacement), rel=1e-3)
        assert np.linalg.norm(case.target) <= n


def test_the_distance_from_the_singular_posture_is_as_requested():
    small = problems.near_singular(planar(3), jtik.FrameTask(), 5, start_distance=(1e-9, 1e-9))
    assert max(np.linalg.svd(planar_jacobian(case.q0))[1][-1] for case in small) < 1e-8


def test_deprecated_names_of_the_distances_warn():
    distances = {"start_distance": (1e-4, 1e-4), "target_distance": (0.1, 0.1)}
    new = problems.near_singular(planar(3), jtik.FrameTask(), 2, **distances)
    with pytest.warns(DeprecationWarning, match="is deprecated: use") as found:
        old = problems.near_singular(planar(3), jtik.FrameTask(), 2, bend=(1e-4, 1e-4), far=(0.1, 0.1))
    assert [str(each.message).split()[-1] for each in found] == [*distances]
    assert all(np.array_equal(one.q0, other.q0) for one, other in zip(new, old, strict=True))


@pytest.mark.quick(1)
@pytest.mark.parametrize(("name", "kind"), [("panda", "pose"), ("ur5e", "pose"), ("panda", "position")])
def test_a_spatial_start_has_a_singular_jacobian_by_mujoco(name, kind):
    robot = gallery(name)
    for case in problems.near_singular(robot, jtik.FrameTask(kind=kind), 4):
        J = mujoco_jacobian(robot, case.q0)[: 6 if kind == "pose" else 3]
        sigma = np.linalg.svd(J, compute_uv=False)
        assert sigma[-1] < 2e-3
        assert case.known["sigma_min"] == pytest.approx(sigma[-1], abs=1e-9)


def test_two_conflicting_tasks_are_singular_together():
    robot = planar(4)
    tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link3", kind="orientation", name="turn")]
    for case in problems.near_singular(robot, tasks, 3):
        J = np.vstack([planar_jacobian(case.q0), [1.0, 1.0, 1.0, 0.0]])
        assert np.linalg.svd(J, compute_uv=False)[-1] < 1e-2


def test_a_task_without_singularities_and_one_with_too_many_rows_are_refused():
    with pytest.raises(jtik.ArgumentError, match="singular posture"):
        problems.near_singular(planar(3), jtik.FrameTask(kind="orientation"), 1)
    with pytest.raises(jtik.ArgumentError, match=r"joints \(2\); it has 3"):
        problems.near_singular(planar(2), jtik.FrameTask(kind="pose"), 1)


@pytest.mark.parametrize("share", [0.02, 0.002])
def test_one_of_the_two_postures_of_two_links_is_at_a_limit(share):
    robot = jtik.Robot.planar(2, lower=[-1.0, -2.0], upper=[2.0, 2.5])
    for case in problems.near_limits(robot, jtik.FrameTask(), 20, share=share):
        x, y = case.target
        elbow = np.arccos(np.clip((x * x + y * y - 2) / 2, -1, 1))
        postures = []
        for q2 in (elbow, -elbow):
            q1 = np.arctan2(y, x) - np.arctan2(np.sin(q2), 1 + np.cos(q2))
            q = np.array([(q1 + np.pi) % (2 * np.pi) - np.pi, q2])
            if (q >= robot.lower - 1e-9).all() and (q <= robot.upper + 1e-9).all():
                postures.append(np.minimum(q - robot.lower, robot.upper - q) / (robot.upper - robot.lower))
        assert min(posture.min() for posture in postures) <= share + 1e-9


def test_goals_are_at_lower_and_upper_limits_of_one_or_several_joints():
    # each row of the target is the position of one prismatic joint
    robot = jtik.Robot.vehicle(1, heading=False, vehicle_lower=-1.0, vehicle_upper=3.0)
    made = problems.near_limits(robot, jtik.FrameTask("vehicle"), 40, joints=["x", "y"])
    places = np.array([case.target for case in made])
    low, high = places <= -1 + 0.08, places >= 3 - 0.08
    assert ((low | high).sum(axis=1) >= 1).all()
    assert {1, 2} == set((low | high).sum(axis=1))
    assert low.any(axis=0).all()
    assert high.any(axis=0).all()
