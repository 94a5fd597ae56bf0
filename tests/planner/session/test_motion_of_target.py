"""The target: it moves straight, at most at its speed, and its orientation turns about one axis."""

from __future__ import annotations

import numpy as np
import pytest

from jtik.planner.edits.messages import HoldTarget, MoveTarget
from jtik.planner.session import rotations
from jtik.planner.session.target import GuidedTarget

DT = 0.1


def target(**options) -> GuidedTarget:
    values = {"speed": 2.0, "rotation_speed": 0.5, "turns": True} | options
    return GuidedTarget(np.zeros(3), rotations.IDENTITY, **values)


def about_z(angle: float) -> np.ndarray:
    return np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)])


def test_it_moves_straight_at_its_speed_and_arrives() -> None:
    moved = target()
    moved.move(MoveTarget((0.3, 0.0, 0.4)))
    way = [moved.position]
    while moved.advance(DT):
        way.append(moved.position)
    assert len(way) == 4  # 0.5 m at 0.2 m a period
    np.testing.assert_allclose(np.linalg.norm(np.diff(way, axis=0), axis=1), [0.2, 0.2, 0.1], rtol=1e-12)
    np.testing.assert_array_equal(moved.position, (0.3, 0.0, 0.4))
    assert not moved.moving


def test_it_turns_about_one_axis_at_its_angular_speed() -> None:
    turned = target()
    turned.move(MoveTarget((0.0, 0.0, 0.0), tuple(about_z(-0.12))))
    angles = []
    while turned.advance(DT):
        angles.append(2 * np.arctan2(turned.orientation[3], turned.orientation[0]))
    np.testing.assert_allclose(angles, [-0.05, -0.1, -0.12], rtol=1e-9)


def test_a_velocity_is_held_within_the_speed_until_it_is_released() -> None:
    held = target()
    held.hold(HoldTarget((0.0, 10.0, 0.0), (0.0, 0.0, 10.0)))
    for _ in range(3):
        assert held.advance(DT)
    np.testing.assert_allclose(held.position, (0.0, 0.6, 0.0))
    np.testing.assert_allclose(held.orientation, about_z(0.15), atol=1e-12)
    held.hold(HoldTarget((0.0, 0.0, 0.0)))
    assert not held.advance(DT)
    slow = target()
    slow.hold(HoldTarget((0.0, 0.5, 0.0)))
    slow.advance(DT)
    np.testing.assert_allclose(slow.position, (0.0, 0.05, 0.0))


def test_the_latest_command_counts() -> None:
    moved = target()
    moved.hold(HoldTarget((1.0, 0.0, 0.0)))
    moved.move(MoveTarget((0.0, 0.1, 0.0)))
    moved.advance(DT)
    np.testing.assert_array_equal(moved.position, (0.0, 0.1, 0.0))
    moved.move(MoveTarget((5.0, 0.0, 0.0)))
    moved.hold(HoldTarget((0.0, 0.0, 0.0)))
    assert not moved.advance(DT)


def test_an_orientation_that_does_not_count_stays() -> None:
    moved = target(turns=False)
    moved.move(MoveTarget((0.0, 0.0, 0.0), tuple(about_z(1.0))))
    moved.hold(HoldTarget((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
    assert not moved.advance(DT)


@pytest.mark.parametrize("seed", range(20))
def test_quaternions_of_matrices_are_those_of_the_rotation(seed: int) -> None:
    generator = np.random.default_rng(seed)
    given = generator.standard_normal((7, 4))
    given[0] = (0.0, *np.eye(3)[seed % 3])  # half turns about an axis
    given /= np.linalg.norm(given, axis=1, keepdims=True)
    given[given[:, 0] < 0] *= -1
    matrices = np.stack([rotations.matrix(each) for each in given])
    np.testing.assert_allclose(
        matrices @ matrices.transpose(0, 2, 1), np.broadcast_to(np.eye(3), (7, 3, 3)), atol=1e-12
    )
    found = rotations.quaternions(matrices)
    np.testing.assert_allclose(np.abs((found * given).sum(axis=1)), 1, atol=1e-12)


@pytest.mark.parametrize("seed", range(10))
def test_slerp_keeps_its_axis_and_its_pace(seed: int) -> None:
    generator = np.random.default_rng(seed)
    start, end = (each / np.linalg.norm(each) for each in generator.standard_normal((2, 4)))
    whole = rotations.angle(start, end)
    middle = rotations.slerp(start, end, 0.3)
    assert whole <= np.pi + 1e-12
    np.testing.assert_allclose(rotations.angle(start, middle), 0.3 * whole, atol=1e-9)
    np.testing.assert_allclose(rotations.angle(middle, end), 0.7 * whole, atol=1e-9)
    trace = np.trace(rotations.matrix(start).T @ rotations.matrix(end))
    np.testing.assert_allclose(np.cos(whole), (trace - 1) / 2, atol=1e-9)
