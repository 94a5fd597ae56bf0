"""Restart configurations: within the limits, about the start where there are none, the same for the same seed."""

from __future__ import annotations

import numpy as np
import pytest

from jtik._loop.restarts import RestartConfigurations
from jtik.robot import JointType

from ..conftest import dh_arm, floating_arm

ARM = dh_arm(7, 3, limit=1.5)


def test_lie_within_the_limits_and_do_not_repeat():
    drawn = RestartConfigurations(ARM).table(0, 50, np.zeros(7))
    assert (ARM.lower <= drawn).all()
    assert (drawn <= ARM.upper).all()
    assert len(np.unique(drawn[:, 0])) == 50
    assert (np.ptp(drawn, axis=0) > 0.8 * (ARM.upper - ARM.lower)).all()


def test_more_of_them_begin_with_the_same_and_another_seed_with_others():
    restarts = RestartConfigurations(ARM)
    few = restarts.table(3, 5, np.zeros(7)).copy()
    assert np.array_equal(restarts.table(3, 20, np.zeros(7))[:5], few)
    assert np.array_equal(RestartConfigurations(ARM).table(3, 5, np.zeros(7)), few)
    assert not np.array_equal(restarts.table(4, 5, np.zeros(7)), few)


def test_a_position_without_limits_is_drawn_about_where_the_search_began():
    robot = floating_arm()
    about = robot.neutral.copy()
    where = next(robot.q_slice(j.name) for j in robot.independent_joints if j.type is JointType.FREE)
    about[where.start : where.start + 3] = 100.0, -50.0, 7.0
    drawn = RestartConfigurations(robot).table(1, 20, about)
    offsets = drawn[:, where.start : where.start + 3] - (100.0, -50.0, 7.0)
    assert np.abs(offsets).max() <= 1.0
    turns = drawn[:, where.start + 3 : where.stop]
    assert np.linalg.norm(turns, axis=1) == pytest.approx(1.0)


def test_only_then_do_they_depend_on_the_start():
    assert not RestartConfigurations(ARM).depend_on_start
    assert RestartConfigurations(floating_arm()).depend_on_start
