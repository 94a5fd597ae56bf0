"""Cases and problem sets: copies, comparison, check against a robot, storage without loss."""

from __future__ import annotations

import json
import pickle

import numpy as np
import pytest

import jtik
from jtik.problems import Case, ProblemSet

from ..conftest import planar


def case(name="one", **changes):
    options = {"name": name, "kind": "reachable", "q0": [0.1, 0.2], "targets": [[1.0, 0.5]]}
    return Case(**options | changes)


def a_set(*names):
    return ProblemSet("some", tuple(case(name) for name in names), seed=3, origin="by hand")


def through_json(problems):
    return ProblemSet.from_data(json.loads(json.dumps(problems.as_data(), allow_nan=False)))


def test_a_case_copies_what_comes_in_and_cannot_be_changed():
    q0, target, centers = np.array([0.1, 0.2]), np.array([1.0, 0.5]), np.zeros((2, 2))
    made = case(q0=q0, targets=[target], parameters={"obstacle_avoidance.centers": centers})
    q0[:], target[:], centers[:] = 9, 9, 9
    assert made.q0.tolist() == [0.1, 0.2]
    assert made.target.tolist() == [1.0, 0.5]
    assert made.parameters["obstacle_avoidance.centers"].max() == 0
    for array in (made.q0, made.target, made.parameters["obstacle_avoidance.centers"]):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1


def test_cases_with_equal_values_are_equal():
    assert case() == case()
    assert hash(case()) == hash(case())
    assert case() != case(q0=[0.1, np.nextafter(0.2, 1)])
    assert case() != case(known={"error": 0.0})
    assert case() != "one"


TARGETS = {
    "position": np.array([0.1, 1 / 3, np.pi]),
    "angle": 0.1 + 0.2,
    "pose": np.eye(4),
    "pair": ([0.1, 0.2, 1 / 3], [1.0, 0.0, 0.0, 0.0]),
    "dict": {"left": np.array([1 / 3, 0.0]), "right": 2 / 3},
}


@pytest.mark.parametrize("target", TARGETS.values(), ids=TARGETS)
def test_targets_are_stored_in_json_without_loss(target):
    problems = ProblemSet("s", (case(targets=[target, target], dt=0.01, known={"H": 1 / 7}, reachable=False),), seed=1)
    back = through_json(problems)
    assert back == problems
    assert type(back[0].target) is type(problems[0].target)
    assert (back.name, back.seed, back[0].dt, back[0].known, back[0].reachable) == ("s", 1, 0.01, {"H": 1 / 7}, False)


def test_a_pose_object_is_stored_as_its_matrix():
    class Pose:
        def as_matrix(self):
            return np.eye(4)

    assert (case(targets=[Pose()]).target == np.eye(4)).all()


def test_a_set_survives_pickling():
    problems = a_set("a", "b")
    assert pickle.loads(pickle.dumps(problems)) == problems


def test_a_set_is_indexed_by_number_name_slice_and_kind():
    problems = a_set("a", "b", "c") + ProblemSet("other", (case("d", kind="circle"),), seed=4)
    assert [each.name for each in problems] == ["a", "b", "c", "d"]
    assert problems["b"] is problems[1] is problems[-3]
    assert problems.kinds == ("reachable", "circle")
    assert [each.name for each in problems.of("circle")] == ["d"]
    assert isinstance(problems[1:3], ProblemSet)
    assert [each.name for each in problems[1:3]] == ["b", "c"]
    assert problems[1:3].seed is None
    assert a_set("a")[:1].seed == 3
    with pytest.raises(jtik.UnknownNameError, match="did you mean 'circle'"):
        problems.of("circles")
    with pytest.raises(jtik.UnknownNameError, match="unknown case 'e'"):
        problems["e"]


def test_names_are_unique_and_can_be_changed():
    with pytest.raises(jtik.ArgumentError, match="renamed"):
        a_set("a", "a")
    both = a_set("a").renamed("first") + a_set("a").renamed("second")
    assert [each.name for each in both] == ["first-000", "second-000"]


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"name": ""}, "name"),
        ({"kind": 3}, "kind"),
        ({"q0": [0.1, np.nan]}, "q0"),
        ({"q0": [[0.1]]}, "q0"),
        ({"targets": []}, "targets"),
        ({"targets": "tip"}, "targets"),
        ({"targets": [[1.0, np.inf]]}, "targets[0]"),
        ({"targets": [[1.0, 2.0], [1.0, [2.0]]]}, "targets[1]"),
        ({"targets": [{"tip": [np.nan]}]}, "targets[0]['tip']"),
        ({"dt": 0.0}, "dt"),
        ({"closed": True}, "closed"),
        ({"parameters": {"a": [np.nan]}}, "parameters['a']"),
        ({"known": {"H": np.inf}}, "known['H']"),
    ],
)
def test_a_case_refuses_invalid_values(changes, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        case(**changes)
    assert caught.value.argument == argument


@pytest.mark.parametrize("data", [{}, {"name": "s", "cases": [], "size": 1}, [1], {"name": "s", "cases": [{}]}])
def test_invalid_data_is_refused(data):
    with pytest.raises(jtik.ArgumentError, match="a mapping with"):
        ProblemSet.from_data(data)


def test_a_valid_set_passes_check():
    a_set("a").check(planar(2), jtik.FrameTask())


@pytest.mark.parametrize(
    ("changes", "argument"),
    [
        ({"q0": [0.1] * 3}, "problems['one'].q0"),
        ({"targets": [[1.0, 0.0], [1.0, 0.0, 0.0]]}, "problems['one'].targets[1]"),
    ],
)
def test_check_names_the_case_and_the_invalid_value(changes, argument):
    problems = ProblemSet("s", (case("fits"), case(**changes)))
    with pytest.raises(jtik.ArgumentError) as caught:
        problems.check(planar(2), jtik.FrameTask())
    assert caught.value.argument == argument


def test_check_names_the_task_of_an_invalid_target():
    tasks = [jtik.FrameTask("tip"), jtik.FrameTask("link2", kind="orientation")]
    problems = ProblemSet("s", (case(targets=[{"tip": [1.0, 0.0], "link2": [1.0, 0.0]}]),))
    with pytest.raises(jtik.ArgumentError) as caught:
        problems.check(planar(2), tasks)
    assert caught.value.argument == "problems['one'].targets[0]['link2']"


def test_check_uses_the_reduced_robot():
    robot, task = planar(4), jtik.FrameTask("link3")
    free = jtik.InverseKinematics(robot, task).robot
    assert free.nq == 3
    case_of_three = ProblemSet("s", (case(q0=[0.1] * 3),))
    case_of_three.check(robot, task)
    case_of_three.check(free, task)
    with pytest.raises(jtik.ArgumentError, match=r"\.q0"):
        case_of_three.check(robot, task, joints="all")


def test_check_compares_parameters_with_those_of_a_solver():
    robot, task = planar(2), jtik.FrameTask()
    criterion = jtik.criteria["obstacle_avoidance"]([jtik.Circle([1.0, 1.0], 0.1)])
    live = jtik.InverseKinematics(robot, task, criteria=criterion).parameters
    valid, invalid, unknown = (
        ProblemSet("s", (case(parameters={key: value}),))
        for key, value in (
            ("obstacle_avoidance.centers", [[1.0, 2.0]]),
            ("obstacle_avoidance.centers", [[1.0, 2.0], [3.0, 4.0]]),
            ("clearance.centers", [[1.0, 2.0]]),
        )
    )
    valid.check(robot, task, parameters=live)
    unknown.check(robot, task)
    with pytest.raises(jtik.ArgumentError, match=r"shape \(2, 2\).*shape \(1, 2\)"):
        invalid.check(robot, task, parameters=live)
    with pytest.raises(jtik.ArgumentError, match=r"clearance\.centers.*one of"):
        unknown.check(robot, task, parameters=live)
