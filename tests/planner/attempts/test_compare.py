"""Figures of attempts, against closed forms."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import jtik
from jtik.planner.attempts.compare import COLUMNS, measure, table
from jtik.study.path_metrics import path_length, smoothness

from ...conftest import EXACT
from ..conftest import make_attempt


def disc(x, y, radius, gain=1.0):
    return {"obstacles": {"post": {"shape": "circle", "center": [x, y], "radius": radius, "gain": gain}}}


def swept(arm, angles, dt=0.1, **values):
    """One link that turns through angles, with targets at its tip."""
    q = np.asarray(angles, dtype=float)[:, None]
    targets = np.array([arm.position(each) for each in q])
    times = dt * np.arange(len(q))
    return make_attempt(times=times, configurations=q, targets=targets, dt=dt, **values)


@pytest.fixture(scope="module")
def link():
    turning = jtik.Joint("a", jtik.JointType.REVOLUTE, "base", "tip0", axis=(0, 0, 1), lower=-2.0, upper=1.5)
    return jtik.Robot([turning, fixed()], planar=True)


def fixed():
    origin = np.eye(4)
    origin[0, 3] = 1.0
    return jtik.Joint("b", jtik.JointType.FIXED, "tip0", "tip", origin=origin)


def test_the_figures_of_one_turning_link(link):
    angles = np.linspace(-1.0, 1.0, 21)
    found = measure(swept(link, angles, scenes=[(0.0, disc(1.2, 0.0, 0.1))]), link, accuracy=1e-6)
    assert found.duration == pytest.approx(2.0)
    assert found.path_length == pytest.approx(20 * 2 * math.sin(0.05))
    assert found.joint_length == pytest.approx(2.0)
    assert found.smoothness == pytest.approx(0.0, abs=1e-10)
    assert found.reversals == 0
    assert found.clearance == pytest.approx(0.1, abs=1e-6)
    assert found.clearance_bound <= 0.1 + EXACT
    assert found.clearance_time == pytest.approx(1.0, abs=1e-2)
    assert found.clearance_obstacle == "post"
    assert (found.limit_margin, found.limit_joint, found.limit_time) == (pytest.approx(0.5), "a", pytest.approx(2.0))
    assert found.target_error == pytest.approx(0.0, abs=EXACT)
    assert not found.closed
    assert math.isnan(found.closing_error)


def test_smoothness_and_lengths_agree_with_those_of_studies(arm):
    attempt = make_attempt(k=40)
    found = measure(attempt, arm)
    assert found.smoothness == pytest.approx(smoothness(arm, attempt.configurations, 1 / 60), rel=1e-9)
    assert found.joint_length == pytest.approx(path_length(arm, attempt.configurations), rel=1e-12)


def test_reversals_and_accelerations_of_a_zigzag(link):
    found = measure(swept(link, [0.0, 0.1, 0.2, 0.1, 0.1, 0.0, 0.1]), link)
    assert found.reversals == 2
    accelerations = np.diff([1.0, 1.0, -1.0, 0.0, -1.0, 1.0]) / 0.1
    assert found.smoothness == pytest.approx(np.sqrt((accelerations**2).mean()))


def test_uneven_times_of_a_constant_acceleration(link):
    times = np.array([0.0, 0.1, 0.25, 0.3, 0.5])
    attempt = make_attempt(times=times, configurations=(times**2)[:, None], targets=np.zeros((5, 2)), dt=0.1)
    assert measure(attempt, link).smoothness == pytest.approx(2.0)


def test_the_closing_error_of_a_closed_path(arm):
    """Targets on a circle; the arm comes back to the same position with another posture."""
    angle = np.linspace(0, 2 * np.pi, 41)
    targets = np.stack([1.5 + 0.3 * np.cos(angle), 0.3 * np.sin(angle)], axis=1)
    q = np.linspace([0.1, 0.2, 0.3], [0.2, 0.1, 0.5], 41)
    found = measure(make_attempt(k=41, configurations=q, targets=targets), arm)
    assert found.closed
    assert found.closing_error == pytest.approx(math.sqrt(0.01 + 0.01 + 0.04))
    assert found.closing_distance == pytest.approx(float(np.linalg.norm(arm.position(q[-1]) - arm.position(q[0]))))


def test_the_condition_number_of_two_links():
    arm = jtik.Robot.planar(2)
    q = np.array([[0.3, 1.2], [0.3, 0.4], [0.3, 2.0]])
    found = measure(make_attempt(k=3, configurations=q), arm)
    assert found.condition == pytest.approx(np.linalg.cond(arm.jacobian(q[1], rows="linear")))
    assert found.condition_time == pytest.approx(1 / 60)
    straight = measure(make_attempt(k=2, configurations=np.zeros((2, 2))), arm)
    assert straight.condition == math.inf
    assert straight.to_json()["condition"] is None


def test_the_rows_of_a_pose_count_the_orientation():
    robot = jtik.Robot.builtin("panda")
    q = np.stack([robot.home, robot.home])
    pose = robot.pose(robot.home)
    targets = np.tile([*pose[:3, 3], 1.0, 0.0, 0.0, 0.0], (2, 1))
    found = measure(make_attempt(k=2, configurations=q, targets=targets), robot)
    assert found.condition == pytest.approx(np.linalg.cond(robot.jacobian(robot.home)), rel=1e-9)
    assert found.target_error == pytest.approx(0.0, abs=EXACT)


def test_each_piece_is_judged_by_the_obstacles_of_its_time(link):
    """The disc that the tip passes is there only before it comes, or only while it passes."""
    angles = np.linspace(-1.0, 1.0, 21)
    away, near = disc(5.0, 5.0, 0.1), disc(1.2, 0.0, 0.1)
    before = measure(swept(link, angles, scenes=[(0.0, near), (0.5, away)]), link).clearance
    tip = np.array([math.cos(-0.5), math.sin(-0.5)])
    assert before == pytest.approx(math.hypot(tip[0] - 1.2, tip[1]) - 0.1, abs=2e-3)
    during = measure(swept(link, angles, scenes=[(0.0, away), (0.95, near), (1.05, away)]), link).clearance
    assert during == pytest.approx(0.1, abs=2e-3)
    off = measure(swept(link, angles, scenes=[(0.0, disc(1.2, 0.0, 0.1, gain=0.0))]), link)
    assert (off.clearance, off.clearance_obstacle) == (math.inf, "")


def test_the_nearest_obstacle_is_named_among_several_shapes(arm):
    scene = jtik.Scene(
        {
            "wall": jtik.HalfSpace((0.0, -3.5), (0.0, 1.0)),
            "block": jtik.Box(np.array([[1.0, 0, 2.0], [0, 1.0, 0.5], [0, 0, 1.0]]), (0.2, 0.2)),
            "post": jtik.Circle((3.0, 3.0), 0.2),
        }
    ).to_dict()
    found = measure(make_attempt(k=2, configurations=np.zeros((2, 3)), scenes=[(0.0, scene)]), arm)
    assert found.clearance_obstacle == "block"
    assert found.clearance == pytest.approx(0.3)


def test_a_table_has_one_line_for_each_attempt_and_marks_the_chosen_one(arm, link):
    rows = [measure(make_attempt(name, k=5), arm) for name in ("attempt 1", "attempt 2")]
    lines = table(rows, chosen="attempt 2").splitlines()
    assert len(lines) == 3
    assert "attempt 2 *" in lines[2]
    assert "attempt 1 *" not in lines[1]
    assert {len(line) for line in lines} == {len(lines[0])}
    assert json.loads(json.dumps([row.to_json() for row in rows], allow_nan=False))[0]["clearance"] is None
    assert {key for key, _, _ in COLUMNS} <= set(rows[0].to_json())
