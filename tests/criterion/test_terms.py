"""The criteria of one solver: one mapping of weights and parameters, and weighted values as expressions."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.criterion import CriterionTerms
from jtik_formulations import JointCentering

from ..conftest import planar
from .shared import link_height

Q = np.array([0.4, -0.2, 0.7, 0.1])


def column(terms, **changed):
    """The parameters as a column of numbers, some of them changed."""
    for name, value in changed.items():
        terms.parameters[name.replace("__", ".")] = value
    return casadi.SX(terms.parameters.memory)


def values(terms, **changed):
    robot = terms.robot
    return [float(casadi.DM(H)) for H in terms.values(robot.at(casadi.SX(Q)), column(terms, **changed))]


class Measure:
    """Something with parameters that is no criterion."""

    name = "measure"

    def parameters(self, robot):
        return {"size": 2.0, "matrix": np.arange(6.0).reshape(2, 3)}


def test_names_weights_and_parameters_are_in_one_mapping():
    terms = CriterionTerms.of(planar(4), 2.0 * JointCentering(3.0) + 0.5 * link_height + JointCentering(), [Measure()])
    assert [(name, weight) for name, weight, _ in terms.named] == [
        ("joint_centering", 2.0),
        ("link_height", 0.5),
        ("joint_centering_2", 1.0),
    ]
    assert terms.parameters["joint_centering.weight"] == 2.0
    assert terms.parameters["link_height.height"] == 0.5
    assert terms.parameters["joint_centering_2.stiffness"].tolist() == [1.0] * 4
    assert terms.parameters["measure.size"] == 2.0


def test_each_value_is_the_weight_times_the_criterion():
    terms = CriterionTerms.of(planar(4), 2.0 * JointCentering(3.0) + 0.5 * link_height)
    height = np.sin(np.cumsum(Q))[:2].sum()
    assert values(terms) == pytest.approx([2.0 * 3.0 * Q @ Q / 2, 0.5 * (height - 0.5) ** 2])
    changed = values(terms, joint_centering__weight=5.0, link_height__height=0.1)
    assert changed == pytest.approx([5.0 * 3.0 * Q @ Q / 2, 0.5 * (height - 0.1) ** 2])


def test_others_read_their_parameters_in_their_own_shapes():
    terms = CriterionTerms.of(planar(4), JointCentering(), [Measure()])
    own = terms.own(Measure(), column(terms, measure__size=7.0))
    assert float(casadi.DM(own["size"])) == 7.0
    assert np.array(casadi.DM(own["matrix"])).tolist() == [[0, 1, 2], [3, 4, 5]]


def test_a_parameter_under_the_name_of_a_criterions_is_refused():
    class Taken(Measure):
        name = "joint_centering"

        def parameters(self, robot):
            return {"stiffness": 1.0}

    with pytest.raises(jtik.ArgumentError, match="name: given joint_centering; accepted: a name that no criterion has"):
        CriterionTerms.of(planar(4), JointCentering(), [Taken()])


def test_without_criteria_there_are_no_values():
    terms = CriterionTerms.of(planar(4), None)
    assert (terms.named, values(terms)) == ((), [])
