"""Where the restarts of a search begin: the nearest to the target first, in Python and in C, drawn when needed."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik._loop.search.start_bank import SIZE
from jtik._step.stopping import Code
from jtik_formulations import JointCentering

from ...conftest import dh_arm, floating_arm, planar, shared_solver

ARM = planar(3, lower=-2.0, upper=2.0)
FAR = (5.0, 1.0)
"""A target out of reach: no attempt ends the search."""


def solver(robot=ARM, task=None, build=shared_solver, **options):
    return build(robot, task or jtik.FrameTask(), **({"strategy": "damped", "compiled": False} | options))


def starts_of(ik, target, restarts, **options):
    """Where the restarts of a solve begin, one a row."""
    trace = ik.solve(target, q0=ik.robot.neutral, restarts=restarts, trace=True, **options).trace
    begins = np.unique(trace.attempt, return_index=True)[1]
    return trace.q[begins[1 : restarts + 1]]


def drawn(robot, seed, count):
    """The restarts of a seed in the order in which they are drawn."""
    generator = np.random.default_rng(seed)
    return np.array([robot.random_configuration(generator) for _ in range(count)])


@pytest.mark.thinned
@pytest.mark.parametrize("target", [FAR, (-4.0, 0.5)])
@pytest.mark.parametrize("criteria", [None, JointCentering()], ids=["task alone", "with a criterion"])
def test_restarts_follow_in_the_order_of_the_true_V(target, criteria):
    bank = drawn(ARM, 3, SIZE)
    V = [np.sum((ARM.pose(q)[:2, 3] - target) ** 2) / 2 for q in bank]
    found = starts_of(solver(criteria=criteria), target, 40, seed=3)
    assert np.array_equal(found, bank[np.argsort(V)[:40]])


def test_the_restarts_after_those_of_the_bank_follow_as_they_are_drawn():
    expected = drawn(ARM, 3, SIZE + 40)
    found = starts_of(solver(), FAR, SIZE + 40, seed=3)
    assert np.array_equal(found[SIZE:], expected[SIZE:])
    assert np.array_equal(np.sort(found[:SIZE], axis=0), np.sort(expected[:SIZE], axis=0))


def test_within_a_jump_limit_they_follow_as_they_are_drawn():
    robot = planar(3, lower=-2.0, upper=2.0)
    ik = solver(robot)
    search = ik._engine.search
    expected = search._restarts.around(1, 3, robot.neutral, search.jump(robot.neutral, 0.5)).configurations
    assert np.array_equal(starts_of(ik, FAR, 8, seed=3, jump_limit=0.5), expected[:8])


def test_about_where_the_search_began_they_follow_as_they_are_drawn():
    robot = floating_arm()
    ik = solver(robot, jtik.FrameTask(robot.tip, "position"))
    target = np.full(3, 500.0)
    found = starts_of(ik, target, 5, seed=3, max_iterations=2)
    expected = ik._engine.search._restarts.around(1, 3, robot.neutral).configurations
    assert found == pytest.approx(expected[:5], abs=1e-12)


def test_of_a_task_that_names_no_target_of_a_pose_they_follow_as_they_are_drawn():
    """What a camera looks at is not known from its pose."""
    robot = jtik.Robot.builtin("panda")
    ik = solver(robot, jtik.LookAtTask("tip"))
    found = starts_of(ik, [1.0, 2.0, 0.3], 6, seed=3, max_iterations=1, orientation_tolerance=1e-300)
    assert np.array_equal(found, drawn(robot, 3, 6))


def same(a, b):
    assert np.array_equal(a.q, b.q)
    assert (a.status, a.iterations, a.restarts) == (b.status, b.iterations, b.restarts)


@pytest.mark.parametrize("restarts", [3, SIZE + 20])
def test_in_c_and_on_the_virtual_machine_alike(restarts, rng):
    arm = dh_arm(7, 3, limit=1.5)
    machine, c = (solver(arm, jtik.FrameTask("tip", "pose"), compiled=each) for each in (False, True))
    lost = np.eye(4)
    lost[:3, 3] = 50.0
    targets = [lost, *(arm.pose(arm.random_configuration(rng)) for _ in range(10))]
    q0 = arm.random_configuration(rng)
    for seed in (0, 7, 0):
        alone = [machine.solve(target, q0=q0, restarts=restarts, seed=seed) for target in targets]
        assert alone[0].restarts == restarts
        for one, target in zip(alone, targets, strict=True):
            same(one, c.solve(target, q0=q0, restarts=restarts, seed=seed))
        batch = c.solve_batch(targets, q0=q0, restarts=restarts, seed=seed)
        for i, one in enumerate(alone):
            same(one, batch[i])


@pytest.mark.parametrize("distance", [np.inf, np.nan])
def test_in_c_without_a_finite_distance_they_follow_as_they_are_drawn(distance):
    """Attempts of one iteration: the target is the configuration of the fourth restart."""
    robot = jtik.Robot.builtin("panda")
    ik = solver(robot, jtik.FrameTask("tip", "pose"), compiled=True, build=jtik.InverseKinematics)
    bank = ik._engine.runners.banks.of(0)
    bank.coefficients[:] = distance
    found = ik.solve(robot.pose(bank.configurations[3]), q0=robot.neutral, restarts=9, max_iterations=1)
    assert (found.converged, found.restarts) == (True, 4)


class TestABankIsDrawnWhenARestartIsNeeded:
    @pytest.fixture
    def ik(self):
        return solver(
            dh_arm(7, 3, limit=1.5), jtik.FrameTask("tip", "pose"), compiled=True, build=jtik.InverseKinematics
        )

    def goals(self, ik):
        """A target that the first attempt reaches and others that it does not, with where they begin."""
        rng, arm = np.random.default_rng(0), ik.robot
        far = [arm.pose(arm.random_configuration(rng)) for _ in range(40)]
        needed = ik.solve_batch(far, q0=arm.neutral, restarts=100, seed=99).restarts > 0
        assert needed.sum() > 5
        return arm.pose(np.full(7, 0.1)), [T for T, each in zip(far, needed, strict=True) if each]

    def test_not_before(self, ik):
        near, far = self.goals(ik)
        banks = ik._engine.runners.banks
        ik.solve(near, q0=ik.robot.neutral, restarts=100, seed=5)
        assert banks.known(5) is None
        first = ik.solve(far[0], q0=ik.robot.neutral, restarts=100, seed=5)
        assert first.restarts > 0
        assert banks.known(5) is not None
        same(first, ik.solve(far[0], q0=ik.robot.neutral, restarts=100, seed=5))

    @pytest.mark.slow
    def test_warm_up_draws_that_of_the_default_seed(self, ik):
        ik.warm_up()
        assert ik._engine.runners.banks.known(0) is not None

    def test_then_every_attempt_of_a_solve_is_in_one_call_of_c(self, ik, monkeypatch):
        _, far = self.goals(ik)
        ik.solve(far[0], q0=ik.robot.neutral, restarts=100, seed=5)
        native = ik._engine.search.native
        monkeypatch.setattr(native, "find", lambda *_: pytest.fail("another call"))
        for target in far:
            assert ik.solve(target, q0=ik.robot.neutral, restarts=100, seed=5).converged
        assert native.run_prepared() == Code.DONE
