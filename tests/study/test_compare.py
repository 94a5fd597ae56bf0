"""`jtik.compare`: contenders, parameters, rows, tables and invalid input."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.problems import Case, ProblemSet
from jtik.study import StrategyContender
from jtik_formulations import Damped, JointCentering, ObstacleAvoidance

START = np.array([0.3, 0.4, -0.2, 0.5])


def case(name, target, **options):
    return Case(name=name, kind="given", q0=START, targets=[target], **options)


@pytest.fixture(scope="module")
def study(arm, task):
    return jtik.compare(
        arm,
        task,
        strategies=["hybrid", "damped", "nonsense"],
        criteria={"none": None, "centred": JointCentering()},
        problems={"reachable": 4, "unreachable": 2, "circle": 1},
        traces=2,
        repeats=2,
    )


class TestRows:
    @pytest.mark.slow
    def test_there_is_a_row_for_each_contender_criteria_and_case(self, study):
        keys = list(zip(*[study.columns[name] for name in ("contender", "criteria", "case")], strict=True))
        assert len(study) == len(keys) == len(set(keys)) == 3 * 2 * 7
        assert study.contenders == ("hybrid", "damped", "nonsense")
        assert study.criteria == ("none", "centred")
        assert study.complete

    @pytest.mark.slow
    def test_rows_agree_with_the_same_solve_outside_the_study(self, study, arm, task):
        ik = jtik.InverseKinematics(arm, task, criteria=JointCentering(), strategy="damped")
        for row in study.rows(contender="damped", criteria="centred", kind="reachable"):
            one = study.problems[str(study.columns["case"][row])]
            solution = ik.solve(one.target, q0=one.q0, until="reached")
            np.testing.assert_array_equal(study.answers[row], solution.q)
            assert study.columns["status"][row] == solution.status.name
            assert study.columns["iterations"][row] == solution.iterations
            assert study.columns["success"][row] == solution.converged
            assert study.columns["H"][row] == pytest.approx(solution.cost, rel=1e-12)
            assert study.columns["condition"][row] == pytest.approx(solution.condition, rel=1e-9)
            assert study.columns["position_error"][row] == pytest.approx(solution.position_error, abs=1e-12)

    def test_unreachable_cases_have_a_failure_status(self, study):
        rows = study.rows(contender="hybrid", criteria="none", kind="unreachable")
        assert not study.columns["success"][rows].any()
        assert set(study.columns["status"][rows]) <= {"LOCAL_MINIMUM", "STALLED", "ITERATION_LIMIT"}
        for row in rows:
            known = study.problems[str(study.columns["case"][row])].known["error"]
            assert study.columns["position_error"][row] == pytest.approx(known, abs=1e-6)

    def test_path_metrics_belong_to_paths_only(self, study):
        rows = study.rows(contender="hybrid", criteria="none", kind="circle")
        for name in ("smoothness", "drift", "path_length"):
            assert np.isfinite(study.columns[name][rows]).all()
        others = study.rows(contender="hybrid", criteria="none", kind="reachable")
        assert np.isnan(study.columns["drift"][others]).all()
        assert np.isnan(study.columns["smoothness"][others]).all()

    def test_the_median_time_lies_between_smallest_and_largest(self, study):
        good = study.columns["contender"] != "nonsense"
        seconds, low, high = (study.columns[name][good] for name in ("seconds", "seconds_low", "seconds_high"))
        assert (low > 0).all()
        assert (low <= seconds).all()
        assert (seconds <= high).all()

    def test_without_a_criterion_hybrid_never_raises_V(self, study):
        assert (study.columns["monotone"][study.rows(contender="hybrid", criteria="none")] == 1).all()

    def test_regret_is_the_difference_to_the_best_H(self, study):
        H, regret, solved = (study.columns[name] for name in ("H", "regret", "success"))
        for name in (each.name for each in study.problems.of("reachable")):
            rows = [row for row in study.rows(criteria="centred", case=name) if solved[row]]
            assert min(regret[rows]) == 0
            np.testing.assert_allclose(regret[rows], H[rows] - min(H[rows]))
        assert np.isnan(regret[study.rows(criteria="none")]).all()
        assert np.isnan(regret[~solved]).all()

    def test_traces_are_those_of_the_first_cases_of_each_kind(self, study):
        names = {name for who, what, name in study.traces if (who, what) == ("hybrid", "none")}
        assert names == {"reachable-000", "reachable-001", "unreachable-000", "unreachable-001"}
        assert {key[2] for key in study.paths} == {"circle-000"}
        assert study.paths["hybrid", "none", "circle-000"].shape == (101, 4)


class TestContenders:
    def test_an_unknown_strategy_does_not_stop_the_others(self, study):
        rows = study.rows(contender="nonsense")
        assert set(study.columns["status"][rows]) == {"not built"}
        assert all("unknown strategy 'nonsense'" in note for note in study.columns["note"][rows])
        assert np.isnan(study.answers[rows]).all()

    def test_a_contender_that_raises_has_rows_with_the_error(self, arm, task, broken):
        study = jtik.compare(arm, task, strategies=[broken, "damped"], count=3)
        rows = study.rows(contender="broken")
        assert set(study.columns["status"][rows]) == {"raised"}
        assert set(study.columns["note"][rows]) == {"RuntimeError: no answer"}
        assert study.columns["success"][study.rows(contender="damped")].any()

    def test_a_false_report_of_success_is_detected(self, arm, task, fixed):
        study = jtik.compare(arm, task, strategies=[fixed(START)], problems=case("unreachable", [0.0, 3.0]))
        away = np.linalg.norm(arm.position(START) - [0.0, 3.0])
        assert not study.columns["success"][0]
        assert study.columns["position_error"][0] == pytest.approx(away, rel=1e-12)
        assert study.columns["note"][0].startswith("reports success, but the error is")
        assert "fixed: reports success, but is off target by the independent check" in study.notes

    def test_an_answer_on_target_is_a_success_even_if_not_reported(self, arm, task, fixed):
        here = case("here", arm.position(START))
        contender = fixed(START, claimed=False)
        assert jtik.compare(arm, task, strategies=contender, problems=here).columns["success"][0]
        assert not jtik.compare(arm, task, strategies=contender, problems=here, until="stationary").columns["success"][
            0
        ]

    def test_a_compromise_is_named_and_no_success(self, arm, task):
        found = jtik.compare(
            arm,
            task,
            strategies=["hybrid", "weighted_qp"],
            criteria=JointCentering(),
            count=4,
            repeats=1,
            until="stationary",
        )
        soft = found.rows(contender="weighted_qp")
        assert set(found.columns["status"][soft]) == {"COMPROMISE"}
        assert not found.columns["success"][soft].any()
        assert found.summary()["compromise [%]"] == [0, 100]
        assert found.notes == {f"weighted_qp: {jtik.Status.COMPROMISE.value}": 4}
        assert "compromise" in repr(found)

    def test_an_answer_outside_the_limits_is_no_success(self, task, fixed):
        arm = jtik.Robot.planar(4, lower=-1.0, upper=0.45)
        here = case("here", arm.position(START))
        study = jtik.compare(arm, task, strategies=fixed(START), problems=here)
        assert not study.columns["success"][0]
        assert study.columns["limit_margin"][0] == pytest.approx(-0.05 / 1.45)
        assert study.columns["note"][0] == "outside the joint limits"
        assert jtik.compare(arm, task, strategies=fixed(START), problems=here, limits=False).columns["success"][0]

    def test_an_answer_of_wrong_shape_is_reported(self, arm, task, fixed):
        study = jtik.compare(arm, task, strategies=fixed(START[:3]), problems=case("here", [1.0, 1.0]))
        assert study.columns["status"][0] == "raised"
        assert "shape (3,), not (4,)" in study.columns["note"][0]

    def test_an_unknown_peer_is_a_row_with_a_note(self, arm, task):
        study = jtik.compare(arm, task, strategies="peer:elbow", count=1)
        assert "unknown peer 'elbow'" in study.columns["note"][0]

    def test_labels_are_names_options_or_given(self):
        from jtik.study.strategies import contenders_of

        given = ["damped", Damped(), Damped(damping=0.5), StrategyContender("hybrid", compiled=True), "damped"]
        assert list(contenders_of(given)) == [
            "damped",
            "damped #2",
            "damped(damping=0.5)",
            "hybrid, compiled",
            "damped #3",
        ]
        assert list(contenders_of({"mine": Damped(damping=0.5), "theirs": "peer:mink"})) == ["mine", "theirs"]


class TestParameters:
    """Cases that set live parameters."""

    FIELD = (jtik.Circle(center=(2.0, 2.0), radius=0.3),)

    def test_each_case_is_solved_among_its_own_obstacles(self, arm, task):
        places = [np.array([[2.5, 1.5]]), np.array([[1.0, 2.5]])]
        cases = [
            case("first", [2.0, 1.0], parameters={"obstacle_avoidance.centers": places[0]}),
            case("second", [2.0, 1.0], parameters={"obstacle_avoidance.centers": places[1]}),
            case("third", [2.0, 1.0]),
        ]
        avoid = ObstacleAvoidance(self.FIELD)
        study = jtik.compare(
            arm,
            task,
            strategies="damped",
            criteria=avoid,
            problems=ProblemSet("some", tuple(cases)),
            until="stationary",
        )
        for row, center in enumerate([*places, np.array([[2.0, 2.0]])]):
            ik = jtik.InverseKinematics(arm, task, criteria=avoid, strategy="damped")
            ik.parameters["obstacle_avoidance.centers"] = center
            solution = ik.solve([2.0, 1.0], q0=START, trace=True)
            np.testing.assert_array_equal(study.answers[row], solution.q)
            assert study.columns["H"][row] == pytest.approx(solution.cost, rel=1e-12)
            joints = [arm.position(q, frame) for q in solution.trace.q for frame in arm.moving_frames]
            nearest = min(np.linalg.norm(joint - center[0]) for joint in joints) - 0.3
            assert study.columns["clearance"][row] == pytest.approx(nearest, abs=1e-12)

    def test_clearance_is_measured_for_criteria_without_obstacles(self, arm, task):
        labels = {"blind": None, "seeing": ObstacleAvoidance(self.FIELD)}
        study = jtik.compare(arm, task, strategies="damped", criteria=labels, problems="scene", count=3)
        assert np.isfinite(study.columns["clearance"]).all()
        assert len(study.problems[0].parameters["obstacle_avoidance.centers"]) == 1

    def test_without_obstacles_there_is_no_clearance(self, study):
        assert np.isnan(study.columns["clearance"]).all()
        assert "clearance [m]" not in study.summary()


class TestWrongInput:
    @pytest.mark.parametrize(
        ("options", "message"),
        [
            ({"strategies": []}, "strategies"),
            ({"strategies": 3}, "strategies"),
            ({"strategies": [3]}, "strategies"),
            ({"problems": "hard"}, "unknown kind of problems 'hard'"),
            ({"problems": []}, "problems"),
            ({"problems": "scene"}, "problems"),
            ({"criteria": "low"}, "criterion 'low'"),
            ({"criteria": 3}, "criteria"),
            ({"criteria": {}}, "criteria"),
            ({"repeats": 0}, "repeats"),
            ({"traces": -1}, "traces"),
            ({"block": True}, "block"),
            ({"executor": 2}, "executor"),
            ({"until": "soon"}, "until"),
            ({"limits": None}, "limits"),
            ({"position_tolerance": 0.0}, "position_tolerance"),
            ({"joints": ["knee"]}, "knee"),
        ],
    )
    def test_invalid_arguments_are_named(self, arm, task, options, message):
        with pytest.raises(jtik.JtikError, match=message):
            jtik.compare(arm, task, **{"strategies": "damped", "count": 1, **options})

    def test_problems_of_another_robot_are_refused(self, arm, task):
        others = jtik.problems.reachable(jtik.Robot.planar(3), task, 2)
        with pytest.raises(jtik.ArgumentError, match=r"problems\['reachable-000'\]\.q0"):
            jtik.compare(arm, task, strategies="damped", problems=others)

    def test_parameters_that_no_criterion_has_are_refused(self, arm, task):
        strange = case("strange", [1.0, 1.0], parameters={"obstacle_avoidance.centers": np.zeros((1, 2))})
        with pytest.raises(jtik.ArgumentError, match=r"problems\['strange'\]\.parameters"):
            jtik.compare(arm, task, strategies="damped", problems=strange)

    def test_an_invalid_criterion_is_refused(self, arm, task):
        @jtik.criterion
        def invalid(q, robot):
            return q

        with pytest.raises(jtik.CriterionError, match="scalar"):
            jtik.compare(arm, task, strategies="damped", criteria=invalid, count=1)


class TestTables:
    def test_the_summary_has_a_row_for_each_contender_and_criteria(self, study):
        table = study.summary()
        assert list(zip(table["contender"], table["criteria"], strict=True)) == [
            (who, what) for what in ("none", "centred") for who in ("hybrid", "damped", "nonsense")
        ]
        assert table["cases"] == [7] * 6
        assert table["success [%]"][2] == 0
        solved = study.rows(contender="hybrid", criteria="none")
        solved = solved[study.columns["success"][solved]]
        assert table["time [ms]"][0] == pytest.approx(1e3 * np.median(study.columns["seconds"][solved]))
        assert math.isnan(table["time [ms]"][2])
        assert "orientation error [rad]" not in table

    def test_the_summary_groups_by_other_columns(self, study):
        assert study.summary("kind")["kind"] == ["reachable", "unreachable", "circle"]
        assert study.summary(("kind", "contender"))["cases"][0] == 8
        with pytest.raises(jtik.ArgumentError, match="by"):
            study.summary("colour")

    def test_the_summary_is_shown_as_text_html_and_markdown(self, study):
        assert "hybrid" in repr(study)
        assert "nonsense: not built: unknown strategy" in repr(study)
        assert study._repr_html_().count("<tr>") == 7
        lines = study.to_markdown().splitlines()
        assert len(lines) == 8
        assert len({line.count("|") for line in lines}) == 1

    def test_csv_stores_every_row_without_loss(self, study, tmp_path):
        import csv

        study.to_csv(tmp_path / "rows.csv")
        with (tmp_path / "rows.csv").open(newline="") as file:
            rows = list(csv.DictReader(file))
        assert [float(row["seconds"]) for row in rows] == pytest.approx(study.columns["seconds"], abs=0, nan_ok=True)
        assert [row["note"] for row in rows] == study.columns["note"].tolist()

    def test_pandas_has_both_tables(self, study):
        pytest.importorskip("pandas")
        assert study.table().shape[0] == 6
        assert list(study.frame()["contender"]) == study.columns["contender"].tolist()


def test_figures_are_those_of_the_reduced_robot():
    arm = jtik.Robot.builtin("panda")
    study = jtik.compare(arm, jtik.FrameTask("tip", "pose"), strategies="damped", count=3, restarts=20)
    assert study.answers.shape == (3, 7)
    assert study.columns["success"].all()
    assert (study.columns["limit_margin"] >= 0).all()
