"""track's Trajectory: times, positions, velocities, errors."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn

import jtik

from ..conftest import floating_arm, planar, shared_solver


def circle(k):
    angle = np.linspace(0, 2 * np.pi, k, endpoint=False)
    return np.stack([1.5 + 0.4 * np.cos(angle), 0.5 + 0.4 * np.sin(angle)], axis=1)


@pytest.fixture(scope="module")
def path():
    return shared_solver(planar(3), jtik.FrameTask()).track(circle(20), q0=[0.3, 0.4, 0.5], dt=0.1)


def test_velocities_lead_from_row_to_row(path):
    rows = np.vstack([[0.3, 0.4, 0.5], path.q])
    assert path.dq == pytest.approx(np.diff(rows, axis=0) / 0.1)
    assert path.times == pytest.approx(0.1 * np.arange(1, 21))
    assert path.joint_names == ("joint1", "joint2", "joint3")


def test_velocities_keep_to_the_limits():
    robot = planar(3, velocity_limit=0.8)
    path = shared_solver(robot, jtik.FrameTask()).track(circle(20), q0=[0.3, 0.4, 0.5], dt=0.1)
    assert np.abs(path.dq).max() == pytest.approx(0.8)  # they bind
    assert not path.converged


def test_velocities_of_a_free_joint_are_those_of_its_tangent():
    robot = floating_arm()
    q0, rng = robot.neutral, np.random.default_rng(0)
    target = robot.position(robot.integrate(q0, rng.uniform(-0.2, 0.2, robot.n)))
    path = shared_solver(robot, jtik.FrameTask()).track([target], q0=q0, dt=0.5)
    assert path.dq.shape == (1, robot.n)
    assert robot.integrate(q0, 0.5 * path.dq[0]) == pytest.approx(path.q[0])


def test_errors_and_status_are_those_of_solutions(path):
    ik = shared_solver(planar(3), jtik.FrameTask())
    for i, target in enumerate(circle(20)):
        solution = ik.solve(target, q0=path.q[i], max_iterations=0)
        assert path.position_error[i] == pytest.approx(solution.position_error, abs=1e-15)
        assert path.orientation_error[i] == solution.orientation_error == 0
        assert path.error_norm[i] == pytest.approx(np.linalg.norm(solution.error), abs=1e-15)
        assert path.status[i] is solution.status


def test_reached_is_for_each_target_and_converged_for_all():
    ik = shared_solver(planar(3), jtik.FrameTask())
    path = ik.track([(1.0, 1.5), (9.0, 0.0)], q0=[0.3, 0.2, 0.4], dt=0.5)
    assert path.reached.tolist() == [True, False]
    assert path.converged is False
    assert ik.track([(1.0, 1.5)], q0=[0.3, 0.2, 0.4]).converged is True


def test_repr_sums_it_up():
    ik = shared_solver(planar(3), jtik.FrameTask())
    path = ik.track([(1.0, 1.5), (1.1, 1.5)], q0=[0.3, 0.2, 0.4], dt=0.5)
    assert len(path) == len(path.q) == len(path.error_norm) == len(path.status) == 2
    assert path.times.tolist() == [0.5, 1.0]
    assert "2 of 2 targets reached, 1 s" in repr(path)


@pytest.mark.parametrize(("old", "new"), [("errors", "error_norm"), ("statuses", "status")])
def test_old_names_warn(path, old, new):
    with pytest.warns(DeprecationWarning, match=rf"^Trajectory\.{old} is deprecated: use {new}$"):
        assert getattr(path, old) is getattr(path, new)


def test_it_can_be_pickled(path):
    again = pickle.loads(pickle.dumps(path))
    assert np.array_equal(again.q, path.q)
    assert repr(again) == repr(path)


def lissajous(robot, k):
    """Poses about the arm's home: a figure of 10 by 30 by 20 cm, with the tool swaying by 0.2 rad."""
    home = robot.pose(robot.keyframes["home"])
    for phase in np.linspace(0, 2 * np.pi, k):
        pose, sway = home.copy(), 0.2 * np.array([np.sin(phase), np.sin(2 * phase), 0.0])
        pose[:3, 3] += 0.05 * np.sin(3 * phase), 0.15 * np.sin(2 * phase), 0.1 * np.sin(phase)
        pose[:3, :3] = pose[:3, :3] @ Turn.from_rotvec(sway).as_matrix()
        yield pose


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", ["hybrid", "damped", "newton"])
def test_an_arm_follows_a_curve_of_poses_within_its_published_limits(strategy, tmp_path):
    robot = jtik.Robot.builtin("panda")
    ik, home = shared_solver(robot, jtik.FrameTask("tip", "pose"), strategy=strategy), robot.keyframes["home"]
    path = ik.track(lissajous(robot, 100), q0=home, dt=0.05)
    assert path.converged
    assert path.iterations.mean() < 3  # each solve starts where the last one ended
    assert (np.abs(path.dq) <= robot.velocity_limit).all()
    assert ((robot.lower <= path.q) & (path.q <= robot.upper)).all()
    for q, target in zip(path.q, lissajous(robot, 100), strict=True):
        assert robot.pose(q) == pytest.approx(target, abs=2e-6)
    path.save(tmp_path / "curve.csv")
    again = jtik.Trajectory.load(tmp_path / "curve.csv")
    assert np.array_equal(again.q, path.q)
    assert again.joint_names == robot.joint_names


def test_a_curve_too_fast_for_an_arm_is_followed_at_its_limits_and_caught_up_with():
    robot = jtik.Robot.builtin("panda")
    ik, home = shared_solver(robot, jtik.FrameTask("tip", "pose")), robot.keyframes["home"]
    curve = list(lissajous(robot, 50))
    path = ik.track([*curve, *[curve[-1]] * 100], q0=home, dt=0.01)
    reached = [status is jtik.Status.CONVERGED for status in path.status]
    assert not all(reached[:50])
    assert all(reached[-20:])
    assert (np.abs(path.dq) <= robot.velocity_limit * (1 + 1e-12)).all()
    assert (np.abs(path.dq) > 0.99 * robot.velocity_limit).any()
