"""Restart configurations: within the limits, about the start where there are none, the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik._loop.search.jump import Jump
from jtik._loop.search.restarts import BLOCK, RestartConfigurations
from jtik.robot import Joint, JointType, Robot

from ...conftest import dh_arm, floating_arm, shared_solver

ARM = dh_arm(7, 3, limit=1.5)


def first(restarts, seed, count, start):
    """The first restarts, as a search asks for them."""
    rows = []
    for number in range(1, count + 1):
        drawn, first, last = restarts.block(seed, number, start)
        assert first <= number <= last
        rows.append(drawn[number - first].copy())
    return np.array(rows)


def test_lie_within_the_limits_and_do_not_repeat():
    drawn = first(RestartConfigurations(ARM), 0, 50, np.zeros(7))
    assert (ARM.lower <= drawn).all()
    assert (drawn <= ARM.upper).all()
    assert len(np.unique(drawn[:, 0])) == 50
    assert (np.ptp(drawn, axis=0) > 0.8 * (ARM.upper - ARM.lower)).all()


def test_the_same_seed_gives_the_same_whatever_was_drawn_before():
    restarts = RestartConfigurations(ARM)
    many = first(restarts, 3, 3 * BLOCK, np.zeros(7))
    other = first(restarts, 4, 5, np.zeros(7))
    assert not np.array_equal(many[:5], other)
    assert np.array_equal(first(restarts, 3, 5, np.zeros(7)), many[:5])
    late, start, _ = restarts.block(3, 2 * BLOCK + 4, np.zeros(7))
    assert np.array_equal(late[2 * BLOCK + 4 - start], many[2 * BLOCK + 3])
    again, start, _ = restarts.block(3, BLOCK + 1, np.zeros(7))
    assert np.array_equal(again, many[BLOCK : 2 * BLOCK])


def test_an_interrupted_draw_changes_none_that_follow(monkeypatch):
    restarts, configuration, drawn = RestartConfigurations(ARM), Robot.random_configuration, []

    def interrupted(*given):
        drawn.append(0)
        if len(drawn) == BLOCK + 5:
            raise KeyboardInterrupt
        return configuration(*given)

    monkeypatch.setattr(Robot, "random_configuration", interrupted)
    restarts.block(3, 1, np.zeros(7))
    with pytest.raises(KeyboardInterrupt):
        restarts.block(3, BLOCK + 1, np.zeros(7))
    found = first(restarts, 3, 3 * BLOCK, np.zeros(7))
    assert np.array_equal(found, first(RestartConfigurations(ARM), 3, 3 * BLOCK, np.zeros(7)))


def test_are_drawn_when_they_are_needed(monkeypatch):
    drawn = []
    configuration = Robot.random_configuration
    monkeypatch.setattr(Robot, "random_configuration", lambda *given: drawn.append(0) or configuration(*given))
    first(RestartConfigurations(ARM), 0, 3, np.zeros(7))
    assert len(drawn) == BLOCK


def test_a_position_without_limits_is_drawn_about_where_the_search_began():
    robot = floating_arm()
    about = robot.neutral.copy()
    where = next(robot.q_slice(j.name) for j in robot.independent_joints if j.type is JointType.FREE)
    about[where.start : where.start + 3] = 100.0, -50.0, 7.0
    drawn = first(RestartConfigurations(robot), 1, 20, about)
    offsets = drawn[:, where.start : where.start + 3] - (100.0, -50.0, 7.0)
    assert np.abs(offsets).max() <= 1.0
    turns = drawn[:, where.start + 3 : where.stop]
    assert np.linalg.norm(turns, axis=1) == pytest.approx(1.0)


@pytest.mark.parametrize(("lower", "upper", "start"), [(-np.inf, 5.0, 4.9), (2.0, np.inf, 2.0), (2.0, np.inf, 30.0)])
def test_a_prismatic_joint_with_one_limit_is_drawn_about_the_start_and_within_it(lower, upper, start):
    rail = Joint("rail", JointType.PRISMATIC, "base", "cart", axis=(1, 0, 0), lower=lower, upper=upper)
    drawn = first(RestartConfigurations(Robot([rail])), 0, 200, np.array([start]))
    assert (lower <= drawn).all()
    assert (drawn <= upper).all()
    assert np.abs(drawn - start).max() <= 1.0 + 1e-12
    assert np.abs(drawn - start).max() > 0.9


def test_within_other_limits():
    low, high = np.full(7, 0.2), np.full(7, 0.3)
    jump = Jump(ARM, np.full(7, 0.25), 0.05, ARM.lower, ARM.upper)
    drawn, _, _ = RestartConfigurations(ARM).block(0, 1, np.zeros(7), jump)
    assert (low <= drawn).all()
    assert (drawn <= high).all()
    assert len(np.unique(drawn)) == drawn.size


def test_only_then_do_they_depend_on_the_start():
    assert not RestartConfigurations(ARM).depend_on_start
    assert RestartConfigurations(floating_arm()).depend_on_start


@pytest.mark.parametrize("restarts", [0, 1, 4])
def test_a_solve_has_one_attempt_more_than_restarts(restarts):
    """The caller's start, and each restart; the best attempt and the first one are then continued, as attempts."""
    ik = shared_solver(jtik.Robot.planar(3, lower=-2.0, upper=2.0), jtik.FrameTask(), strategy="damped")
    trace = ik.solve((5.0, 1.0), q0=[0.1, 0.2, 0.3], restarts=restarts, seed=3, trace=True).trace
    starts = np.array([trace.q[:-1][trace.attempt == attempt][0] for attempt in np.unique(trace.attempt)])
    assert np.count_nonzero((starts == [0.1, 0.2, 0.3]).all(axis=1)) == 1
    continued = len(starts) - (restarts + 1)
    assert continued == 0 if restarts == 0 else 1 <= continued <= 2
