"""Solving and timing of work units."""

from __future__ import annotations

import gc

import numpy as np
import pytest

import jtik
from jtik.problems import Case, ProblemSet
from jtik.study import Answer, Contender, PreparedContender, Setting, StrategyContender, unit_runner
from jtik.study.case_run import checked, reason
from jtik.study.unit_runner import UnitRunner
from jtik.study.work_units import StudyPlan, WorkUnit
from jtik_formulations import JointCentering, ObstacleAvoidance

START = np.array([0.3, 0.4, -0.2, 0.5])


class Counting(Contender):
    """Counts its calls, and whether garbage collection was on."""

    label = "counting"

    def __init__(self):
        self.solver = CountingSolver()

    def prepare(self, setting):
        return self.solver


class CountingSolver(PreparedContender):
    note = "without something"

    def __init__(self):
        self.calls, self.collecting = [], []

    def solve(self, target, q0):
        self.calls.append(tuple(q0))
        self.collecting.append(gc.isenabled())
        return Answer(q0 + 0.1, "done", True, 1)


def a_plan(arm, task, contenders, **options):
    cases = [
        Case(name=f"c{i}", kind="k", q0=START + i, targets=[[1.0, 1.0]] * targets) for i, targets in ((0, 1), (1, 3))
    ]
    settings = {"criteria": {"": None}, "repeats": 2, "traces": 5, "block": 9, **options}
    return StudyPlan(
        setting=Setting(robot=arm, task=task),
        contenders=contenders,
        problems=ProblemSet("some", tuple(cases)),
        **settings,
    )


def test_each_target_is_solved_once_recorded_and_once_in_each_round(arm, task):
    contender = Counting()
    runner = UnitRunner(a_plan(arm, task, {"counting": contender}))
    result = runner.run(WorkUnit("", 0, 2))
    once = 1 + 3
    warm_up = 1
    assert len(contender.solver.calls) == once + 2 * (warm_up + once)
    assert contender.solver.collecting == [True] * once + [False] * 2 * (warm_up + once)
    assert gc.isenabled()
    assert [row.case for row in result.rows] == ["c0", "c1"]
    assert all(row.note.endswith("without something") for row in result.rows)


def test_each_target_of_a_path_starts_from_the_previous_answer(arm, task):
    contender = Counting()
    result = UnitRunner(a_plan(arm, task, {"counting": contender})).run(WorkUnit("", 1, 2))
    np.testing.assert_allclose(contender.solver.calls[:3], [START + 1, START + 1.1, START + 1.2])
    np.testing.assert_allclose(result.paths["counting", "", "c1"], [START + 1.1, START + 1.2, START + 1.3])
    np.testing.assert_allclose(result.answers[0], START + 1.3)


def test_a_slow_case_is_timed_once(arm, task, monkeypatch):
    monkeypatch.setattr(unit_runner, "LONG", 0.0)
    contender = Counting()
    UnitRunner(a_plan(arm, task, {"counting": contender}, repeats=5)).run(WorkUnit("", 0, 1))
    assert len(contender.solver.calls) == 1 + 1 + 1


def test_a_contender_is_built_once_for_each_set_of_criteria(arm, task):
    criteria = {"none": None, "centred": JointCentering()}
    runner = UnitRunner(a_plan(arm, task, {"damped": StrategyContender("damped")}, criteria=criteria))
    assert runner.prepared("none", "damped") is runner.prepared("none", "damped")
    assert runner.prepared("none", "damped") is not runner.prepared("centred", "damped")


def test_distances_of_other_criteria_are_used_where_a_label_has_none(arm, task):
    field = ObstacleAvoidance([jtik.Circle(center=(9.0, 0.0), radius=1.0)])
    runner = UnitRunner(a_plan(arm, task, {}, criteria={"none": None, "field": field}))
    assert runner.metrics("none").clearance([np.zeros(4)]) == pytest.approx(4.0)  # tip at 4, surface at 8


def test_an_answer_of_wrong_shape_raises():
    with pytest.raises(ValueError, match=r"shape \(3,\), not \(4,\)"):
        checked(Answer(np.zeros(3), "done", True), 4)


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (ValueError("two\n lines"), "ValueError: two lines"),
        (RuntimeError(), "RuntimeError: no message"),
        (ImportError("no module"), "no module"),
        (jtik.ArgumentError("q0", 1, "an array"), "q0: given 1; accepted: an array"),
    ],
)
def test_the_reason_of_a_failure_is_one_line(error, text):
    assert reason(error) == text
