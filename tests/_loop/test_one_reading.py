"""What a solve is given is read in one way, whichever path it then takes: q0, options, counts, huge numbers."""

from __future__ import annotations

import warnings

import numpy as np
import pytest

import jtik

from ..conftest import ball_arm, planar
from .conftest import solver

Q0 = np.array([0.3, 0.4, 0.5])
TARGET = np.array([1.0, 1.5])
BOTH = pytest.mark.parametrize("compiled", [False, True], ids=["interpreted", "compiled"])


def used(compiled, robot=None):
    """A solver that has solved once with its default options, which it then knows."""
    ik = solver(planar(3) if robot is None else robot, compiled=compiled)
    if robot is None:
        assert ik.solve(TARGET, q0=Q0).converged
    return ik


@BOTH
@pytest.mark.parametrize("kind", [complex, str, object])
def test_arrays_that_hold_no_numbers_are_refused(compiled, kind):
    with pytest.raises(jtik.ArgumentError, match="q0.*non-numeric"):
        used(compiled).solve(TARGET, q0=Q0.astype(kind))


@BOTH
@pytest.mark.parametrize("kind", [np.float32, ">f8", int])
def test_arrays_of_other_numbers_are_read(compiled, kind):
    solution = used(compiled).solve(TARGET, q0=np.array([1, 0, 1]).astype(kind))
    assert solution.converged


@pytest.mark.quick(1)
@BOTH
def test_quaternions_have_norm_one(compiled):
    robot = ball_arm()
    ik = solver(robot, compiled=compiled)
    q = robot.random_configuration(3)
    target = robot.position(q, "tip")
    assert ik.solve(target, q0=q).converged
    longer = q.copy()
    for at in robot.quaternions.values():
        longer[at] *= 3.0
    solution = ik.solve(target, q0=longer)
    assert solution.converged
    for at in robot.quaternions.values():
        assert np.linalg.norm(solution.q[at]) == pytest.approx(1.0, abs=1e-9)


@BOTH
def test_the_largest_counts(compiled):
    ik = used(compiled)
    expected = ik.solve(TARGET, q0=Q0)
    found = ik.solve(TARGET, q0=Q0, max_iterations=2**63 - 1, restarts=2**63 - 1)
    assert found.converged
    assert found.iterations == expected.iterations > 1


@BOTH
@pytest.mark.parametrize("limit", [2**63, 2**64, 2**64 + 1, 10**30])
def test_counts_that_c_cannot_hold_are_refused(compiled, limit):
    for option in ("max_iterations", "restarts"):
        with pytest.raises(jtik.ArgumentError, match=option):
            used(compiled).solve(TARGET, q0=Q0, **{option: limit})


@BOTH
@pytest.mark.parametrize(
    ("option", "known", "wrong"),
    [
        ("restarts", 1, True),
        ("restarts", 1, 1.0),
        ("restarts", 1, np.array([1])),
        ("restarts", 1, np.array([1, 1])),
        ("max_iterations", 1000, 1000.0),
        ("position_tolerance", 1.0, True),
        ("position_tolerance", 1e-6, np.array([1e-6, 1e-6])),
        ("until", "stationary", np.array(["stationary", "reached"])),
        ("jump_limit", None, np.array([0.1, 0.2])),
    ],
)
def test_options_are_checked_although_they_equal_known_ones(compiled, option, known, wrong):
    ik = used(compiled)
    assert ik.solve(TARGET, q0=Q0, **{option: known}).converged
    with pytest.raises(jtik.ArgumentError) as caught:
        ik.solve(TARGET, q0=Q0, **{option: wrong})
    assert caught.value.argument == option


@pytest.mark.quick(1)
@BOTH
def test_a_start_whose_sum_is_no_number(compiled):
    """Warnings are errors here. Joints with limits are clamped to them as from any other start."""
    robot = planar(3, lower=-2.0, upper=2.0)
    ik = solver(robot, compiled=compiled)
    expected = ik.solve(TARGET, q0=[2.0, -2.0, 2.0])
    for _ in range(2):  # the second with known options
        assert ik.solve(TARGET, q0=np.array([1e308, -1e308, 1e308])).q.tolist() == expected.q.tolist()
    same = ik.solve(TARGET, q0=np.full(3, 1e308))
    assert same.q.tolist() == ik.solve(TARGET, q0=np.full(3, 2.0)).q.tolist()
    free = solver(planar(3), compiled=compiled)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert free.solve(TARGET, q0=np.full(3, 1e308)).status is jtik.Status.NOT_FINITE
