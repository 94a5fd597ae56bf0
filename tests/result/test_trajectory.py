"""track's Trajectory: times, positions, velocities, and its files."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Turn

import jtik

from ..conftest import floating_arm, planar


def circle(k):
    angle = np.linspace(0, 2 * np.pi, k, endpoint=False)
    return np.stack([1.5 + 0.4 * np.cos(angle), 0.5 + 0.4 * np.sin(angle)], axis=1)


@pytest.fixture(scope="module")
def path():
    return jtik.InverseKinematics(planar(3), jtik.FrameTask()).track(circle(20), q0=[0.3, 0.4, 0.5], dt=0.1)


def test_velocities_lead_from_row_to_row(path):
    rows = np.vstack([[0.3, 0.4, 0.5], path.q])
    assert path.dq == pytest.approx(np.diff(rows, axis=0) / 0.1)
    assert path.times == pytest.approx(0.1 * np.arange(1, 21))
    assert path.joint_names == ("joint1", "joint2", "joint3")


def test_velocities_keep_to_the_limits():
    robot = planar(3, velocity_limit=0.8)
    path = jtik.InverseKinematics(robot, jtik.FrameTask()).track(circle(20), q0=[0.3, 0.4, 0.5], dt=0.1)
    assert np.abs(path.dq).max() == pytest.approx(0.8)  # they bind
    assert not path.converged


def test_velocities_of_a_free_joint_are_those_of_its_tangent():
    robot = floating_arm()
    q0, rng = robot.neutral, np.random.default_rng(0)
    target = robot.position(robot.integrate(q0, rng.uniform(-0.2, 0.2, robot.n)))
    path = jtik.InverseKinematics(robot, jtik.FrameTask()).track([target], q0=q0, dt=0.5)
    assert path.dq.shape == (1, robot.n)
    assert robot.integrate(q0, 0.5 * path.dq[0]) == pytest.approx(path.q[0])


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_files_bring_it_back_to_the_last_bit(path, suffix, tmp_path):
    path.save(tmp_path / f"circle{suffix}")
    again = jtik.Trajectory.load(str(tmp_path / f"circle{suffix}"))
    for field in dataclasses.fields(path):
        before, after = getattr(path, field.name), getattr(again, field.name)
        assert np.array_equal(before, after)
        assert type(before) is type(after)
    assert again.dq.dtype == np.float64
    assert repr(again) == repr(path)


def test_a_csv_is_a_table_that_others_read(path, tmp_path):
    path.save(tmp_path / "circle.csv")
    lines = (tmp_path / "circle.csv").read_text().splitlines()
    assert lines[0] == "# joints: joint1,joint2,joint3"
    assert lines[1].startswith("times,q[0],q[1],q[2],dq[0]")
    table = np.genfromtxt(tmp_path / "circle.csv", delimiter=",", skip_header=1, names=True, dtype=None, encoding=None)
    assert table["q1"] == pytest.approx(path.q[:, 1])


@pytest.mark.parametrize("name", ["path.txt", "path"])
def test_other_suffixes_are_refused(path, name, tmp_path):
    with pytest.raises(jtik.ArgumentError, match=r"\.npz or \.csv"):
        path.save(tmp_path / name)
    with pytest.raises(jtik.ArgumentError, match=r"\.npz or \.csv"):
        jtik.Trajectory.load(tmp_path / name)


def test_other_files_are_refused(path, tmp_path):
    (tmp_path / "a.csv").write_text("x,y\n1,2\n")
    (tmp_path / "b.csv").write_text("# joints: a\ntimes,q[0]\n0.1,0.2\n")
    (tmp_path / "c.npz").write_bytes(b"not an archive")
    np.savez(tmp_path / "d.npz", times=np.zeros(2))
    path.save(tmp_path / "e.csv")
    (tmp_path / "e.csv").write_text((tmp_path / "e.csv").read_text().replace("CONVERGED", "HAPPY", 1))
    (tmp_path / "f.csv").write_text("# joints: a\ntimes,q[0]\n0.1\n")
    for name in "abcdef":
        suffix = ".npz" if name in "cd" else ".csv"
        with pytest.raises(jtik.ArgumentError, match=f"{name}{suffix}"):
            jtik.Trajectory.load(tmp_path / f"{name}{suffix}")
    with pytest.raises(FileNotFoundError):
        jtik.Trajectory.load(tmp_path / "missing.csv")


def lissajous(robot, k):
    """Poses about the arm's home: a figure of 10 by 30 by 20 cm, with the tool swaying by 0.2 rad."""
    home = robot.pose(robot.keyframes["home"])
    for phase in np.linspace(0, 2 * np.pi, k):
        pose, sway = home.copy(), 0.2 * np.array([np.sin(phase), np.sin(2 * phase), 0.0])
        pose[:3, 3] += 0.05 * np.sin(3 * phase), 0.15 * np.sin(2 * phase), 0.1 * np.sin(phase)
        pose[:3, :3] = pose[:3, :3] @ Turn.from_rotvec(sway).as_matrix()
        yield pose


@pytest.mark.parametrize("strategy", ["hybrid", "damped", "newton"])
def test_an_arm_follows_a_curve_of_poses_within_its_published_limits(strategy, tmp_path):
    robot = jtik.Robot.builtin("panda")
    ik, home = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "pose"), strategy=strategy), robot.keyframes["home"]
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
    ik, home = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "pose")), robot.keyframes["home"]
    curve = list(lissajous(robot, 50))
    path = ik.track([*curve, *[curve[-1]] * 100], q0=home, dt=0.01)
    reached = [status is jtik.Status.CONVERGED for status in path.status]
    assert not all(reached[:50])
    assert all(reached[-20:])
    assert (np.abs(path.dq) <= robot.velocity_limit * (1 + 1e-12)).all()
    assert (np.abs(path.dq) > 0.99 * robot.velocity_limit).any()
