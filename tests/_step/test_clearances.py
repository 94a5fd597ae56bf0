"""The clearance model of a problem: its numbers, the distances after a displacement, and what the state remembers."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik._step.clearances import clearance_model
from jtik_formulations import ObstacleAvoidance

from ..conftest import planar, planar_points
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
    measured = problem.clearance(Q, parameters)
    return clearance_model(problem, casadi.SX(Q), measured, parameters, limits, state)


def test_values_of_each_distance():
    found = model(planar(2))
    assert numbers(found.distance) == pytest.approx(distances(Q))
    assert numbers(found.safe).tolist() == [0.1] * 4
    assert numbers(found.aim) == pytest.approx([0.15] * 4)
    assert numbers(found.curvature_radius) == pytest.approx([0.5, 0.35] * 2)  # of each circle
    assert found.motion.lever_arms() == [2.0, 1.0]


def test_distances_after_a_displacement(rng):
    found = model(planar(2))
    for dq in rng.uniform(-0.5, 0.5, (5, 2)):
        assert numbers(found.after(casadi.SX(dq))) == pytest.approx(distances(Q + dq))


def test_a_displacement_ends_at_the_limits():
    found = model(planar(2, lower=-0.5, upper=0.5))
    assert numbers(found.after(casadi.SX([0.3, -0.9]))) == pytest.approx(distances(np.array([0.5, -0.5])))


def test_the_restoration_reads_its_memory_from_the_state():
    found = model(planar(2), {"longest": casadi.SX(0.2), "violation": casadi.SX(0.03)})
    assert (numbers(found.longest), numbers(found.smallest_violation)) == (0.2, 0.03)
    assert (model(planar(2)).longest, model(planar(2)).smallest_violation) == (0, 0)
