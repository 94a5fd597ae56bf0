"""Changes on-line: obstacles and settings, what is live, what is built, and what cannot be."""

from __future__ import annotations

from itertools import count

import numpy as np
import pytest

import jtik
from jtik.planner import Planner
from jtik.planner.edits.messages import (
    AddObstacle,
    ChangeObstacle,
    DeleteObstacle,
    MoveTarget,
    SetClearance,
    SetCriteria,
    SetGain,
    SetLimits,
    SetObstacleGain,
    SetPreferred,
    SetStrategy,
    SetTargetSpeed,
    TakePosture,
)
from jtik.planner.edits.of_attempts import Branch, Record, StopRecording, Undo
from jtik.planner.session.loop import DT
from tests.planner.operator import ROBOT, START, Later, Operator

CIRCLE = {"shape": "circle", "center": [1.5, -2.0], "radius": 0.3}
AVOIDING = SetCriteria(("joint_centering", "obstacle_avoidance"))


@pytest.fixture
def operator() -> Operator:
    return Operator()


def distance(q: np.ndarray, centre: tuple[float, float], radius: float) -> float:
    """Of the joints to a disc."""
    return min(np.linalg.norm(ROBOT.position(q, name) - centre) for name in ROBOT.moving_frames) - radius


def test_obstacles_in_their_places_build_nothing(operator: Operator) -> None:
    solver = operator.state.solver
    operator.does(AddObstacle("disc", CIRCLE, 0.5))
    assert operator.loop.settings.scene["disc"] == {**CIRCLE, "gain": 0.5}
    assert np.isclose(
        operator.loop.status.clearance["joints"],
        min(distance(operator.state.q, (2.0, 2.4), 0.3), distance(operator.state.q, (1.5, -2.0), 0.3)),
    )
    operator.does(ChangeObstacle("disc", {**CIRCLE, "center": [2.0, 1.0], "radius": 0.1}))
    assert operator.loop.settings.scene["disc"]["gain"] == 0.5
    assert np.isclose(operator.loop.status.clearance["joints"], distance(operator.state.q, (2.0, 1.0), 0.1))
    operator.does(SetObstacleGain("disc", 0.0), SetObstacleGain("post", 0.0))
    assert operator.loop.status.clearance == {}
    operator.does(DeleteObstacle("disc"), DeleteObstacle("post"))
    assert operator.loop.settings.scene == {}
    assert operator.state.solver is solver
    assert operator.told == []


@pytest.mark.slow
def test_an_obstacle_on_the_arm_is_seen_and_the_arm_yields(operator: Operator) -> None:
    operator.does(AVOIDING, seconds=8)
    elbow = ROBOT.position(operator.loop.frame.q, "link3")
    disc = {"shape": "circle", "center": [elbow[0], elbow[1] + 0.06], "radius": 0.1}
    operator.does(AddObstacle("dropped", disc), seconds=0.1)
    assert "link3" in operator.loop.status.violated
    target = operator.loop.frame.position
    operator.go(10)
    assert operator.loop.status.violated == ()
    np.testing.assert_allclose(operator.tip, target, atol=1e-4)


@pytest.mark.slow
def test_more_obstacles_than_places_build_a_solver_with_more(operator: Operator) -> None:
    operator.does(AVOIDING)
    for i in range(5):
        operator.does(AddObstacle(f"disc {i}", {**CIRCLE, "center": [i - 2.0, 3.0]}))
    box = {"shape": "box", "center": [3.0, 0.3], "half": [0.2, 0.2], "rotation": 0.3}
    operator.does(AddObstacle("box", box), MoveTarget((2.5, 0.5)), seconds=3)
    assert operator.told == []
    assert operator.loop.settings.capacity["ball"] >= 6
    assert operator.loop.settings.capacity["box"] >= 1
    assert len(operator.loop.settings.scene) == 7
    assert np.count_nonzero(operator.state.solver.ik.parameters["obstacle_avoidance.gains"]) == 7
    assert operator.loop.settings.scene["box"]["rotation"] == pytest.approx(0.3)


def test_the_old_solver_goes_on_while_another_one_is_built() -> None:
    operator = Operator(at_once=False)
    solver = operator.state.solver
    operator.does(SetStrategy("hybrid"), SetPreferred("joint2", -0.4), MoveTarget((2.4, 0.8)), seconds=4)
    assert operator.state.solver is solver
    assert operator.loop.status.rebuilding
    assert operator.loop.settings.rebuilding
    assert operator.loop.settings.strategy["name"] == "hybrid"
    assert operator.loop.status.error < 1e-4
    q = operator.loop.frame.q
    operator.executor.finish()
    operator.go(0.2)
    assert operator.state.solver is not solver
    assert not operator.loop.status.rebuilding
    assert not operator.loop.settings.rebuilding
    assert np.abs(operator.loop.frame.q - q).max() < 0.1  # it goes on from where the arm was
    assert operator.state.solver.ik.parameters["joint_centering.preferred"][1] == -0.4


@pytest.mark.slow
def test_of_several_requests_the_latest_is_built() -> None:
    operator = Operator(at_once=False)
    operator.does(SetStrategy("hybrid"))
    operator.does(SetStrategy("transpose"))
    operator.does(SetStrategy("damped", {"damping": 0.2}), SetCriteria(()))
    operator.executor.finish()  # hybrid
    operator.go(0.1)
    assert operator.state.solver.structure.strategy == "newton"
    operator.executor.finish()
    operator.go(0.1)
    assert operator.state.solver.ik.strategy.damping == 0.2
    assert operator.loop.settings.criteria == ()
    assert operator.loop.status.H == 0


def test_a_solver_that_was_built_before_is_kept(operator: Operator) -> None:
    first = operator.state.solver
    operator.does(SetStrategy("hybrid"))
    operator.executor.at_once = False
    operator.does(SetPreferred("joint1", 0.3), SetStrategy("newton"))
    assert operator.state.solver is first
    assert first.ik.parameters["joint_centering.preferred"][0] == 0.3


@pytest.mark.parametrize(
    ("edit", "word"),
    [
        (SetStrategy("newtn"), "newton"),
        (SetStrategy("newton", {"speed": 3}), "q_limit"),
        (SetStrategy("newton", {"q_limit": -1.0}), "q_limit"),
        (SetCriteria(("joint_centring",)), "joint_centering"),
        (SetCriteria(("look_at",)), "joint_centering"),
        (SetPreferred("elbow", 1.0), "joint1"),
        (SetGain("joint_centering.stifness", 1.0), "joint_centering.stiffness"),
        (SetGain("joint_centering.stiffness", -1.0), "non-negative"),
        (SetGain("joint_centering.preferred", 1.0), "joint_centering.weight"),
        (AddObstacle("post", CIRCLE), "no other obstacle"),
        (AddObstacle("a", {"shape": "cicle"}), "circle"),
        (AddObstacle("a", {**CIRCLE, "radius": -1}), "radius"),
        (AddObstacle("a", {"shape": "sphere", "center": [0, 0, 0], "radius": 1}), "2-dimensional"),
        (ChangeObstacle("pots", CIRCLE), "post"),
        (DeleteObstacle("pots"), "post"),
        (SetObstacleGain("pots", 1.0), "post"),
    ],
)
def test_what_cannot_be_done_is_told_and_changes_nothing(operator: Operator, edit: object, word: str) -> None:
    before = operator.loop.settings.to_json()
    operator.does(edit)
    assert len(operator.told) == 1
    assert operator.told[0].startswith(f"{edit.kind}: ")
    assert word in operator.told[0]
    assert operator.loop.settings.to_json() == before
    assert not operator.executor.waiting


@pytest.mark.slow
def test_a_build_that_fails_leaves_the_old_solver(operator: Operator) -> None:
    solver = operator.state.solver
    operator.does(SetClearance(True))  # which this strategy does not support
    assert "the one before goes on" in operator.told[0]
    assert "newton+qp" in operator.told[0]
    assert operator.state.solver is solver
    assert operator.loop.settings.clearance is False
    operator.does(SetStrategy("newton+qp", {"secondary.weight": 2.0}))
    assert operator.loop.settings.strategy == {"name": "newton+qp", "options": {"secondary.weight": 2.0}}


@pytest.mark.slow
def test_a_clearance_is_kept(operator: Operator) -> None:
    operator.does(SetStrategy("newton+qp"), SetClearance(True, 0.2))
    assert operator.loop.settings.clearance
    operator.does(ChangeObstacle("post", {"shape": "circle", "center": [2.0, 1.8], "radius": 0.3}))
    operator.does(MoveTarget((2.0, 1.8)), seconds=6)  # inside the disc
    assert operator.loop.status.clearance["links"] > 0.2 - 1e-6
    assert operator.loop.status.violated == ()
    assert "clearances" in operator.loop.status.words


def test_preferred_postures(operator: Operator) -> None:
    operator.does(SetPreferred("joint3", 0.4), seconds=0.2)
    assert operator.loop.settings.preferred == (0.0, 0.0, 0.4, 0.0)
    operator.does(TakePosture())
    q = operator.state.values.preferred
    np.testing.assert_allclose(operator.loop.settings.preferred, q)
    operator.go(8)
    J = ROBOT.jacobian(operator.state.q, rows="linear")
    rest = operator.state.q - q
    null = np.eye(4) - np.linalg.pinv(J) @ J
    np.testing.assert_allclose(null @ rest, 0, atol=1e-5)  # stationary for the new posture


def test_gains_are_live(operator: Operator) -> None:
    operator.does(SetGain("joint_centering.stiffness", (1.0, 2.0, 3.0, 4.0)), SetGain("joint_centering.weight", 0.5))
    q = operator.state.q
    assert operator.loop.settings.gains["joint_centering.stiffness"] == [1.0, 2.0, 3.0, 4.0]
    assert np.isclose(operator.loop.status.H, 0.5 * 0.5 * np.array([1.0, 2.0, 3.0, 4.0]) @ q**2)
    operator.does(SetStrategy("hybrid"))
    assert operator.state.solver.ik.parameters["joint_centering.weight"] == 0.5


def test_speed_and_limits(operator: Operator) -> None:
    operator.does(SetTargetSpeed(0.25, 2.0), SetLimits(False))
    assert operator.loop.settings.target_speed == (0.25, 2.0)
    assert operator.loop.settings.limits is False
    assert not operator.state.solver.ik.limits.position
    start = operator.loop.frame.position
    operator.does(MoveTarget((5.0, 5.0)), seconds=1)
    assert np.isclose(np.linalg.norm(operator.loop.frame.position - start), 0.25)


def test_a_message_is_told_once_in_a_while(operator: Operator) -> None:
    for _ in range(10):
        operator.does(DeleteObstacle("pots"))
    assert len(operator.told) == 1
    operator.go(5)
    operator.does(DeleteObstacle("pots"))
    assert len(operator.told) == 2


ACCELERATION = 3.0
PERIODS = count(1)


def accelerations(q: np.ndarray) -> np.ndarray:
    """Of samples one period apart [rad/s^2]."""
    return np.abs(np.diff(q, n=2, axis=0)) / DT**2


@pytest.fixture
def slow_starter() -> Planner:
    limits = jtik.Limits(velocity=2.0, acceleration=ACCELERATION)
    return Planner(ROBOT, criteria=(), q0=START, limits=limits, folder=False, executor=Later(), clock=lambda: 0.0)


def run(planner: Planner, seconds: float) -> np.ndarray:
    """Some periods: configurations (k, nq)."""
    found = []
    for _ in range(round(seconds / DT)):
        planner.loop.tick(next(PERIODS) * DT)
        found.append(planner.loop.frame.q)
    return np.array(found)


@pytest.mark.slow
def test_another_solver_goes_on_as_fast_as_the_arm_moves(slow_starter: Planner) -> None:
    slow_starter.loop.submit(MoveTarget(tuple(np.add(slow_starter.loop.frame.position, (1.0, -0.6)))))
    before = run(slow_starter, 0.5)
    assert np.abs(np.diff(before, axis=0)[-1]).max() > 3 * ACCELERATION * DT**2  # no limit would allow that from rest
    slow_starter.loop.submit(SetStrategy("damped"))
    slow_starter.loop.submit(SetCriteria(("joint_centering",)))
    q = np.concatenate([before, run(slow_starter, 0.4)])
    assert slow_starter.loop.settings.strategy["name"] == "damped"
    assert not slow_starter.loop.settings.rebuilding
    assert accelerations(q).max() < ACCELERATION * (1 + 1e-6)


@pytest.mark.slow
def test_a_branch_goes_on_as_fast_as_the_attempt_and_undo_is_at_rest(slow_starter: Planner) -> None:
    loop = slow_starter.loop
    loop.submit(Record())
    loop.submit(MoveTarget(tuple(np.add(loop.frame.position, (1.0, -0.6)))))
    run(slow_starter, 1.2)
    loop.submit(Branch("attempt 1", 0.5))
    run(slow_starter, 0.6)
    loop.submit(StopRecording())
    run(slow_starter, 0.1)
    branch = loop.history["attempt 1.1"]
    assert accelerations(branch.configurations).max() < ACCELERATION * (1 + 1e-6)
    fastest = np.abs(np.diff(branch.configurations, axis=0)).max() / DT
    assert fastest > 3 * ACCELERATION * DT
    loop.submit(Undo("attempt 1", 0.5))
    first, attempt = run(slow_starter, DT)[0], loop.history["attempt 1"]
    from_rest = np.abs(first - attempt.configurations[attempt.index(0.5)])
    assert from_rest.max() < ACCELERATION * DT**2 * (1 + 1e-6)
