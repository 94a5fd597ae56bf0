"""Searches in lanes begin in single precision: their answers have double precision, and nothing is lost by it."""

from __future__ import annotations

import time

import numpy as np
import pytest

import jtik
from jtik._loop.lanes import lanes as all_lanes
from jtik._loop.lanes import search as lane_search
from jtik._loop.lanes import search_source

from ...conftest import ball_arm, dh_arm, planar, slow
from .test_search import problems, same, solver


def solved(monkeypatch, robot, kind, targets, *, single=True, constants=None, **options):
    """The targets solved in lanes by a new solver, with or without the search in single precision.

    With other ``constants`` it is used whatever its rounding is.
    """
    build = all_lanes.lane_library
    with monkeypatch.context() as patch:
        if constants:
            patch.setattr(lane_search.LaneSearch, "_begins_in_single_precision", lambda *_: single)
        for name, value in (constants or {}).items():
            patch.setattr(search_source, name, value)
        built = []

        def library(*arguments, **flags):
            built.append(build(*arguments, **{**flags, "single": single and flags["single"]}))
            return built[-1]

        patch.setattr(all_lanes, "lane_library", library)
        ik = jtik.InverseKinematics(robot, jtik.FrameTask(robot.tip, kind), strategy="damped")
        found = ik.solve_batch(targets, **{"restarts": 20, "lanes": True, **options})
    return found, built[-1].single is not None


def poses(robot, rng, count):
    return np.array([robot.pose(robot.random_configuration(rng)) for _ in range(count)])


@pytest.mark.parametrize("count", [60, *slow(3000)])
@pytest.mark.parametrize("name", ["panda", *slow("ur5", "iiwa14")])
def test_answers_are_in_double_precision_and_mostly_those_of_a_search_in_it(name, count, monkeypatch, rng):
    robot = jtik.Robot.builtin(name)
    targets = poses(robot, rng, count)
    found, begins_in_single = solved(monkeypatch, robot, "pose", targets, restarts=100)
    expected, _ = solved(monkeypatch, robot, "pose", targets, single=False, restarts=100)
    assert begins_in_single
    assert found.converged.all()
    assert (found.position_error <= 1e-6).all()
    assert (found.orientation_error <= 1e-6).all()
    assert found.position_error.min() < 1e-9  # far below what single precision tells apart
    assert (found.q >= robot.lower).all()
    assert (found.q <= robot.upper).all()
    alike = np.abs(found.q - expected.q).max(axis=1) < 1e-3
    assert alike.mean() > 0.9
    assert np.median(np.abs(found.iterations - expected.iterations)[alike]) <= 1
    assert found.iterations.mean() < expected.iterations.mean() + 1


@pytest.mark.parametrize("limit", [3, 6, 200])
def test_what_it_does_not_reach_is_found_as_without_it(limit, monkeypatch, rng):
    """No attempt is closer to its target than single precision allows: double precision begins anew."""
    robot = jtik.Robot.builtin("panda")
    targets = poses(robot, rng, 30)
    options = {"max_iterations": limit, "q0": np.full(7, 0.3)}
    options |= {"position_tolerance": 1e-10, "orientation_tolerance": 1e-10}
    expected, _ = solved(monkeypatch, robot, "pose", targets, single=False, **options)
    found, _ = solved(monkeypatch, robot, "pose", targets, constants={"COARSE": 1e-12}, **options)
    assert found.status == expected.status
    assert np.array_equal(found.q, expected.q)
    assert np.array_equal(found.restarts, expected.restarts)
    assert (found.iterations.sum() > expected.iterations.sum()) == (limit > 3)  # with 3 no attempt arrives in lanes


def test_where_its_end_leads_nowhere_the_search_begins_anew(monkeypatch, rng):
    """Ends that count as close to the target but are not: most attempts that continue there do not arrive."""
    robot = jtik.Robot.builtin("panda")
    targets = poses(robot, rng, 60)
    expected, _ = solved(monkeypatch, robot, "pose", targets, single=False, restarts=100)
    found, _ = solved(monkeypatch, robot, "pose", targets, constants={"COARSE": 2.0}, restarts=100)
    assert found.status == expected.status
    assert found.converged.all()
    assert (found.q == expected.q).all(axis=1).any()  # begun anew


@pytest.mark.thinned
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-11])
@pytest.mark.parametrize("limit", [4, 5, 6, 8, 200])
def test_ends_that_are_finished_side_by_side_are_those_of_the_search(limit, tolerance, monkeypatch, rng):
    """At the end itself, after one step, and those that need more; also where the iterations are just enough."""
    robot = dh_arm(7, 2, limit=np.pi)
    options = {"max_iterations": limit, "position_tolerance": tolerance, "orientation_tolerance": tolerance}
    options |= {"q0": np.full(7, 0.3), "restarts": 30}
    targets = poses(robot, rng, 41)
    found, begins_in_single = solved(monkeypatch, robot, "pose", targets, **options)
    build = lane_search.source
    monkeypatch.setattr(lane_search, "source", lambda *of_step, single=False, **_: build(*of_step, single=single))
    expected, _ = solved(monkeypatch, robot, "pose", targets, **options)
    assert begins_in_single
    assert found.status == expected.status
    for column in ("q", "iterations", "restarts", "escapes"):
        assert np.array_equal(getattr(found, column), getattr(expected, column))
    for column in ("position_error", "orientation_error"):
        assert getattr(found, column) == pytest.approx(getattr(expected, column), abs=1e-13)


@pytest.mark.parametrize("tolerance", [1e-6, 1e-11])
def test_the_times_of_all_targets_are_that_of_the_batch(tolerance, rng):
    """Each moment counts for one target: together they are no longer than the call, which has other work, too."""
    ik = solver(strategy="damped")
    targets = poses(ik.robot, rng, 1500)
    options = {"position_tolerance": tolerance, "orientation_tolerance": tolerance, "restarts": 50, "lanes": True}
    shares = []
    for _ in range(5):  # a machine that is halted meanwhile is not halted five times
        begin = time.perf_counter()
        found = ik.solve_batch(targets, **options)
        shares.append(found.seconds.sum() / (time.perf_counter() - begin))
        assert (found.seconds > 0).all()
    assert min(shares) < 1.2
    assert max(shares) > 0.1


@pytest.mark.parametrize("limit", [5, 9])
def test_no_attempt_has_more_iterations_than_it_may(limit, monkeypatch, rng):
    robot = jtik.Robot.builtin("panda")
    targets = poses(robot, rng, 200)
    found, _ = solved(monkeypatch, robot, "pose", targets, max_iterations=limit, restarts=3)
    first = found.converged & (found.restarts == 0)
    assert first.any()
    assert (found.iterations[first] <= 2 * limit).all()  # of both precisions, where double precision begins anew
    assert np.median(found.iterations[first]) <= limit


@pytest.mark.parametrize("far", [33.0, 1e4, 1e12, 1e200])
def test_large_numbers_are_left_to_double_precision(far, monkeypatch):
    robot = planar(3)
    targets = np.array([[1.5, 1.0], [2.0, 0.5]])
    q0 = np.array([[far, 0.3, 0.4], [0.2, 0.3, 0.4]])
    found, begins_in_single = solved(monkeypatch, robot, "position", targets, q0=q0)
    expected, _ = solved(monkeypatch, robot, "position", targets, single=False, q0=q0)
    assert begins_in_single
    assert found.status == expected.status
    assert np.array_equal(found.q[0], expected.q[0])
    assert np.array_equal(found.restarts, expected.restarts)
    assert found.q[1] == pytest.approx(expected.q[1], abs=1e-5)


@pytest.mark.parametrize("unit", [100.0, 1000.0, 1e4])
def test_a_large_robot_stays_in_double_precision(unit, monkeypatch, rng):
    """In millimetres single precision does not come close to a target, even to one whose numbers are small."""
    robot = jtik.Robot.planar([0.4 * unit, 0.3 * unit, 0.2 * unit, 0.1 * unit])
    targets = rng.uniform(-15, 15, (30, 2))
    found, _ = solved(monkeypatch, robot, "position", targets, q0=np.full(4, 0.3), restarts=100)
    expected, _ = solved(monkeypatch, robot, "position", targets, single=False, q0=np.full(4, 0.3), restarts=100)
    same(found, expected)


def test_a_small_robot_is_found_to_its_tolerances(monkeypatch, rng):
    robot = jtik.Robot.planar([4e-4, 3e-4, 2e-4])
    targets = np.array([robot.position(robot.random_configuration(rng)) for _ in range(20)])
    found, _ = solved(monkeypatch, robot, "position", targets, q0=np.full(3, 0.3), position_tolerance=1e-9)
    assert found.converged.all()
    assert (found.position_error <= 1e-9).all()


@pytest.mark.parametrize("tolerance", [1e-2, 1e-3, 1e-10])
def test_tolerances_of_the_caller_hold(tolerance, monkeypatch, rng):
    robot = jtik.Robot.builtin("panda")
    options = {"position_tolerance": tolerance, "orientation_tolerance": tolerance}
    found, _ = solved(monkeypatch, robot, "pose", poses(robot, rng, 40), **options)
    assert found.converged.all()
    for q, error in zip(found.q, found.position_error, strict=True):
        assert error <= tolerance
        assert (robot.lower <= q).all()
        assert (q <= robot.upper).all()


def test_joints_that_turn_are_brought_back(monkeypatch, rng):
    robot = dh_arm(6, 1, limit=np.pi)
    found, begins_in_single = solved(
        monkeypatch, robot, "pose", poses(robot, rng, 40), q0=np.full(6, 3.0), restarts=100
    )
    assert begins_in_single
    assert found.converged.all()
    assert (np.abs(found.q) <= np.pi).all()


def test_unit_quaternions_stay_in_double_precision(monkeypatch, rng):
    robot = ball_arm()
    targets = poses(robot, rng, 10)
    found, begins_in_single = solved(monkeypatch, robot, "pose", targets, restarts=50)
    assert not begins_in_single
    assert found.converged.all()


def test_a_search_of_many_steps_ends_as_without_lanes(monkeypatch, rng):
    robot = planar(4)
    targets = rng.uniform(-4, 4, (30, 2))
    constants = {"LONGEST": 0}
    found, _ = solved(monkeypatch, robot, "position", targets, constants=constants, q0=np.full(4, 0.3), restarts=3)
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(kind="position"), strategy="damped")
    same(ik.solve_batch(targets, q0=np.full(4, 0.3), restarts=3), found)


def test_a_target_out_of_reach_has_the_status_of_solve(rng):
    ik = solver(strategy="damped")
    targets, q0 = problems(ik, rng, 6)
    targets[::2, 0, 3] += 2.0
    one, lanes = (ik.solve_batch(targets, q0=q0, restarts=5, lanes=each) for each in (False, True))
    assert lanes.status[::2] == one.status[::2]
    assert not lanes.converged[::2].any()
