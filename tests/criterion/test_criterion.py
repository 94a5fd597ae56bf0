"""Criteria: the decorator, sums and weights, live parameters, and messages that show the way."""

from __future__ import annotations

import math
import sys

import casadi
import numpy as np
import pytest

import jtik
from jtik_formulations import JointCentering, ObstacleAvoidance

from ..conftest import DIFFERENCES, EXACT, dh_arm, differences, look, planar

STRATEGIES = sorted(jtik.strategies)


@jtik.criterion
def tip_height(q, robot, *, height=0.5):
    """The tip's y, or that of the third joint, at a height [m]."""
    return (robot.position(q, "link3")[1] - height) ** 2


def solver(robot, criteria, strategy="hybrid", **options):
    return jtik.InverseKinematics(robot, jtik.FrameTask(), criteria=criteria, strategy=strategy, **options)


def at(ik, q):
    return look(ik, q, ik.robot.position(q))


class TestDecorator:
    def test_a_three_line_function_is_a_criterion(self, rng):
        robot = planar(5)
        ik = solver(robot, tip_height)
        q = robot.random_configuration(rng)
        expected = (robot.position(q, "link3")[1] - 0.5) ** 2
        found = at(ik, q)
        assert found.cost == pytest.approx(expected, rel=EXACT)
        assert found.gradient == pytest.approx(differences(lambda p: at(ik, p).cost, robot, q)[0], abs=DIFFERENCES)
        assert isinstance(tip_height, jtik.Criterion)
        assert tip_height.name == "tip_height"
        assert tip_height.__doc__.startswith("The tip's y")

    @pytest.mark.parametrize("strategy", STRATEGIES)
    def test_it_is_minimised_by_every_strategy(self, strategy):
        robot = planar(5)
        q0 = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
        target = np.array([2.8, 1.6])
        without = jtik.InverseKinematics(robot, jtik.FrameTask(), strategy=strategy).solve(
            target, q0=q0, max_iterations=5000, position_tolerance=1e-4
        )
        solution = solver(robot, tip_height, strategy).solve(
            target, q0=q0, max_iterations=5000, position_tolerance=1e-4, optimality_tolerance=1e-3
        )
        assert without.position_error <= 1e-4
        assert solution.position_error <= 1e-4
        assert robot.position(solution.q, "link3")[1] == pytest.approx(0.5, abs=5e-3)
        assert abs(robot.position(without.q, "link3")[1] - 0.5) > 0.02

    def test_numpy_functions_and_operators_can_be_traced(self, rng):
        @jtik.criterion
        def wavy(q, robot):
            return np.sin(q[0]) ** 2 + np.exp(-q[1]) + abs(q[2]) / 2 + casadi.sumsqr(robot.pose(q)[:3, 3])

        robot = dh_arm(4, 1)
        q = robot.random_configuration(rng)
        expected = np.sin(q[0]) ** 2 + np.exp(-q[1]) + abs(q[2]) / 2 + np.sum(robot.pose(q)[:3, 3] ** 2)
        assert look(solver(robot, wavy), q, robot.position(q)).cost == pytest.approx(expected, rel=1e-11)

    def test_a_constant_is_a_criterion_without_a_pull(self):
        @jtik.criterion
        def indifferent(q, robot):
            return 3.0

        found = at(solver(planar(3), indifferent), [0.1, 0.2, 0.3])
        assert found.cost == 3.0
        assert not found.gradient.any()

    def test_called_with_values_it_starts_from_them(self):
        robot, q = planar(4), np.array([0.3, 0.2, 0.1, 0.4])
        higher = tip_height(height=2.0)
        assert at(solver(robot, higher), q).cost == pytest.approx((robot.position(q, "link3")[1] - 2) ** 2)
        assert solver(robot, tip_height).parameters["tip_height.height"] == 0.5
        assert "height=2.0" in repr(higher)
        with pytest.raises(jtik.UnknownNameError, match="width.*known: height"):
            tip_height(width=1.0)

    @pytest.mark.parametrize(
        "wrong",
        [
            lambda q: q,
            lambda q, robot, extra: q,
            lambda q, robot, *, height: q,
            lambda q, robot, *more: q,
            lambda q, robot, **more: q,
            3,
        ],
    )
    def test_another_signature_is_refused(self, wrong):
        with pytest.raises(jtik.ArgumentError, match=r"f\(q, robot"):
            jtik.criterion(wrong)


def count_compilations(monkeypatch):
    """Every call of what makes a casadi function, or binds one, wherever it has been imported."""
    import jtik.symbolic
    import jtik.symbolic.compile

    calls = []
    for original in (jtik.symbolic.function, jtik.symbolic.compile.bind):

        def counted(*arguments, _original=original, **options):
            calls.append(_original.__name__)
            return _original(*arguments, **options)

        for name, module in list(sys.modules.items()):
            if name.split(".")[0] in ("jtik", "jtik_formulations"):
                for attribute, value in list(vars(module).items()):
                    if value is original:
                        monkeypatch.setattr(module, attribute, counted)
    return calls


@pytest.mark.parametrize("strategy", STRATEGIES)
class TestNothingRecompiles:
    Q0 = np.array([0.3, 0.4, -0.2, 0.5, 0.1])
    TARGET = np.array([3.5, 1.5])

    def walk(self, ik):
        """Four steps: the first may be refused."""
        q = self.Q0
        for _ in range(4):
            q = ik.step(q, self.TARGET).q
        return q

    def test_when_a_parameter_changes_between_steps(self, strategy, monkeypatch):
        ik = solver(planar(5), tip_height, strategy)
        first = self.walk(ik)
        calls = count_compilations(monkeypatch)
        ik.parameters["tip_height.height"] = -2.0
        ik.reset()
        second = self.walk(ik)
        assert calls == []
        fresh = solver(planar(5), tip_height(height=-2.0), strategy)
        assert "bind" in calls  # the counter counts
        assert second.tolist() == self.walk(fresh).tolist()
        assert first.tolist() != second.tolist()

    def test_when_a_parameter_a_weight_or_a_target_changes_between_solves(self, strategy, monkeypatch):
        options = {"q0": self.Q0, "max_iterations": 60}
        ik = solver(planar(5), tip_height, strategy)
        first = ik.solve(self.TARGET, **options)
        calls = count_compilations(monkeypatch)
        ik.parameters["tip_height.height"] = -2.0
        second = ik.solve(self.TARGET, **options)
        ik.parameters["tip_height.weight"] = 0.2
        third = ik.solve(self.TARGET + 0.1, **options)
        assert calls == []
        fresh = [
            solver(planar(5), weight * tip_height(height=-2.0), strategy).solve(target, **options)
            for weight, target in ((1.0, self.TARGET), (0.2, self.TARGET + 0.1))
        ]
        assert [second.q.tolist(), third.q.tolist()] == [solution.q.tolist() for solution in fresh]
        assert first.q.tolist() != second.q.tolist()


class TestSums:
    def terms(self):
        return JointCentering(), ObstacleAvoidance(jtik.Point((2.0, 2.0)))

    def test_weights_multiply_from_either_side_and_nest(self, rng):
        robot = planar(4)
        A, B = self.terms()
        q = robot.random_configuration(rng)
        a, b = (at(solver(robot, term), q) for term in (A, B))
        for total, wa, wb in (
            (A + B, 1, 1),
            (2 * A + B * 0.5, 2, 0.5),
            (0.5 * (A + 3 * B), 0.5, 1.5),
            ((A + B) * 2 + 0.0 * A, 2, 2),
            (np.float64(0.3) * A + 2 * (B * np.int64(2)), 0.3, 4),
            (B + (A + B), 1, 2),
        ):
            found = at(solver(robot, total), q)
            assert found.cost == pytest.approx(wa * a.cost + wb * b.cost, rel=EXACT)
            assert found.gradient == pytest.approx(wa * a.gradient + wb * b.gradient, abs=1e-11)
            assert sum(found.criteria.values()) == pytest.approx(found.cost, rel=EXACT)

    def test_names_that_come_again_are_numbered(self):
        A, B = self.terms()
        ik = solver(planar(4), A + B + 2 * A + 3 * A)
        names = ["joint_centering", "obstacle_avoidance", "joint_centering_2", "joint_centering_3"]
        assert [key.split(".")[0] for key in ik.parameters if key.endswith(".weight")] == names
        assert [float(ik.parameters[f"{name}.weight"]) for name in names] == [1, 1, 2, 3]
        assert list(at(ik, [0.1] * 4).criteria) == names

    def test_a_name_that_looks_numbered_does_not_take_anothers_parameters(self):
        """joint_centering twice and one that is called joint_centering_2 are three criteria."""
        A = JointCentering(1.0)
        C = JointCentering(5.0, name="joint_centering_2")
        ik = solver(planar(2), A + A + C)
        q = np.array([0.3, -0.2])
        assert len([key for key in ik.parameters if key.endswith(".weight")]) == 3
        assert at(ik, q).cost == pytest.approx((1 + 1 + 5) * q @ q / 2)
        assert len(at(ik, q).criteria) == 3

    def test_equally_named_criteria_keep_parameters_of_their_own(self, rng):
        robot = planar(3)
        ik = solver(robot, JointCentering() + JointCentering(2.0, np.ones(3)))
        q = robot.random_configuration(rng)
        assert at(ik, q).cost == pytest.approx(q @ q / 2 + (q - 1) @ (q - 1))
        ik.parameters["joint_centering_2.preferred"] = np.zeros(3)
        assert at(ik, q).cost == pytest.approx(3 * q @ q / 2)

    @pytest.mark.parametrize("weight", [-1.0, np.nan, np.inf, "heavy", None, 1j, [1.0, 2.0]])
    def test_a_weight_is_a_finite_number_from_zero(self, weight):
        with pytest.raises(jtik.ArgumentError, match="weight"):
            JointCentering() * weight

    @pytest.mark.parametrize("criteria", ["joint_centering", 3, JointCentering, [JointCentering()]])
    def test_what_is_no_criterion_is_refused(self, criteria):
        with pytest.raises(jtik.ArgumentError, match="criteria"):
            solver(planar(2), criteria)

    def test_a_sum_with_something_else_is_a_type_error(self):
        with pytest.raises(TypeError):
            JointCentering() + 1.0

    def test_none_and_weight_zero_have_no_pull(self):
        robot, q0, target = planar(4), np.array([0.4, 0.3, 0.2, 0.1]), (2.0, 2.0)
        bare = solver(robot, None).solve(target, q0=q0)
        assert bare.cost == 0
        assert bare.criteria == {}
        assert bare.gradient.tolist() == [0] * 4
        weightless = solver(robot, 0 * JointCentering()).solve(target, q0=q0)
        assert weightless.converged
        assert weightless.q == pytest.approx(bare.q, abs=1e-5)


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

    def test_a_value_read_is_a_copy(self):
        parameters = self.solver().parameters
        parameters["obstacle_avoidance.radii"][0] = 9.0
        assert parameters["obstacle_avoidance.radii"][0] == 0.6

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
            ("obstacle_avoidance.radii", 0.1, r"\(2,\)"),
            ("obstacle_avoidance.radii", [0.1], r"\(2,\)"),
            ("obstacle_avoidance.radii", [0.1, np.nan], r"\(2,\)"),
            ("obstacle_avoidance.centers", [1.0, 2.0, 3.0, 4.0], r"\(2, 2\)"),
            ("obstacle_avoidance.centers", np.full((2, 2), np.inf), r"\(2, 2\)"),
            ("obstacle_avoidance.centers", [[1.0], [2.0, 3.0]], r"\(2, 2\)"),
            ("joint_centering.weight", [1.0], r"\(\)"),
            ("joint_centering.weight", np.nan, r"\(\)"),
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


class TestMessages:
    """Each names the criterion and shows the operation that cannot be traced."""

    def refused(self, function, *words):
        with pytest.raises(jtik.CriterionError) as caught:
            solver(planar(3), jtik.criterion(function))
        error = caught.value
        assert error.criterion == function.__name__
        for word in (repr(function.__name__), *words):
            assert word in str(error)
        return error

    def test_a_vector(self):
        def spread(q, robot):
            return q

        self.refused(spread, "(3, 1)", "scalar")

    def test_a_list(self):
        def pair(q, robot):
            return [q[0], q[1]]

        self.refused(pair, "scalar")

    def test_nothing(self):
        def forgotten(q, robot):
            q[0] ** 2

        self.refused(forgotten, "return", "NoneType")

    def test_the_math_module(self):
        def mathematical(q, robot):
            a = q[1] ** 2
            return a + math.sin(q[0])

        self.refused(mathematical, "math.sin(q[0])", "numpy.sin", "line")

    def test_a_comparison(self):
        def branching(q, robot):
            if q[0] > 0:
                return q[0]
            return -q[0]

        self.refused(branching, "if q[0] > 0", "if_else")

    def test_numpy_linear_algebra(self):
        def lengthy(q, robot):
            return np.linalg.eigvals(q)[0]

        self.refused(lengthy, "np.linalg.eigvals(q)", "norm_2")

    def test_a_call_into_float(self):
        def floated(q, robot):
            return float(q[0]) ** 2

        self.refused(floated, "float(q[0])")

    def test_an_index_out_of_range(self):
        def beyond(q, robot):
            return q[7] ** 2

        self.refused(beyond, "q[7]")

    def test_a_foreign_symbol(self):
        other = casadi.SX.sym("wind")

        def blown(q, robot):
            return q[0] ** 2 + other

        self.refused(blown, "wind", "not its own")

    def test_a_foreign_symbol_with_a_familiar_name(self):
        """A q of one's own is not the q that was handed in, whatever it is called."""
        impostor = casadi.SX.sym("q", 3)

        def confused(q, robot):
            return casadi.sumsqr(impostor)

        self.refused(confused, "not its own")

    def test_an_unknown_frame_keeps_its_own_error(self):
        @jtik.criterion
        def lost(q, robot):
            return robot.position(q, "hand")[0]

        with pytest.raises(jtik.UnknownNameError, match="hand"):
            solver(planar(3), lost)

    def test_nothing_is_printed(self, capsys):
        def mathematical(q, robot):
            return math.sin(q[0])

        self.refused(mathematical)
        assert capsys.readouterr() == ("", "")


class TestSubclass:
    def test_a_class_of_ones_own(self, rng):
        class Reach(jtik.Criterion):
            name = "reach"

            def parameters(self, robot):
                return {"wanted": np.array([[1.0, 2.0], [0.0, 1.0]])}

            def value(self, kinematics, parameters):
                away = parameters["wanted"] @ kinematics.position("link3")
                return casadi.sumsqr(away)

        robot = planar(4)
        ik = solver(robot, Reach())
        q = robot.random_configuration(rng)
        matrix = np.array([[1.0, 2.0], [0.0, 1.0]])
        assert at(ik, q).cost == pytest.approx(np.sum((matrix @ robot.position(q, "link3")) ** 2), rel=EXACT)
        matrix = np.array([[0.0, -1.0], [3.0, 1.0]])
        ik.parameters["reach.wanted"] = matrix
        assert at(ik, q).cost == pytest.approx(np.sum((matrix @ robot.position(q, "link3")) ** 2), rel=EXACT)

    @pytest.mark.parametrize("value", [np.nan, [np.inf], np.zeros((2, 2, 2))])
    def test_first_values_that_are_not_finite_or_have_too_many_axes_are_refused(self, value):
        class Odd(jtik.Criterion):
            name = "odd"

            def parameters(self, robot):
                return {"p": value}

            def value(self, kinematics, parameters):
                return kinematics.q[0]

        with pytest.raises(jtik.ArgumentError, match=r"odd\.p"):
            solver(planar(2), Odd())
