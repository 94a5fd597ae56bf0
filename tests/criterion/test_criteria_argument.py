"""What ``criteria=`` accepts: a criterion, a sum, a registered name, a list of these, or None."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import planar
from .shared import at, link_height, solver

Q = np.array([0.3, 0.2, 0.1, 0.4])
ACCEPTED = "a jtik.Criterion, a weighted sum, the name of a registered criterion, a list of these, or None"


@pytest.mark.parametrize(
    ("criteria", "weights"),
    [
        (None, {}),
        ([], {}),
        (JointCentering(), {"joint_centering": 1}),
        (2 * JointCentering(), {"joint_centering": 2}),
        ("joint_centering", {"joint_centering": 1}),
        ([JointCentering(), link_height], {"joint_centering": 1, "link_height": 1}),
        ((0.5 * JointCentering(), -link_height), {"joint_centering": 0.5, "link_height": -1}),
        (
            ["joint_centering", 3 * link_height + link_height],
            {"joint_centering": 1, "link_height": 3, "link_height_2": 1},
        ),
        (["joint_centering", "joint_centering"], {"joint_centering": 1, "joint_centering_2": 1}),
        ([None, [link_height]], {"link_height": 1}),
    ],
)
def test_each_gives_the_same_as_its_sum(criteria, weights):
    ik = solver(planar(4), criteria)
    found = {name.removesuffix(".weight"): float(ik.parameters[name]) for name in ik.parameters if "weight" in name}
    assert found == weights
    first = {"joint_centering": Q @ Q / 2, "link_height": link_height(Q, planar(4))}
    expected = sum(weight * first[name.removesuffix("_2")] for name, weight in weights.items())
    assert at(ik, Q).cost == pytest.approx(expected)


def refused(criteria):
    with pytest.raises(jtik.ArgumentError) as caught:
        solver(planar(4), criteria)
    assert caught.value.argument == "criteria"
    return str(caught.value)


@pytest.mark.parametrize("invalid", [3, 0, {"a": JointCentering()}, [JointCentering(), 3.0], object])
def test_anything_else_is_refused(invalid):
    assert refused(invalid).endswith(f"; accepted: {ACCEPTED}")


def test_a_class_gets_the_hint_to_construct_it():
    for criteria in (JointCentering, ["joint_centering", JointCentering]):
        assert refused(criteria) == (
            f"criteria: given the class JointCentering; accepted: an object of it, JointCentering(); or {ACCEPTED}"
        )
    assert "an object of it, ObstacleAvoidance(obstacles=...); or" in refused(ObstacleAvoidance)


def test_a_function_gets_the_hint_to_decorate_it():
    def elbow(q, robot):
        return q[0] ** 2

    assert refused([elbow]) == (
        f"criteria: given the function elbow; accepted: the function with the decorator @jtik.criterion; or {ACCEPTED}"
    )
    solver(planar(4), jtik.criterion(elbow))


def test_a_name_whose_class_needs_arguments_says_which():
    assert refused("obstacle_avoidance") == (
        "criteria: given 'obstacle_avoidance', whose class needs obstacles; accepted: an object: "
        "jtik.criteria['obstacle_avoidance'](obstacles=...), that is ObstacleAvoidance(obstacles=...)"
    )


def test_an_unknown_name_lists_the_names():
    for criteria in ("joint_centring", [JointCentering(), "joint_centring"]):
        with pytest.raises(jtik.UnknownNameError, match="unknown criterion 'joint_centring'; did you mean 'joint_cent"):
            solver(planar(4), criteria)
