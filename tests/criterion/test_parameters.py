"""Live parameters: names, values, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import DIFFERENCES, differences, planar
from .shared import at, solver


class TestParameters:
    def solver(self):
        field = [jtik.Circle((4.0, 2.0), 0.6), jtik.Circle((6.5, -1.0), 0.8)]
        return solver(planar(5), 1.5 * JointCentering() + 0.3 * ObstacleAvoidance(field))

    def test_first_values_are_those_of_the_criteria(self):
        parameters = self.solver().parameters
        assert parameters["joint_centering.weight"] == 1.5
        assert parameters["obstacle_avoidance.centers"].tolist() == [[4.0, 2.0], [6.5, -1.0]]
        assert parameters["obstacle_avoidance.radii"].tolist() == [0.6, 0.8]
        assert set(parameters) == {
            "joint_centering.weight",
            "joint_centering.stiffness",
            "joint_centering.preferred",
            "obstacle_avoidance.weight",
            "obstacle_avoidance.gain",
            "obstacle_avoidance.centers",
            "obstacle_avoidance.radii",
        }
        assert len(parameters) == 7
        assert "obstacle_avoidance.radii = [0.6, 0.8]" in repr(parameters)

    @pytest.mark.parametrize(
        ("name", "value"),
        [
            ("joint_centering.weight", 0.25),
            ("obstacle_avoidance.weight", 2.0),
            ("obstacle_avoidance.gain", 3.0),
            ("obstacle_avoidance.centers", [[1.0, 2.0], [3.0, -4.0]]),
            ("obstacle_avoidance.radii", [0.1, 0.2]),
            ("joint_centering.preferred", [0.1, 0.2, 0.3, 0.4, 0.5]),
            ("joint_centering.stiffness", [1.0, 2.0, 3.0, 4.0, 5.0]),
        ],
    )
    def test_each_reads_back_and_changes_the_criterion_at_once(self, name, value):
        ik, q = self.solver(), [0.3, 0.4, -0.2, 0.5, 0.1]
        before = at(ik, q)
        ik.parameters[name] = value
        assert ik.parameters[name].tolist() == value
        after = at(ik, q)
        assert after.cost != before.cost
        numeric = differences(lambda p: at(ik, p).cost, ik.robot, q)[0]
        assert after.gradient == pytest.approx(numeric, abs=DIFFERENCES)

    def test_a_value_read_is_read_only(self):
        parameters = self.solver().parameters
        for name, index in (("obstacle_avoidance.radii", 0), ("obstacle_avoidance.centers", (0, 1))):
            with pytest.raises(ValueError, match="assignment destination is read-only"):
                parameters[name][index] = 9.0
        assert parameters["obstacle_avoidance.radii"][0] == 0.6
        assert "radii = parameters[" in jtik.InverseKinematics(planar(2), jtik.FrameTask()).parameters.__doc__

    def test_a_value_read_keeps_its_numbers_when_the_parameter_changes(self):
        parameters = self.solver().parameters
        before = parameters["obstacle_avoidance.radii"]
        parameters["obstacle_avoidance.radii"] = 0.25
        assert before.tolist() == [0.6, 0.8]

    @pytest.mark.parametrize("two", [2, 2.0, np.float64(2.0), np.array(2.0)])
    @pytest.mark.parametrize(
        ("name", "filled"),
        [
            ("joint_centering.weight", 2.0),
            ("joint_centering.stiffness", [2.0] * 5),
            ("joint_centering.preferred", [2.0] * 5),
            ("obstacle_avoidance.radii", [2.0, 2.0]),
            ("obstacle_avoidance.centers", [[2.0, 2.0], [2.0, 2.0]]),
        ],
    )
    def test_a_scalar_fills_every_shape(self, name, filled, two):
        parameters = self.solver().parameters
        parameters[name] = two
        assert parameters[name].tolist() == filled

    def test_a_scalar_acts_as_if_the_criterion_was_built_with_it(self):
        robot, q = planar(5), [0.3, 0.4, -0.2, 0.5, 0.1]
        ik = solver(robot, JointCentering())
        ik.parameters["joint_centering.stiffness"] = 2.0
        assert at(ik, q).cost == at(solver(robot, JointCentering(2.0)), q).cost

    def test_a_value_written_is_copied(self):
        parameters, radii = self.solver().parameters, np.array([0.1, 0.2])
        parameters["obstacle_avoidance.radii"] = radii
        radii[0] = 9.0
        assert parameters["obstacle_avoidance.radii"][0] == 0.1

    def test_an_unknown_name_lists_the_names(self):
        parameters = self.solver().parameters
        with pytest.raises(jtik.UnknownNameError, match=r"did you mean 'obstacle_avoidance\.radii'"):
            parameters["obstacle_avoidance.radi"]
        with pytest.raises(jtik.UnknownNameError, match="known: joint_centering.weight"):
            parameters["weight"] = 1.0

    def test_asking_whether_a_name_is_there_raises_nothing(self):
        parameters = self.solver().parameters
        assert "obstacle_avoidance.gain" in parameters
        assert "obstacle_avoidance.loss" not in parameters
        assert parameters.get("obstacle_avoidance.loss") is None

    @pytest.mark.parametrize(
        ("name", "value", "shape"),
        [
            ("obstacle_avoidance.radii", np.nan, r"\(2,\), or one finite number for all of them"),
            ("obstacle_avoidance.radii", "0.1", r"\(2,\)"),
            ("obstacle_avoidance.radii", ["0.1", "0.2"], r"\(2,\)"),
            ("obstacle_avoidance.radii", np.array(1j), r"\(2,\)"),
            ("obstacle_avoidance.radii", [0.1], r"\(2,\)"),
            ("obstacle_avoidance.radii", [0.1, np.nan], r"\(2,\)"),
            ("obstacle_avoidance.centers", [1.0, 2.0, 3.0, 4.0], r"\(2, 2\)"),
            ("obstacle_avoidance.centers", np.full((2, 2), np.inf), r"\(2, 2\)"),
            ("obstacle_avoidance.centers", [[1.0], [2.0, 3.0]], r"\(2, 2\)"),
            ("joint_centering.weight", [1.0], r"\(\)"),
            ("joint_centering.weight", np.nan, r"one finite number, shape \(\)"),
            ("joint_centering.weight", -np.inf, r"\(\)"),
            ("joint_centering.weight", "heavy", r"\(\)"),
            ("joint_centering.weight", None, r"\(\)"),
        ],
    )
    def test_another_shape_or_not_finite_is_refused_and_changes_nothing(self, name, value, shape):
        parameters = self.solver().parameters
        before = parameters[name]
        with pytest.raises(jtik.ArgumentError, match=f"(?s)^{name}: .*{shape}") as caught:
            parameters[name] = value
        assert caught.value.argument == name
        assert parameters[name].tolist() == before.tolist()

    def test_none_can_be_removed(self):
        with pytest.raises(TypeError):
            del self.solver().parameters["joint_centering.weight"]

    def test_no_criterion_has_no_parameters(self):
        parameters = solver(planar(2), None).parameters
        assert dict(parameters) == {}
        assert repr(parameters) == "no parameters"

    def test_update_sets_several(self):
        parameters = self.solver().parameters
        parameters.update({"joint_centering.weight": 2.0, "obstacle_avoidance.gain": 0.1})
        assert (parameters["joint_centering.weight"], parameters["obstacle_avoidance.gain"]) == (2.0, 0.1)
