"""Division of a study into work units."""

from __future__ import annotations

import pickle

import pytest

import jtik
from jtik.study import Setting, StrategyContender
from jtik.study.work_units import StudyPlan
from jtik_formulations import JointCentering


@pytest.fixture
def plan(arm, task):
    problems = jtik.problems.reachable(arm, task, 5) + jtik.problems.unreachable(arm, task, 2)
    return StudyPlan(
        setting=Setting(robot=arm, task=task),
        contenders={"damped": StrategyContender("damped")},
        criteria={"none": None, "centred": JointCentering()},
        problems=problems,
        repeats=1,
        traces=3,
        block=3,
    )


def test_units_cover_every_case_once_for_each_set_of_criteria(plan):
    covered = [(unit.criteria, i) for unit in plan.units() for i in range(unit.start, unit.stop)]
    assert covered == [(label, i) for label in ("none", "centred") for i in range(7)]
    assert [unit.stop - unit.start for unit in plan.units()] == [3, 3, 1] * 2


def test_the_setting_of_a_label_has_its_criteria(plan):
    assert plan.setting_with("none").criteria is None
    assert plan.setting_with("centred").criteria is plan.criteria["centred"]


def test_the_first_cases_of_each_kind_are_traced(plan):
    assert plan.traced_cases == {
        "reachable-000",
        "reachable-001",
        "reachable-002",
        "unreachable-000",
        "unreachable-001",
    }


def test_a_plan_can_be_pickled(plan):
    copy = pickle.loads(pickle.dumps(plan))
    assert copy.units() == plan.units()
    assert copy.problems == plan.problems
