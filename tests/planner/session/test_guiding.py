"""The loop: the arm follows the guided target within its limits, and says what it does."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from jtik.planner.edits.messages import HoldTarget, Jog, MoveTarget, SetLimits, SetTargetSpeed
from jtik.planner.session.loop import DT
from jtik.planner.session.measure import words
from tests.planner.operator import ROBOT, START, Operator


@pytest.fixture
def operator() -> Operator:
    return Operator()


def test_the_arm_follows_the_target(operator: Operator) -> None:
    goal = (2.4, 0.8)
    operator.does(MoveTarget(goal), seconds=3)
    np.testing.assert_array_equal(operator.loop.frame.position, goal)
    np.testing.assert_allclose(operator.tip, goal, atol=1e-5)
    assert operator.loop.status.error < 1e-5
    operator.go(10)
    assert operator.loop.status.words == "at rest on the target"


def test_no_joint_is_faster_than_its_limit(operator: Operator) -> None:
    operator.loop.submit(SetTargetSpeed(100.0))
    operator.loop.submit(MoveTarget((-1.0, 2.5)))
    q = [START]
    for _ in range(120):
        operator.go()
        q.append(operator.loop.frame.q)
    speeds = np.abs(np.diff(q, axis=0)) / DT
    assert speeds.max() <= 2.0 + 1e-9
    assert speeds.max() > 1.9  # it is the limit that slows the arm down


def test_the_poses_of_a_frame_are_those_of_the_robot(operator: Operator) -> None:
    operator.does(MoveTarget((2.0, 1.0)), seconds=0.5)
    frame = operator.loop.frame
    for name, pose in zip(operator.loop.setup.frames, frame.poses, strict=True):
        expected = ROBOT.pose(frame.q, name)
        np.testing.assert_allclose(pose[:3], expected[:3, 3], atol=1e-12)
        w, x, y, z = pose[3:]
        np.testing.assert_allclose([x, y], 0, atol=1e-12)
        np.testing.assert_allclose(2 * np.arctan2(z, w), np.arctan2(expected[1, 0], expected[0, 0]), atol=1e-9)


def test_frames_are_published_only_when_something_moves(operator: Operator) -> None:
    operator.go(8)
    before, heartbeat = operator.loop.frame, operator.loop.status.heartbeat
    operator.go(1)
    assert operator.loop.frame is before
    assert operator.loop.status.heartbeat == heartbeat + 10
    operator.does(MoveTarget((2.0, 1.0)), seconds=0.1)
    assert operator.loop.frame is not before
    assert operator.loop.frame.tick > before.tick


def test_what_is_published_cannot_be_changed(operator: Operator) -> None:
    frame = operator.loop.frame
    for array in (frame.q, frame.position, frame.orientation, frame.poses):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_a_key_moves_the_target_until_it_is_released(operator: Operator) -> None:
    start = operator.loop.frame.position
    operator.does(HoldTarget((0.0, -0.5)), seconds=1)
    np.testing.assert_allclose(operator.loop.frame.position - start, (0, -0.5), atol=1e-12)
    assert operator.loop.status.words == "follows the target"
    operator.does(HoldTarget((0.0, 0.0)), seconds=1)
    np.testing.assert_allclose(operator.loop.frame.position - start, (0, -0.5), atol=1e-12)


def test_a_target_out_of_reach_is_told_and_followed_as_far_as_possible(operator: Operator) -> None:
    operator.does(MoveTarget((6.0, 0.0)), seconds=12)
    status = operator.loop.status
    np.testing.assert_allclose(operator.tip, (4.0, 0.0), atol=1e-2)
    assert abs(status.error - 2.0) < 1e-2
    assert "out of reach" in status.words or "singular" in status.words
    operator.does(MoveTarget((2.0, 1.0)), seconds=8)
    assert operator.loop.status.error < 1e-4


@pytest.mark.parametrize(("gradient", "said"), [(1e-2, "on the way"), (1e-6, "out of reach")])
def test_an_arm_that_moves_is_on_the_way_only_while_the_error_falls(gradient: float, said: str) -> None:
    report: Any = SimpleNamespace(
        finite=True, reached=False, active_clearances=(), relative_gradient=(gradient, gradient)
    )
    assert said in words(report, moving=True, guided=False)


def test_a_target_of_another_dimension_is_refused(operator: Operator) -> None:
    operator.does(MoveTarget((1.0, 2.0, 3.0)))
    assert operator.told == ["move_target: position: given (1.0, 2.0, 3.0); accepted: 2 numbers for this robot"]
    operator.does(HoldTarget((1.0, 2.0, 3.0)))
    assert "velocity" in operator.told[-1]


def test_figures_of_the_status_are_those_of_the_arm(operator: Operator) -> None:
    operator.does(MoveTarget((2.0, 1.0)), seconds=0.3)
    status, frame = operator.loop.status, operator.loop.frame
    q = operator.state.q
    error = ROBOT.position(q) - frame.position
    J = ROBOT.jacobian(q, rows="linear")
    assert np.isclose(status.error, np.linalg.norm(error))
    assert np.isclose(status.V, error @ error / 2)
    assert np.isclose(status.criteria["joint_centering"], q @ q / 2)
    assert np.isclose(status.H, q @ q / 2)
    assert np.isclose(status.manipulability, np.sqrt(np.linalg.det(J @ J.T)))
    assert status.null_space == 2
    centre = np.array([2.0, 2.4])
    joints = [ROBOT.position(q, name) for name in ROBOT.moving_frames]
    assert np.isclose(status.clearance["joints"], min(np.linalg.norm(p - centre) for p in joints) - 0.3)
    ends = [(ROBOT.position(q, a), ROBOT.position(q, b)) for a, b in ROBOT.segments]
    points = [a + s * (b - a) for a, b in ends for s in np.linspace(0, 1, 2001)]
    assert np.isclose(status.clearance["links"], min(np.linalg.norm(p - centre) for p in points) - 0.3, atol=1e-5)


def test_a_jog_moves_the_arm_and_not_the_end_effector(operator: Operator) -> None:
    operator.go(8)
    q, tip = operator.loop.frame.q, operator.tip
    operator.does(Jog(0.5), seconds=0.5)
    assert np.linalg.norm(operator.loop.frame.q - q) > 0.1
    np.testing.assert_allclose(operator.tip, tip, atol=1e-3)
    assert operator.loop.status.words.startswith("along the self-motion")
    operator.does(Jog(0.0), seconds=8)
    np.testing.assert_allclose(operator.loop.frame.q, q, atol=1e-3)  # back to the minimum of the criterion


def test_a_wrong_direction_of_a_jog_is_told(operator: Operator) -> None:
    operator.does(Jog(0.5, "elbow"))
    assert operator.told[0].startswith("jog: direction")
    assert operator.state.jog.rate == 0


def test_a_pose_is_guided_too() -> None:
    operator = Operator(task="pose")
    angle = 0.7
    operator.does(MoveTarget((2.2, 1.0), (np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2))), seconds=6)
    pose = ROBOT.pose(operator.loop.frame.q)
    np.testing.assert_allclose(pose[:2, 3], (2.2, 1.0), atol=1e-4)
    np.testing.assert_allclose(np.arctan2(pose[1, 0], pose[0, 0]), angle, atol=1e-4)


def test_a_step_that_fails_is_told_and_the_loop_goes_on(operator: Operator, monkeypatch: pytest.MonkeyPatch) -> None:
    solver, step = operator.state.solver, operator.state.solver.step

    def raises(*_: object) -> None:
        raise ZeroDivisionError("of a third party")

    monkeypatch.setattr(solver, "step", raises)
    operator.does(MoveTarget((2.0, 1.0)), seconds=1)
    assert operator.told == ["the step failed: ZeroDivisionError: of a third party"]
    np.testing.assert_array_equal(operator.loop.frame.q, START)
    monkeypatch.setattr(solver, "step", lambda q, target, dt: step(q, target, dt)._replace(q=np.full(4, np.nan)))
    operator.go(0.5)
    assert "no finite configuration" in operator.told[-1]
    monkeypatch.setattr(solver, "step", step)
    operator.go(4)
    assert operator.loop.status.error < 1e-4


@pytest.mark.slow
def test_a_queue_that_overflows_is_told(operator: Operator) -> None:
    accepted = [operator.loop.submit(SetLimits(True)) for _ in range(1100)]
    assert sum(accepted) == 1000
    operator.loop.submit(MoveTarget((2.0, 1.0)))
    operator.go(4)
    assert operator.told == ["100 edits were left out: too many at once"]
    assert operator.loop.status.error < 1e-4
