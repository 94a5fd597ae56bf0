"""Strategies as contenders, their labels, and the renamed classes of `jtik.study`."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.study import PreparedContender, Setting, StrategyContender, peers
from jtik.study.strategies import contenders_of, described
from jtik_formulations import Damped, JointCentering, ObstacleAvoidance

TARGET, START = np.array([2.0, 1.0]), np.array([0.3, 0.4, -0.2, 0.5])


@pytest.mark.parametrize(
    ("strategy", "label"),
    [
        ("damped", "damped"),
        (Damped(), "damped"),
        (Damped(damping=0.5), "damped(damping=0.5)"),
        (jtik.strategies["newton"](backtracking=False), "newton(backtracking=False)"),
    ],
)
def test_a_label_has_the_name_and_the_options_that_differ_from_their_defaults(strategy, label):
    assert StrategyContender(strategy).label == label


def test_a_label_has_the_options_of_the_contender():
    assert StrategyContender("hybrid", solver="daqp", compiled=False).label == "hybrid, solver=daqp, not compiled"
    assert StrategyContender("hybrid", compiled=True, label="mine").label == "mine"
    assert described(Damped(damping=0.25)) == "damped(damping=0.25)"


def test_a_contender_solves_like_inverse_kinematics(arm, task):
    setting = Setting(robot=arm, task=task, criteria=JointCentering(), until="stationary", max_iterations=50)
    prepared = StrategyContender("damped").prepare(setting)
    ik = jtik.InverseKinematics(arm, task, criteria=JointCentering(), strategy="damped")
    answer, trace = prepared.traced(TARGET, START)
    expected = ik.solve(TARGET, q0=START, until="stationary", max_iterations=50)
    np.testing.assert_array_equal(answer.q, expected.q)
    np.testing.assert_array_equal(prepared.solve(TARGET, START).q, expected.q)
    assert (answer.status, answer.claimed) == (expected.status.name, expected.converged)
    assert len(trace) == answer.iterations == expected.iterations


def test_parameters_that_are_not_set_return_to_their_first_values(arm, task):
    field = ObstacleAvoidance([jtik.Circle(center=(2.0, 2.0), radius=0.3)])
    prepared = StrategyContender("damped").prepare(Setting(robot=arm, task=task, criteria=field))
    prepared.set({"obstacle_avoidance.centers": np.array([[1.0, 3.0]])})
    assert prepared.ik.parameters["obstacle_avoidance.centers"].tolist() == [[1.0, 3.0]]
    prepared.set({})
    assert prepared.ik.parameters["obstacle_avoidance.centers"].tolist() == [[2.0, 2.0]]


@pytest.mark.parametrize("given", [3, [3], [], {}, None])
def test_contenders_of_another_type_are_refused(given):
    with pytest.raises(jtik.ArgumentError, match="strategies"):
        contenders_of(given)


@pytest.mark.parametrize(("old", "new"), [("Law", StrategyContender), ("Ready", PreparedContender)])
def test_old_names_of_classes_warn(old, new):
    with pytest.warns(DeprecationWarning, match=f"jtik.study.{old} is now jtik.study.{new.__name__}"):
        assert getattr(jtik.study, old) is new


@pytest.mark.parametrize("name", ["Mink", "Optik", "Pink", "Placo", "Pyroki", "Toolbox"])
def test_old_names_of_peers_warn(name):
    with pytest.warns(DeprecationWarning, match=f"jtik.study.peers.{name} is now jtik.study.peers.{name}Peer"):
        assert getattr(peers, name) is getattr(peers, f"{name}Peer")


def test_unknown_names_are_attribute_errors():
    for module in (jtik.study, peers):
        with pytest.raises(AttributeError, match="nothing"):
            module.nothing  # noqa: B018
