"""Solvers copied and pickled: the same answer to the last bit, and nothing shared."""

from __future__ import annotations

import copy
import functools
import multiprocessing
import operator
import pickle
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest

import jtik
from jtik.errors import ImmutableError
from jtik.strategy import Update
from jtik_formulations import Damped, JointCentering, ObstacleAvoidance

from ..conftest import ball_arm, planar

FIELD = jtik.Circle((2.0, 1.5), 0.3)

WAYS = {"copy": copy.copy, "deepcopy": copy.deepcopy, "pickle": lambda ik: pickle.loads(pickle.dumps(ik))}

PANDA = jtik.Robot.builtin("panda")
SOLVERS = {
    "plain": lambda: jtik.InverseKinematics(planar(3), jtik.FrameTask()),
    "criteria": lambda: jtik.InverseKinematics(
        planar(4), jtik.FrameTask(), criteria=2.0 * JointCentering() + ObstacleAvoidance(FIELD), strategy=Damped()
    ),
    "clearances": lambda: jtik.InverseKinematics(
        planar(4),
        jtik.FrameTask(),
        strategy="weighted_qp",
        clearances=jtik.Clearance(ObstacleAvoidance(FIELD, bodies="links"), safe=0.1),
    ),
    "joints": lambda: jtik.InverseKinematics(
        PANDA,
        jtik.FrameTask("tip", "position"),
        joints=[f"panda_joint{i}" for i in (1, 2, 4)],
        at=PANDA.keyframes["home"],
        limits=False,
    ),
    "weights": lambda: jtik.InverseKinematics(
        PANDA, jtik.FrameTask("tip", "position"), weights={"panda_joint1": 9.0, "panda_joint7": 2.0}
    ),
    "several tasks": lambda: jtik.InverseKinematics(
        planar(5), iter([jtik.FrameTask("tip", name="hand"), jtik.FrameTask("link3", axes="y", name="elbow")])
    ),
    "ball joints": lambda: jtik.InverseKinematics(ball_arm(), jtik.FrameTask("tip", "pose")),
}


@functools.cache
def original(name):
    return SOLVERS[name]()


def aimed(ik):
    """A target within reach, and where to begin."""
    q = ik.robot.integrate(ik.robot.neutral, np.linspace(0.3, 0.5, ik.robot.n))
    if len(ik.tasks.tasks) > 1:
        return {"hand": ik.robot.position(q), "elbow": ik.robot.position(q, "link3")}
    return ik.robot.pose(q) if ik.tasks.tasks[0].kind == "pose" else ik.robot.position(q)


@pytest.mark.thinned
@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", SOLVERS)
def test_a_copy_gives_the_same_answer(name, way):
    ik = original(name)
    copied, target = WAYS[way](ik), aimed(ik)
    mine, other = ik.solve(target, restarts=2), copied.solve(target, restarts=2)
    assert np.array_equal(mine.q, other.q)
    assert (mine.status, mine.iterations) == (other.status, other.iterations)
    assert repr(copied) == repr(ik)
    assert np.array_equal(copied.full_configuration(mine.q), ik.full_configuration(mine.q))


@pytest.mark.parametrize("way", WAYS)
def test_parameters_are_copied_and_not_shared(way):
    ik = SOLVERS["criteria"]()
    ik.parameters["joint_centering.weight"] = 0.1 + 0.2
    copied = WAYS[way](ik)
    assert float(copied.parameters["joint_centering.weight"]) == 0.1 + 0.2
    copied.parameters["joint_centering.weight"] = 7.0
    assert float(ik.parameters["joint_centering.weight"]) == 0.1 + 0.2
    ik.parameters["joint_centering.weight"] = 7.0
    target = aimed(ik)
    assert np.array_equal(ik.solve(target).q, copied.solve(target).q)


def test_a_copy_begins_its_steps_anew():
    ik, q, target = SOLVERS["plain"](), np.array([0.4, 0.3, 0.2]), np.array([-1.0, 0.1])
    first = ik.step(q, target)
    for _ in range(3):
        ik.step(q, target)
    assert copy.copy(ik).step(q, target).q.tolist() == first.q.tolist()


@pytest.mark.slow
@pytest.mark.parametrize("name", SOLVERS)
def test_a_copy_builds_neither_problem_nor_step_again(name, monkeypatch):
    ik = original(name)
    ik.warm_up()
    ik.solve(aimed(ik), trace=True)

    def refuse(*_, **__):
        raise AssertionError("it is built again")

    monkeypatch.setattr("jtik._step.symbolic_problem.SymbolicProblem.__init__", refuse)
    monkeypatch.setattr("jtik._loop.runners.fused_step", refuse)
    monkeypatch.setattr("jtik._loop.runners.box_function", refuse)
    copied = copy.copy(ik)
    copied.warm_up()
    assert copied.solve(aimed(ik)).status is ik.solve(aimed(ik)).status
    assert len(copied.solve(aimed(ik), trace=True).trace) > 0


def test_only_a_deep_copy_has_a_robot_of_its_own():
    ik = SOLVERS["plain"]()
    assert copy.copy(ik).robot is ik.robot
    assert copy.deepcopy(ik).robot is not ik.robot


@pytest.mark.slow
def test_a_process_pool_solves_with_the_same_answer():
    ik = SOLVERS["criteria"]()
    ik.parameters["obstacle_avoidance.weight"] = 0.25
    target = aimed(ik)
    mine = ik.solve(target)
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        other = pool.submit(operator.methodcaller("solve", target), ik).result(timeout=120)
    assert other.q.tobytes() == mine.q.tobytes()
    assert (other.status, other.iterations, other.cost) == (mine.status, mine.iterations, mine.cost)


class TestWhatCannotBePickled:
    def test_a_criterion(self):
        @jtik.criterion
        def local(q, robot):
            return q[0] ** 2

        ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), criteria=local)
        with pytest.raises(
            jtik.JtikError,
            match="cannot be pickled, because its criteria cannot: .*local.*; define classes and functions at the top",
        ):
            pickle.dumps(ik)
        assert copy.deepcopy(ik).solve((1.0, 1.5)).converged

    def test_a_strategy(self):
        class Local(jtik.Strategy):
            def update(self, model, state):
                return Update(model.row_space.least_squares(-model.here.residual).vector)

        ik = jtik.InverseKinematics(planar(3), jtik.FrameTask(), strategy=Local())
        with pytest.raises(jtik.JtikError, match="cannot be pickled, because its strategy cannot: .*Local"):
            pickle.dumps(ik)


class TestAssignment:
    @pytest.mark.parametrize(
        ("attribute", "instead"),
        [
            ("robot", r"build a new InverseKinematics\(..., robot=...\) instead"),
            ("tasks", r"build a new InverseKinematics\(..., task=...\) instead"),
            ("task", r"build a new InverseKinematics\(..., task=...\) instead"),
            ("strategy", r"build a new InverseKinematics\(..., strategy=...\) instead"),
            ("limits", r"build a new InverseKinematics\(..., limits=...\) instead"),
            ("clearances", r"build a new InverseKinematics\(..., clearances=...\) instead"),
            ("criteria", r"build a new InverseKinematics\(..., criteria=...\) instead"),
            ("parameters", r"assign ik.parameters\[name\] instead"),
            ("solve", "use a variable of your own instead"),
            ("speed", "use a variable of your own instead"),
        ],
    )
    def test_is_refused_with_what_to_do(self, attribute, instead):
        ik = jtik.InverseKinematics(planar(3), jtik.FrameTask())
        with pytest.raises(
            ImmutableError, match=f"this InverseKinematics is immutable: '{attribute}' cannot be changed; {instead}$"
        ) as caught:
            setattr(ik, attribute, None)
        assert isinstance(caught.value, jtik.JtikError)
        assert ik.solve((1.0, 1.5)).converged

    def test_deleting_is_refused_too(self):
        ik = jtik.InverseKinematics(planar(3), jtik.FrameTask())
        with pytest.raises(ImmutableError, match="'limits' cannot be changed"):
            del ik.limits
        assert isinstance(ik.limits, jtik.Limits)
