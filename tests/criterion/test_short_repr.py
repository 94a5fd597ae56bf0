"""The repr of criteria shows what has an effect."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.criterion.short_repr import call_text, summarize
from jtik_formulations import JointCentering, ObstacleAvoidance

from .shared import link_height

CIRCLE = jtik.Circle((2.0, 2.0), 0.3)


class Elsewhere(jtik.Criterion):
    """A criterion without a repr of its own."""

    def value(self, kinematics, parameters):
        return kinematics.q[0]


@pytest.mark.parametrize(
    ("criterion", "text"),
    [
        (JointCentering(), "JointCentering()"),
        (JointCentering(1), "JointCentering()"),
        (JointCentering(2.0), "JointCentering(stiffness=2.0)"),
        (JointCentering([1, 2, 0.5]), "JointCentering(stiffness=[1.0, 2.0, 0.5])"),
        (JointCentering({"elbow": 2}), "JointCentering(stiffness={'elbow': 2.0})"),
        (JointCentering(preferred=np.arange(30)), "JointCentering(preferred=[0.0, ..., 29.0] of shape (30,))"),
        (JointCentering(preferred={"elbow": 0.2}), "JointCentering(preferred={'elbow': 0.2})"),
        (JointCentering(name="posture"), "JointCentering(name='posture')"),
        (ObstacleAvoidance(CIRCLE), "ObstacleAvoidance(1 obstacle)"),
        (ObstacleAvoidance([CIRCLE] * 3, gain=0.2), "ObstacleAvoidance(3 obstacles, gain=0.2)"),
        (
            ObstacleAvoidance([CIRCLE] * 2, bodies="both", floor=0.1, name="walls"),
            "ObstacleAvoidance(2 obstacles, floor=0.1, bodies='both', name='walls')",
        ),
        (link_height, "link_height(height=0.5)"),
        (link_height(height=[0.1, 0.2]), "link_height(height=[0.1, 0.2])"),
        (Elsewhere(), "Elsewhere(name='elsewhere')"),
        (0.5 * JointCentering() + link_height, "0.5 * JointCentering() + link_height(height=0.5)"),
        (-JointCentering() - 0.3 * Elsewhere(), "-JointCentering() - 0.3 * Elsewhere(name='elsewhere')"),
        (-2 * JointCentering(), "-2.0 * JointCentering()"),
        (0 * JointCentering(), "0.0 * JointCentering()"),
        (jtik.CriterionSum(()), "CriterionSum(())"),
    ],
)
def test_it_shows_what_differs_from_the_defaults(criterion, text):
    assert repr(criterion) == text


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1, "1"),
        (np.float64(0.5), "0.5"),
        ("links", "'links'"),
        ([1.0, 2.0], "[1.0, 2.0]"),
        (np.arange(7), "[0, ..., 6] of shape (7,)"),
        (np.eye(2), "[1.0, ..., 1.0] of shape (2, 2)"),
        ([], "[]"),
        (np.zeros((0, 2)), "[] of shape (0, 2)"),
        ({"a": [1, 2]}, "{'a': [1, 2]}"),
    ],
)
def test_values_in_short(value, text):
    assert summarize(value) == text


def test_a_call_as_text():
    assert call_text("Make", "two", name="x", of=np.ones(2)) == "Make(two, name='x', of=[1.0, 1.0])"
