"""Selection of the problems of a study."""

from __future__ import annotations

import pytest

import jtik
from jtik.problems import Case, ProblemSet
from jtik.study import Setting
from jtik.study.metrics import measures_of
from jtik.study.selection import KINDS, select_problems
from jtik_formulations import ObstacleAvoidance

FIELD = ObstacleAvoidance([jtik.Circle(center=(2.0, 2.0), radius=0.3), jtik.Circle(center=(-1.0, 2.0), radius=0.2)])


@pytest.fixture
def select(arm, task):
    def problems(given, criteria=None):
        measures = measures_of(criteria, ())
        return select_problems(given, Setting(robot=arm, task=task), measures, count=2, seed=3)

    return problems


def a_case(name="one"):
    return Case(name=name, kind="given", q0=[0.1, 0.2, 0.3, 0.4], targets=[[1.0, 1.0]])


def test_a_kind_is_drawn_as_by_its_generator(select, arm, task):
    assert select("reachable") == jtik.problems.reachable(arm, task, 2, seed=3)


def test_kinds_can_have_their_own_counts(select):
    problems = select({"reachable": 3, "unreachable": 1})
    assert [case.kind for case in problems] == ["reachable"] * 3 + ["unreachable"]
    assert len(select(["reachable", "unreachable"])) == 4


def test_given_cases_are_used_unchanged(select):
    cases = (a_case("one"), a_case("two"))
    assert select(cases[0]).cases == cases[:1]
    assert select(list(cases)).cases == cases
    problems = ProblemSet("some", cases)
    assert select(problems) is problems


def test_a_scene_has_as_many_obstacles_as_its_criterion(select):
    for case in select("scene", FIELD):
        assert case.parameters["obstacle_avoidance.centers"].shape == (2, 2)


@pytest.mark.parametrize("given", [3, None, [], {}, [3], ["reachable", a_case()], ProblemSet("empty", ()), "scene"])
def test_invalid_problems_are_refused(select, given):
    with pytest.raises(jtik.ArgumentError, match="problems"):
        select(given)


def test_an_unknown_kind_lists_the_known_ones(select):
    with pytest.raises(jtik.UnknownNameError, match="unknown kind of problems 'hard'"):
        select("hard")
    assert set(KINDS) <= set(jtik.problems.__all__)
