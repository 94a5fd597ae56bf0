"""Checks of a motion, and commands that pass them."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.constraints import Limits
from jtik.errors import ArgumentError
from jtik.planner.commit.commands import FORMATS, load
from jtik.planner.commit.committing import ACCELERATION, PICTURES, SPEED, check, commit, timed

from ...conftest import ball_arm, floating_arm
from ..conftest import SCENE, make_attempt
from .test_timing import METHODS

DT = 0.1


def limited_arm() -> jtik.Robot:
    """A revolute and a prismatic joint in the plane."""
    turn, slide = jtik.JointType.REVOLUTE, jtik.JointType.PRISMATIC
    return jtik.Robot(
        [
            jtik.Joint("turn", turn, "base", "a", axis=(0, 0, 1), lower=-1.0, upper=1.0, velocity_limit=2.0),
            jtik.Joint("lift", slide, "a", "tip", axis=(1, 0, 0), lower=0.5, upper=1.5, velocity_limit=0.5),
        ],
        planar=True,
    )


def motion(q, **values):
    q = np.asarray(q, dtype=float)
    return make_attempt(times=DT * np.arange(len(q)), configurations=q, targets=np.zeros((len(q), 2)), dt=DT, **values)


def still(k=5):
    return np.tile([0.0, 1.0], (k, 1))


def test_a_motion_within_all_limits_has_no_finding():
    assert check(motion(still(), scenes=[(0.0, SCENE)]), limited_arm(), limits=Limits(acceleration=1.0)) == ()


def test_each_limit_is_found_by_joint_time_and_figure():
    q = still(7)
    q[:, 0] = [0.0, 0.1, 0.4, 0.9, 1.2, 1.2, 1.2]
    q[:, 1] = [1.0, 1.0, 1.0, 0.99, 0.97, 0.9, 0.85]
    found = {
        (each.kind, each.joint): each for each in check(motion(q), limited_arm(), limits=Limits(acceleration=40.0))
    }
    assert set(found) == {("position", "turn"), ("velocity", "turn"), ("velocity", "lift")}
    position = found["position", "turn"]
    assert (position.time, position.value, position.limit) == (pytest.approx(0.4), 1.2, 1.0)
    assert position.text == "turn is at 1.2 rad at 0.400 s; its limit is 1 rad"
    speed = found["velocity", "turn"]
    assert (speed.time, speed.value, speed.limit) == (pytest.approx(0.25), pytest.approx(5.0), 2.0)
    assert found["velocity", "lift"].text == "lift moves at 0.7 m/s at 0.450 s; its limit is 0.5 m/s"
    assert found["velocity", "lift"].to_json()["value"] == pytest.approx(0.7)


def test_accelerations_count_from_rest_and_to_rest():
    q = still(4)
    q[:, 0] = [0.0, 0.1, 0.2, 0.3]
    limits = Limits(acceleration=9.0)
    (found,) = check(motion(q), limited_arm(), limits=limits)
    assert (found.kind, found.joint, found.value, found.time) == ("acceleration", "turn", pytest.approx(10.0), 0.0)
    assert found.text == "turn accelerates at 10 rad/s^2 at 0.000 s; its limit is 9 rad/s^2"
    q[:, 0] = [0.0, 0.05, 0.1, 0.5]
    (found,) = check(motion(q), limited_arm(), limits=Limits(velocity=False, acceleration=36.0))
    assert (found.value, found.time) == (pytest.approx(40.0), pytest.approx(0.3))


def test_an_obstacle_between_two_samples_is_found():
    scene = jtik.Scene({"post": jtik.Circle((1.05, 0.0), 0.1)}).to_dict()
    q = np.array([[-0.5, 1.0], [0.5, 1.0]])
    limits = Limits(velocity=False)
    (found,) = check(motion(q), limited_arm(), limits=limits, scene=scene)
    assert (found.kind, found.value) == ("clearance", pytest.approx(-0.05, abs=2e-3))
    assert "inside post" in found.text
    assert found.time == pytest.approx(0.05, abs=0.01)
    far = jtik.Scene({"post": jtik.Circle((1.3, 0.0), 0.1)}).to_dict()
    assert check(motion(q), limited_arm(), limits=limits, scene=far, safe=0.1) == ()
    (found,) = check(motion(q, scenes=[(0.0, far)]), limited_arm(), limits=limits, safe=0.25)
    assert found.value == pytest.approx(0.2, abs=2e-3)
    assert found.limit == 0.25
    assert "comes within 0.2" in found.text


def test_the_last_obstacles_of_an_attempt_count_unless_others_are_given():
    near = jtik.Scene({"post": jtik.Circle((1.0, 0.0), 0.1)}).to_dict()
    attempt = motion(still(), scenes=[(0.0, near), (0.1, {})])
    assert check(attempt, limited_arm()) == ()
    assert len(check(attempt, limited_arm(), scene=near)) == 1


@pytest.mark.parametrize("method", METHODS)
def test_what_is_timed_passes_the_check(method):
    arm = limited_arm()
    q = np.stack([0.9 * np.sin(np.linspace(0, 9, 200)), 1 + 0.4 * np.cos(np.linspace(0, 7, 200))], axis=1)
    limits = Limits(acceleration=[3.0, 1.0])
    attempt = motion(q)
    assert check(attempt, arm, limits=limits)
    commands = timed(attempt, arm, limits=limits, period=0.01, method=method)
    assert check(commands, arm, limits=limits) == ()
    assert commands.method == method
    assert commands.note == ""
    assert commands.units == ("rad", "m")
    assert np.allclose(np.diff(commands.times), 0.01)
    assert (commands.positions[0] == q[0]).all()
    assert (commands.positions[-1] == q[-1]).all()
    assert (commands.velocities[[0, -1]] == 0).all()


def test_what_a_robot_does_not_say_is_assumed_and_told():
    arm = jtik.Robot.planar(3)
    commands = timed(make_attempt(k=90), arm)
    speeds = np.abs(np.diff(commands.positions, axis=0)) / 0.01
    assert speeds.max() <= SPEED * (1 + 1e-9)
    assert np.abs(np.diff(speeds, axis=0)).max() / 0.01 <= ACCELERATION * (1 + 1e-6)
    assert "without a speed limit" in commands.note
    assert "without an acceleration limit" in commands.note
    assert "speed" not in timed(make_attempt(k=90), arm, limits=Limits(velocity=False, acceleration=3.0)).note


def test_smoothing_is_told_and_bounded():
    arm, rng = jtik.Robot.planar(2), np.random.default_rng(0)
    q = np.linspace([0, 0], [1, -1], 200) + 5e-3 * rng.normal(size=(200, 2))
    plain, smooth = timed(motion(q), arm), timed(motion(q), arm, smoothing=0.02)
    assert smooth.duration < 0.5 * plain.duration
    assert "0.02 rad" in smooth.note
    for each in q:
        assert np.abs(smooth.positions - each).max(axis=1).min() <= 0.02 + 5e-3
    assert check(smooth, arm, limits=Limits(velocity=SPEED, acceleration=ACCELERATION)) == ()
    with pytest.raises(ArgumentError, match="smoothing"):
        timed(motion(q), arm, smoothing=-1.0)


def shaken(seed: int = 0) -> np.ndarray:
    """A path that a hand has guided: it trembles."""
    return np.linspace([0, 0], [1, -1], 200) + 5e-3 * np.random.default_rng(seed).normal(size=(200, 2))


def test_a_path_that_was_guided_by_hand_is_smoothed_by_default(tmp_path):
    arm, attempt = jtik.Robot.planar(2), motion(shaken())
    done = commit(attempt, arm, tmp_path / "a.csv", "csv")
    exact = commit(attempt, arm, tmp_path / "b.csv", "csv", smoothing=0.0)
    assert done.commands.times[-1] < 0.5 * exact.commands.times[-1]
    assert done.findings == ()
    assert "smoothed" in done.commands.note
    assert "smoothed" not in exact.commands.note
    for each in attempt.configurations:
        assert np.abs(done.commands.positions - each).max(axis=1).min() <= 0.02 + 5e-3


def test_no_smoothing_cuts_a_corner_into_an_obstacle(tmp_path):
    slide = jtik.JointType.PRISMATIC
    joints = [
        jtik.Joint("x", slide, "base", "a", axis=(1, 0, 0), lower=-2.0, upper=2.0),
        jtik.Joint("y", slide, "a", "tip", axis=(0, 1, 0), lower=-2.0, upper=2.0),
    ]
    gantry = jtik.Robot(joints, planar=True)
    ramp = np.linspace(0.0, 1.0, 120)
    corner = np.concatenate([np.stack([ramp, 0 * ramp], axis=1), np.stack([1 + 0 * ramp, ramp], axis=1)[1:]])
    center = np.array([0.97, 0.02])
    attempt = motion(corner, scenes=[(0.0, jtik.Scene({"post": jtik.Circle(tuple(center), 0.01)}).to_dict())])

    def away(commands):  # the tip is what goes around the corner
        return np.linalg.norm(commands.positions - center, axis=1).min() - 0.01

    cut = commit(attempt, gantry, tmp_path / "a.csv", "csv", safe=0.009, smoothing=0.02)
    assert away(cut.commands) < 0.009
    assert [each.kind for each in cut.findings] == ["clearance"]
    done = commit(attempt, gantry, tmp_path / "a.csv", "csv", safe=0.009)
    assert away(done.commands) >= 0.009
    assert done.findings == ()
    assert "0.02 rad" not in done.commands.note
    none = commit(attempt, gantry, tmp_path / "a.csv", "csv", safe=0.015)  # the attempt itself comes nearer
    assert "smoothed" not in none.commands.note
    assert [each.kind for each in none.findings] == ["clearance"]


def test_a_motion_of_another_robot_and_wrong_arguments_are_refused():
    with pytest.raises(ArgumentError, match="motion"):
        check(make_attempt(nq=3), limited_arm())
    with pytest.raises(ArgumentError, match="safe"):
        check(motion(still()), limited_arm(), safe=-1.0)
    with pytest.raises(ArgumentError, match="period"):
        timed(motion(still()), limited_arm(), period=0.0)
    with pytest.raises(ArgumentError, match="no joint moves"):
        timed(motion(still()), limited_arm())
    with pytest.raises(ArgumentError, match="ball or free"):
        timed(make_attempt(nq=10), ball_arm())
    with pytest.raises(ArgumentError, match="shape"):
        check(motion(still()), limited_arm(), scene={"obstacles": {"a": {"shape": "cone"}}})


def test_a_floating_base_is_checked_too():
    robot = floating_arm()
    q = np.array([robot.neutral, robot.neutral])
    q[1, robot.q_slice("two")] = 2.5
    found = check(motion(q), robot, limits=Limits(velocity=5.0))
    assert [(each.kind, each.joint) for each in found] == [("position", "two"), ("velocity", "two")]
    assert math.isclose(found[1].value, 25.0)


@pytest.mark.quick(1)
@pytest.mark.parametrize("format", ["csv", "json", "npz", "ros2_json", "ros2_yaml", "figure", "animation"])
def test_commit_times_checks_and_writes_every_format(tmp_path, format):
    if format in PICTURES:
        pytest.importorskip("matplotlib")
    arm = jtik.Robot.planar(3)
    scene = jtik.Scene({"post": jtik.Circle((3.05, 0.3), 0.1)}).to_dict()
    q = np.linspace([0.0, 0.0, 0.0], [0.3, 0.0, 0.0], 30)
    suffix = PICTURES[format] if format in PICTURES else FORMATS[format].suffix
    done = commit(motion(q, scenes=[(0.0, scene)]), arm, tmp_path / f"a{suffix}", format, safe=0.02)
    assert done.path.stat().st_size > 100
    (found,) = done.findings
    assert found.kind == "clearance"
    assert "post" in found.text
    assert commit(motion(q), arm, tmp_path / f"b{suffix}", format, safe=0.02).findings == ()


def test_a_commit_that_keeps_the_times_is_checked_as_recorded(tmp_path):
    q = still(3)
    q[:, 0] = [0.0, 0.5, 0.5]
    done = commit(motion(q), limited_arm(), tmp_path / "a.csv", "csv", recorded=True)
    assert [each.kind for each in done.findings] == ["velocity"]
    assert (load(done.path).times == motion(q).times).all()
    assert commit(motion(q), limited_arm(), tmp_path / "a.csv", "csv").findings == ()
    with pytest.raises(ArgumentError, match="format"):
        commit(motion(q), limited_arm(), tmp_path / "a.csv", "bag")
