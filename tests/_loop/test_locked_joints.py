"""Configurations of the full robot and of the solver's: one is part of the other."""

from __future__ import annotations

import numpy as np
import pytest

import jtik

from ..conftest import shared_solver

PANDA = jtik.Robot.builtin("panda")
HOME = PANDA.keyframes["home"]


@pytest.fixture(scope="module")
def ik():
    return shared_solver(
        PANDA, jtik.FrameTask("tip", "position"), joints=[f"panda_joint{i}" for i in (1, 2, 4)], at=HOME
    )


def test_a_full_configuration_has_the_locked_joints_where_they_are_locked(ik):
    full = ik.full_configuration([0.1, 0.2, -1.0])
    expected = HOME.copy()
    expected[[0, 1, 3]] = 0.1, 0.2, -1.0
    assert full.tolist() == expected.tolist()
    assert PANDA.position(full) == pytest.approx(ik.robot.position([0.1, 0.2, -1.0]), abs=1e-12)


def test_reduced_is_its_inverse(ik, rng):
    q = ik.robot.random_configuration(rng)
    assert ik.reduced(ik.full_configuration(q)).tolist() == q.tolist()
    assert ik.reduced(HOME).tolist() == HOME[[0, 1, 3]].tolist()


def test_without_locked_joints_both_are_copies():
    ik = shared_solver(PANDA, jtik.FrameTask("tip"))
    for copied in (ik.reduced(HOME), ik.full_configuration(HOME)):
        assert np.array_equal(copied, HOME)
        assert copied is not HOME


def test_wrong_input(ik):
    with pytest.raises(jtik.ArgumentError, match=r"q: given shape \(2,\); accepted: finite numbers of shape \(7,\)"):
        ik.reduced([0.1, 0.2])
    with pytest.raises(jtik.ArgumentError, match=r"q: given nan"):
        ik.full_configuration([0.1, np.nan, 0.2])
    with pytest.raises(jtik.ArgumentError, match="at: given shape"):
        jtik.InverseKinematics(PANDA, jtik.FrameTask("tip"), at=[0.0])


def test_whole_is_the_old_name(ik):
    with pytest.warns(DeprecationWarning, match=r"InverseKinematics\.whole is deprecated: use full_configuration"):
        old = ik.whole([0.1, 0.2, -1.0])
    assert old.tolist() == ik.full_configuration([0.1, 0.2, -1.0]).tolist()
