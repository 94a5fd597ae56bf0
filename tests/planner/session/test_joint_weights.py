"""Weights of the joints, changed on-line: a solver is built for them, and plans, attempts and files keep them."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.planner import Planner
from jtik.planner.edits.messages import MoveTarget, SetCriteria, SetJointWeights
from jtik.planner.edits.of_attempts import Record, Resolve, StopRecording, TakePlan
from jtik.planner.files.plan_file import Plan
from jtik.planner.session.loop import DT
from tests.planner.operator import ROBOT, Later, Operator


def displacement(operator: Operator) -> tuple[np.ndarray, np.ndarray]:
    """The first displacement of the joints towards a target near by, and the Jacobian where it began."""
    q = operator.loop.frame.q
    operator.does(MoveTarget(tuple(np.add(operator.loop.frame.position, (1e-4, 2e-4)))), seconds=DT)
    return operator.loop.frame.q - q, ROBOT.jacobian(q, rows="linear")


@pytest.mark.slow
def test_a_heavy_joint_moves_less_for_the_task() -> None:
    operator = Operator().does(SetCriteria(()), SetJointWeights({"joint1": 50.0}), SetJointWeights({"joint3": 0.2}))
    assert operator.told == []
    assert operator.loop.settings.joint_weights == (50.0, 1.0, 0.2, 1.0)
    dq, J = displacement(operator)
    inverse = np.diag(1 / np.array([50.0, 1.0, 0.2, 1.0]))
    expected = inverse @ J.T @ np.linalg.solve(J @ inverse @ J.T, J @ dq)  # least weighted sum of squares
    assert np.linalg.norm(dq) > 1e-5
    np.testing.assert_allclose(dq, expected, rtol=1e-3, atol=1e-9)


def test_the_old_solver_goes_on_until_the_weights_are_built() -> None:
    operator = Operator(at_once=False)
    solver = operator.state.solver
    operator.does(SetJointWeights({"joint1": 5.0}), SetJointWeights({"joint1": 6.0}))
    assert operator.state.solver is solver
    assert operator.loop.settings.rebuilding
    operator.executor.finish()
    operator.go(0.2)
    assert operator.state.solver.structure.joint_weights == (6.0, 1.0, 1.0, 1.0)
    operator.does(SetJointWeights({"joint1": 1.0}))
    assert operator.state.solver is solver  # it is kept


@pytest.mark.parametrize(
    ("weights", "word"), [({"elbow": 2.0}, "joint1"), ({"joint1": 1e5, "joint2": 1e-5}, "1e+08 times the smallest")]
)
def test_weights_that_cannot_be_used_change_nothing(weights: dict[str, float], word: str) -> None:
    operator = Operator()
    before = operator.loop.settings.to_json()
    operator.does(SetJointWeights(weights))
    assert len(operator.told) == 1
    assert word in operator.told[0]
    assert operator.loop.settings.to_json() == before


@pytest.mark.slow
def test_attempts_and_plans_have_them(tmp_path) -> None:
    operator = Operator().does(SetJointWeights({"joint2": 9.0}), Record())
    operator.does(MoveTarget((2.2, 0.9)), seconds=1).does(StopRecording())
    assert operator.loop.history["attempt 1"].settings["joint_weights"] == [1.0, 9.0, 1.0, 1.0]
    operator.loop.plan().save(tmp_path / "plan.json")
    other = Operator().does(TakePlan(Plan.load(tmp_path / "plan.json", ROBOT)))
    assert other.loop.settings.joint_weights == (1.0, 9.0, 1.0, 1.0)
    assert other.state.solver.structure.joint_weights == (1.0, 9.0, 1.0, 1.0)
    operator.does(SetJointWeights({"joint2": 1.0}), Resolve("attempt 1", name="equal"))
    heavy, equal = (np.ptp(operator.loop.history[name].configurations[:, 1]) for name in ("attempt 1", "equal"))
    assert heavy < equal


@pytest.mark.parametrize("wrong", [[1.0, 2.0], [1.0, -1.0, 1.0, 1.0], "abc"])
def test_wrong_weights_of_a_plan_are_refused(wrong: object) -> None:
    operator = Operator()
    plan = operator.loop.plan()
    settings = {**plan.settings, "joint_weights": wrong}
    operator.does(TakePlan(Plan(robot=plan.robot, scene=plan.scene, settings=settings, history=plan.history)))
    assert len(operator.told) == 1
    assert "weights" in operator.told[0]
    assert operator.loop.settings.joint_weights == (1.0,) * 4


def test_a_planner_begins_with_the_weights_of_the_library() -> None:
    planner = Planner(ROBOT, criteria=(), weights={"joint4": 3.0}, folder=False, executor=Later())
    assert planner.loop.settings.joint_weights == (1.0, 1.0, 1.0, 3.0)
    with pytest.raises(jtik.ArgumentError, match="weights"):
        Planner(ROBOT, weights=[1.0, 2.0], folder=False)
