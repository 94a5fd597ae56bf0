"""The restarts by their distance from a target: reproducible, within the limits, about in the order of V."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import jtik
from jtik._loop.search.start_bank import SIZE, StartBanks
from jtik._loop.search.starts import Starts
from jtik._step.stopping import Code
from jtik._step.symbolic_problem import SymbolicProblem
from jtik.symbolic.compile import CompiledFunction

from ...conftest import planar


def problem(robot, **task):
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", **task))
    found: SymbolicProblem = ik._solving._runners._problem
    return ik, found


def test_the_same_seed_draws_the_same_starts_within_the_limits():
    _, of = problem(jtik.Robot.builtin("panda"), kind="pose")
    banks = StartBanks(of)
    first, other = banks.of(3), banks.of(4)
    again = StartBanks(of).of(3)
    assert np.array_equal(first.configurations, again.configurations)
    assert np.array_equal(first.coefficients, again.coefficients)
    assert not np.array_equal(first.configurations, other.configurations)
    assert first.configurations.shape == (SIZE, 7)
    assert (first.configurations >= of.robot.lower).all()
    assert (first.configurations <= of.robot.upper).all()


def test_the_configurations_are_the_first_restarts_of_the_seed():
    _, of = problem(jtik.Robot.builtin("panda"), kind="pose")
    generator = np.random.default_rng(5)
    expected = [of.robot.random_configuration(generator) for _ in range(SIZE)]
    assert np.array_equal(StartBanks(of).of(5).configurations, expected)


def test_another_seed_between_changes_nothing():
    _, of = problem(planar(3), kind="position")
    banks = StartBanks(of)
    first = banks.of(1)
    assert banks.known(1) is first
    banks.of(2)
    assert banks.known(1) is None
    again = banks.of(1)
    assert np.array_equal(first.configurations, again.configurations)
    assert np.array_equal(first.coefficients, again.coefficients)


def test_the_order_is_that_of_the_true_V_of_positions(rng):
    robot = planar(4)
    _, of = problem(robot, kind="position")
    bank, target = StartBanks(of).of(0), np.array([1.5, -0.5])
    V = [np.sum((robot.pose(q)[:2, 3] - target) ** 2) / 2 for q in bank.configurations]
    assert np.array_equal(bank.order(target), np.argsort(V))


@pytest.mark.parametrize("away", [1e3, 1e6])
def test_the_order_is_that_of_a_robot_at_the_origin(away, rng):
    """Far away the numbers of the targets are large, their differences are not."""
    placed, moved = jtik.Robot.builtin("panda"), np.eye(4)
    moved[:3, 3] = away, -away, 0
    solvers = [problem(robot, kind="pose") for robot in (placed, placed.with_base(moved))]
    banks = [StartBanks(of).of(0) for _, of in solvers]
    for _ in range(5):
        pose = placed.pose(placed.random_configuration(rng))
        ranks = []
        for (ik, _), bank, base in zip(solvers, banks, (np.eye(4), moved), strict=True):
            ranks.append(np.argsort(bank.order(ik.tasks.read_target(base @ pose))))
        assert np.abs(ranks[0] - ranks[1]).max() <= 2  # of two distances that agree to 16 binary digits either is first


def test_without_a_finite_distance_configurations_come_last_in_their_own_order():
    _, of = problem(planar(3), kind="position")
    bank = StartBanks(of).of(0)
    bank.coefficients[0, [4, 2, 9]] = np.nan, np.inf, -np.inf
    order = bank.order(np.array([1.0, 1.0])).tolist()
    assert order[-3:] == [2, 4, 9]
    assert sorted(order) == list(range(SIZE))
    bank.coefficients[:] = np.nan
    assert bank.order(np.array([1.0, 1.0])).tolist() == list(range(SIZE))


def test_threads_draw_the_banks_of_one():
    """The copies of a solver share what draws them."""
    _, of = problem(planar(4), kind="position")
    banks, seeds = StartBanks(of), [seed for seed in range(16) for _ in range(2)]
    before = sys.getswitchinterval()
    try:
        sys.setswitchinterval(1e-5)
        with ThreadPoolExecutor(16) as pool:
            found = list(pool.map(banks.of, seeds))
    finally:
        sys.setswitchinterval(before)
    for seed, bank in zip(seeds, found, strict=True):
        alone = StartBanks(of).of(seed)
        assert np.array_equal(bank.configurations, alone.configurations)
        assert np.array_equal(bank.coefficients, alone.coefficients)


@pytest.mark.quick(1)
@pytest.mark.parametrize("stiffness", [1.0, [1, 1, 1, 0.06, 0.06, 0.06], [4, 1, 9, 0.3, 0.3, 0.3]])
def test_distances_are_about_V(stiffness, rng):
    """For nearby poses to a few per cent; the order of all is about that of V."""
    robot = jtik.Robot.builtin("panda")
    ik, of = problem(robot, kind="pose", stiffness=stiffness)
    bank, residual = StartBanks(of).of(0), CompiledFunction(of.residual)
    target = ik.tasks.read_target(robot.pose(robot.random_configuration(rng)))
    V = np.array([np.sum(residual(q, target)[0] ** 2) / 2 for q in bank.configurations])
    found = bank.distances(target)
    nearest = np.argsort(found)[:10]
    assert np.mean(np.searchsorted(np.sort(V), V[nearest])) < 40  # of 512
    assert np.corrcoef(np.argsort(np.argsort(V)), np.argsort(np.argsort(found)))[0, 1] > 0.9


def test_distances_of_positions_are_exact(rng):
    robot = planar(4)
    _, of = problem(robot, kind="position")
    bank = StartBanks(of).of(0)
    target = np.array([1.5, -0.5])
    expected = [np.sum((robot.pose(q)[:2, 3] - target) ** 2) / 2 for q in bank.configurations]
    found = bank.distances(target) + np.sum((target - bank.centre) ** 2) / 2
    assert found == pytest.approx(np.array(expected), abs=1e-5)  # single precision


def test_a_restart_begins_at_the_nearest_start():
    """Attempts of one iteration: the target of a configuration of the bank is reached by the first restart alone."""
    robot = jtik.Robot.builtin("panda")
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "pose"), strategy="damped")
    bank = StartBanks(ik._solving._runners._problem).of(2)
    chosen = [0, 17, SIZE - 1]
    targets = [robot.pose(bank.configurations[k]) for k in chosen]
    found = ik.solve_batch(targets, restarts=1, max_iterations=1, seed=2, lanes=True)
    assert found.converged.all()
    assert found.restarts.tolist() == [1, 1, 1]
    assert found.q == pytest.approx(bank.configurations[chosen], abs=1e-6)  # they pass through single precision


@pytest.mark.quick(2)
@pytest.mark.parametrize("k", [1, 2, 3, 40, SIZE])
def test_restarts_follow_in_the_order_of_their_distances(k, rng):
    """Where only the k-th nearest configuration is on target, and attempts have one iteration, k restarts are made."""
    robot = jtik.Robot.builtin("panda")
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "pose"), strategy="damped")
    bank = StartBanks(ik._solving._runners._problem).of(0)
    answer = robot.random_configuration(rng)
    target = ik.tasks.read_target(robot.pose(answer))
    order = bank.order(target)
    elsewhere = np.tile(robot.neutral, (SIZE, 1))
    elsewhere[order[k - 1]] = answer
    other = bank._replace(configurations=elsewhere)
    starts = Starts(*other.starts, other)
    found = ik._solving._lanes.search(restarts=True).batch(target[None], robot.neutral[None], starts, SIZE, 1, 4.0)
    assert found.tallies[0].tolist() == [Code.DONE, k, k]
    assert found.q[0] == pytest.approx(answer, abs=1e-6)


@pytest.mark.parametrize("distance", [np.inf, np.nan])
def test_where_no_distance_is_finite_the_starts_follow_in_their_own_order(distance, rng):
    robot = jtik.Robot.builtin("panda")
    ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "pose"), strategy="damped")
    bank = StartBanks(ik._solving._runners._problem).of(0)
    answer = robot.random_configuration(rng)
    memory = np.tile(robot.neutral, (1 + SIZE, 1))
    memory[[0, 3]] = answer  # the first row is none of the starts
    bank.coefficients[:] = distance
    other = bank._replace(configurations=memory[1:])
    target = ik.tasks.read_target(robot.pose(answer))
    starts = Starts(*other.starts, other)
    found = ik._solving._lanes.search(restarts=True).batch(target[None], robot.neutral[None], starts, SIZE, 1, 4.0)
    assert found.tallies[0].tolist() == [Code.DONE, 3, 3]
