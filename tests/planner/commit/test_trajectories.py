"""Attempts as trajectories with their files, and pictures of the chosen one."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.planner.commit.committing import timed
from jtik.planner.commit.trajectories import animation, as_trajectory, figure

from ...conftest import ball_arm
from ..conftest import SCENE, make_attempt


@pytest.mark.parametrize("suffix", ["csv", "json", "npz"])
@pytest.mark.parametrize("kind", ["planar", "ball"])
def test_an_attempt_is_saved_and_loaded_as_a_trajectory(tmp_path, kind, suffix, rng):
    robot = jtik.Robot.planar(3) if kind == "planar" else ball_arm()
    q = np.array([robot.random_configuration(rng) for _ in range(5)])
    targets = np.array([robot.position(each) for each in q])
    targets[3, 0] += 0.5
    attempt = make_attempt(k=5, configurations=q, targets=targets)
    trajectory = as_trajectory(attempt, robot)
    assert trajectory.reached.tolist() == [True, True, False, True]
    assert trajectory.position_error == pytest.approx([0, 0, 0.5, 0], abs=1e-12)
    for i in range(4):
        assert trajectory.dq[i] == pytest.approx(robot.difference(q[i], q[i + 1]) * 60)
    trajectory.save(tmp_path / f"a.{suffix}")
    again = jtik.Trajectory.load(tmp_path / f"a.{suffix}")
    assert (again.start == q[0]).all()
    assert (again.q == q[1:]).all()
    assert (again.times == attempt.times[1:]).all()


def pixels(picture) -> np.ndarray:
    picture.canvas.draw()
    return np.asarray(picture.canvas.buffer_rgba())[..., :3].copy()


def test_the_figure_has_the_postures_and_the_obstacles_of_the_end(arm):
    pytest.importorskip("matplotlib")
    attempt = make_attempt(k=200, scenes=[(0.0, SCENE), (1.0, {})])
    plain = pixels(figure(attempt, arm, width=4.0))
    assert (plain == pixels(figure(attempt, arm, scene={}, width=4.0))).all()
    with_post = pixels(figure(attempt, arm, scene=SCENE, width=4.0))
    assert with_post.shape != plain.shape or (with_post != plain).any()


@pytest.mark.quick(1)
@pytest.mark.parametrize("kind", ["attempt", "commands"])
def test_the_animation_takes_the_time_of_the_motion(tmp_path, arm, kind):
    image = pytest.importorskip("PIL.Image")
    attempt = make_attempt(k=61, scenes=[(0.0, SCENE)])
    motion = attempt if kind == "attempt" else timed(attempt, arm)
    path = tmp_path / "a.gif"
    animation(path, motion, arm, rate=10.0, width=2.0, speed=0.5)
    with image.open(path) as opened:
        frames = opened.n_frames
        durations = []
        for i in range(frames - 1):
            opened.seek(i)
            durations.append(opened.info["duration"])
    wanted = motion.times[-1] / 0.5
    assert sum(durations) / 1000 == pytest.approx(wanted, abs=0.15)
    assert frames <= 1 + round(10 * wanted)
