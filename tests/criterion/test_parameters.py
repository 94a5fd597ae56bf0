"""Live parameters: names, values, and what is refused."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import DIFFERENCES, differences, planar, shared_solver
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

    def test_a_name_that_is_set_as_an_attribute_is_refused(self):
        with pytest.raises(AttributeError, match="weight"):
            self.solver().parameters.weight = 7

    def test_a_value_read_is_read_only(self):
        parameters = self.solver().parameters
        for name, index in (("obstacle_avoidance.radii", 0), ("obstacle_avoidance.centers", (0, 1))):
            with pytest.raises(ValueError, match="assignment destination is read-only"):
                parameters[name][index] = 9.0
        assert parameters["obstacle_avoidance.radii"][0] == 0.6
        assert "radii = parameters[" in shared_solver(planar(2), jtik.FrameTask()).parameters.__doc__

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


class PerJoint(jtik.Criterion):
    """Weighted sum of the squared entries of q."""

    joint_parameters = ("scale",)
    size = None

    def parameters(self, robot):
        return {"scale": np.ones(self.size or robot.nq)}

    def value(self, kinematics, parameters):
        return (parameters["scale"] * kinematics.q**2).T @ np.ones((kinematics.robot.nq, 1))


class TestParametersOfTheJoints:
    """What the constructor takes is taken live: the task moves 4 of 6 joints."""

    def solver(self, criterion=None):
        task = jtik.FrameTask("link4", kind="position")
        return shared_solver(planar(6), task, criteria=criterion or JointCentering())

    def test_numbers_of_the_full_robot(self):
        ik = self.solver()
        for name in ("joint_centering.preferred", "joint_centering.stiffness"):
            ik.parameters[name] = [1, 2, 3, 4, 5, 6]
            assert ik.parameters[name].tolist() == [1.0, 2.0, 3.0, 4.0]

    def test_a_dict_leaves_the_other_joints_as_they_are(self):
        ik = self.solver()
        ik.parameters["joint_centering.preferred"] = {"joint2": 0.5}
        ik.parameters["joint_centering.preferred"] = {"joint3": 0.7, "joint6": 9.0}
        assert ik.parameters["joint_centering.preferred"].tolist() == [0.0, 0.5, 0.7, 0.0]
        ik.parameters["joint_centering.stiffness"] = {"joint1": 3.0}
        assert ik.parameters["joint_centering.stiffness"].tolist() == [3.0, 1.0, 1.0, 1.0]

    def test_it_acts_as_if_the_criterion_was_built_with_it(self):
        changed = self.solver()
        changed.parameters["joint_centering.preferred"] = {"joint2": 0.5}
        built = self.solver(JointCentering(preferred={"joint2": 0.5}))
        q0 = [0.3, 0.4, -0.2, 0.5]
        assert changed.solve([2.0, 1.0], q0=q0).q.tolist() == built.solve([2.0, 1.0], q0=q0).q.tolist()

    def test_those_of_one_s_own_criterion(self):
        ik = self.solver(PerJoint())
        ik.parameters["per_joint.scale"] = {"joint4": 3.0}
        assert ik.parameters["per_joint.scale"].tolist() == [1.0, 1.0, 1.0, 3.0]
        arm = planar(3)
        assert PerJoint()([1.0, 1.0, 2.0], arm, scale={"joint3": 2.0}) == 1 + 1 + 2 * 4

    def test_a_wrong_length_names_both_lengths_and_the_robot(self):
        parameters = self.solver().parameters
        text = (
            r"^joint_centering.preferred: given shape \(9,\); accepted: 4 numbers for ik.robot, "
            "or 6 for the full robot, one number for all of them, or a dict by joint name$"
        )
        with pytest.raises(jtik.ArgumentError, match=text):
            parameters["joint_centering.preferred"] = np.zeros(9)
        assert parameters["joint_centering.preferred"].tolist() == [0.0] * 4

    def test_an_unknown_joint_changes_nothing(self):
        parameters = self.solver().parameters
        with pytest.raises(jtik.UnknownNameError, match="unknown joint in joint_centering.preferred 'elbow'"):
            parameters["joint_centering.preferred"] = {"joint1": 1.0, "elbow": 1.0}
        assert parameters["joint_centering.preferred"].tolist() == [0.0] * 4

    def test_a_first_value_of_another_shape_is_refused_when_the_solver_is_built(self):
        wrong = PerJoint()
        wrong.size = 9
        text = r"^per_joint.scale: given shape \(9,\); accepted: shape \(4,\), one number for each entry of q"
        with pytest.raises(jtik.ArgumentError, match=text):
            self.solver(wrong)

    @pytest.mark.parametrize("names", ["scale", None, 5, ("nope",), (None,), ([],)])
    def test_names_that_are_none_of_its_parameters_are_refused(self, names):
        wrong = PerJoint()
        wrong.joint_parameters = names
        with pytest.raises(jtik.CriterionError, match=r"'per_joint': joint_parameters is .*names in \['scale'\]"):
            self.solver(wrong)
        with pytest.raises(jtik.CriterionError, match="joint_parameters is"):
            wrong([0.0, 0.0, 0.0], planar(3))


class TestFirstValues:
    @pytest.mark.parametrize("returned", [None, "x", 5, [("scale", 1.0)]])
    def test_what_is_no_mapping(self, returned):
        class Wrong(PerJoint):
            def parameters(self, robot):
                return returned

        with pytest.raises(jtik.CriterionError, match="'wrong': parameters returned .*; expected a dict"):
            solver(planar(3), Wrong())

    def test_the_name_of_the_weight_is_taken(self):
        class Weighted(jtik.Criterion):
            def parameters(self, robot):
                return {"weight": 5.0}

            def value(self, kinematics, parameters):
                return parameters["weight"] * kinematics.q[0]

        with pytest.raises(jtik.ArgumentError, match="^criterion 'weighted': given Weighted.parameters with 'weight'"):
            solver(planar(3), 3.0 * Weighted())

    def test_an_expression_is_no_value(self):
        parameters = solver(planar(3), JointCentering()).parameters
        for value in (casadi.MX.sym("x"), casadi.SX.sym("x", 3)):
            with pytest.raises(jtik.ArgumentError, match="^joint_centering.weight: given"):
                parameters["joint_centering.weight"] = value
