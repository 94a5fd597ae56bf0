"""The clearance model of a problem: its numbers, the violation after a displacement, and what the state remembers."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.clearances import clearance_model
from jtik_formulations import ObstacleAvoidance

from ..conftest import EXACT, planar, planar_points
from .conftest import numbers, problem_of

Q = np.array([0.4, -0.3])
CENTERS, RADII = np.array([[2.0, 1.0], [1.0, -1.0]]), np.array([0.4, 0.25])


def distances(q):
    """Of both link ends to both circles, in closed form."""
    return (np.linalg.norm(planar_points(q)[:, None] - CENTERS, axis=2) - RADII).ravel()


def model(robot, state=None):
    circles = [jtik.Circle(center, radius) for center, radius in zip(CENTERS, RADII, strict=True)]
    problem = problem_of(robot, clearances=[jtik.Clearance(ObstacleAvoidance(circles), safe=0.1, margin=0.05)])
    parameters = casadi.SX(problem.terms.parameters.memory)
    limits = casadi.SX(robot.lower), casadi.SX(robot.upper)
    measured = problem.measured.clearance(Q, parameters)
    return clearance_model(problem, casadi.SX(Q), measured, parameters, limits, state)


def test_values_of_each_distance():
    found = model(planar(2))
    assert numbers(found.distance) == pytest.approx(distances(Q))
    assert numbers(found.safe).tolist() == [0.1] * 4
    assert numbers(found.aim) == pytest.approx([0.15] * 4)
    assert numbers(found.curvature_radius) == pytest.approx([0.5, 0.35] * 2)  # of each circle
    assert found.motion.lever_arms() == [2.0, 1.0]


def violation(q):
    """By how much distances are below 0.15, of those that are by more than half of the margin, in closed form."""
    missing = 0.15 - distances(q)
    return missing[missing > 0.025].sum()


def violation_after(found, dq):
    """That of the model after a displacement; it is the result of a call, which is no constant expression."""
    return float(casadi.Function("after", [], [found.violation_after(casadi.SX(dq))])()["o0"])


def test_the_violation_here_and_after_a_displacement(rng):
    found = model(planar(2))
    assert numbers(found.violation) == pytest.approx(violation(Q))
    steps = rng.uniform(-2, 2, (60, 2))
    after = [violation(Q + dq) for dq in steps]
    assert 0 in after
    assert max(after) > 0
    for dq, expected in zip(steps, after, strict=True):
        assert violation_after(found, dq) == pytest.approx(expected, abs=EXACT)


def test_a_displacement_ends_at_the_limits():
    found = model(planar(2, lower=-1.5, upper=1.5))
    expected = violation(np.array([-1.5, 1.5]))
    assert expected > 0
    assert violation_after(found, [-2.3, 1.9]) == pytest.approx(expected)


def test_the_restoration_reads_its_memory_from_the_state():
    found = model(planar(2), {"longest": casadi.SX(0.2), "violation": casadi.SX(0.03)})
    assert (numbers(found.longest), numbers(found.smallest_violation)) == (0.2, 0.03)
    assert (model(planar(2)).longest, model(planar(2)).smallest_violation) == (0, 0)
