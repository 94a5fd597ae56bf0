"""The smallest distance between samples, against closed forms and against dense sampling."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

import jtik
from jtik.planner.attempts import between
from jtik.planner.attempts.between import Distances, Smallest
from jtik_formulations import ObstacleAvoidance

from ...conftest import EXACT, ball_arm, floating_arm


def test_one_link_that_sweeps_past_a_disc():
    """The tip passes the disc at angle 0, between the only two samples; there the distance is 0.1 m."""
    arm = jtik.Robot.planar(1)
    distances = Distances(arm, ObstacleAvoidance([jtik.Circle((1.2, 0.0), 0.1)], bodies="links"))
    found = distances.smallest(np.array([0.0, 2.0]), np.array([[-0.9], [0.7]]), accuracy=1e-5)
    assert 0.1 - EXACT <= found.distance <= 0.1 + 1e-5
    assert found.bound <= 0.1 + EXACT
    assert found.distance - found.bound <= 1e-5
    assert found.time == pytest.approx(2 * 0.9 / 1.6, abs=0.02)
    assert found.body == distances._bodies[0]


def test_a_disc_that_both_samples_miss_is_hit_between_them():
    arm = jtik.Robot.planar(1)
    discs = [jtik.Circle((3.0, 0.0), 0.5), jtik.Circle((0.5, 0.0), 0.05)]
    found = Distances(arm, ObstacleAvoidance(discs, bodies="links")).smallest(
        np.array([0.0, 1.0]), np.array([[-1.0], [1.0]])
    )
    assert found.distance == pytest.approx(-0.05, abs=1e-3)
    assert found.obstacle == 1


ARMS = {"planar": lambda: jtik.Robot.planar(4), "ball": ball_arm, "floating": floating_arm}


def obstacles(d, rng):
    """One of every shape of that dimension."""
    place, size = rng.normal(size=(6, d)), rng.uniform(0.05, 0.3, 6)
    turned = rng.normal() if d == 2 else rng.normal(size=4)
    found = [
        (jtik.Circle if d == 2 else jtik.Sphere)(place[0], size[0]),
        jtik.Capsule(place[1], place[2], size[1]),
        jtik.Box.at(place[3], rng.uniform(0.1, 0.5, d), turned if d == 2 else turned / np.linalg.norm(turned)),
        jtik.HalfSpace(place[4] - 3, np.ones(d)),
    ]
    corners = place[5] + size[5] * np.array([[0, 0], [2, 0], [1, 3]])[:, :d] if d == 2 else None
    return [*found, jtik.Polygon(corners) if d == 2 else jtik.Cylinder(place[5], place[0], size[5])]


@pytest.mark.quick(2)
@pytest.mark.parametrize("accuracy", [1e-2, 1e-3])
@pytest.mark.parametrize("kind", ARMS)
def test_random_motions_against_dense_sampling(kind, accuracy, rng):
    robot = ARMS[kind]()
    for _ in range(2):
        measure = ObstacleAvoidance(obstacles(robot.dimension, rng), bodies="both")
        distances = Distances(robot, measure)
        q = np.array([robot.random_configuration(rng) for _ in range(3)])
        found = distances.smallest(np.arange(3.0), q, accuracy=accuracy)
        dense = math.inf
        for start, end in itertools.pairwise(q):
            dq = robot.difference(start, end)
            for share in np.linspace(0, 1, 50):
                values = distances._distances(
                    start, dq, share, *[np.asarray(v) for v in measure.parameters(robot).values()]
                )
                dense = min(dense, float(values[0].min()))
        assert found.bound <= dense + EXACT
        assert found.distance <= dense + accuracy
        assert found.distance - found.bound <= accuracy


def test_parameters_move_the_obstacles_without_another_function():
    arm = jtik.Robot.planar(1)
    distances = Distances(arm, ObstacleAvoidance([jtik.Circle((1.2, 0.0), 0.1)], bodies="joints"))
    other = ObstacleAvoidance([jtik.Circle((2.0, 0.0), 0.4)], bodies="joints").parameters(arm)
    found = distances.smallest(np.array([0.0]), np.array([[0.0]]), parameters=other)
    assert found.distance == found.bound == pytest.approx(0.6, abs=EXACT)


def test_the_smaller_of_two_has_the_smaller_bound():
    a, b = Smallest(1.0, 0.2, 0.0, "a"), Smallest(0.5, 0.4, 0.0, "b")
    assert a.smaller(b) == b.smaller(a) == Smallest(0.5, 0.2, 0.0, "b")
    assert Smallest().smaller(a) == a


def test_the_bound_holds_where_the_search_ends_early(monkeypatch):
    """Of the way past the disc only three points are looked at: the bound is loose, and still right."""
    monkeypatch.setattr(between, "MOST_HALVINGS", 3)
    distances = Distances(jtik.Robot.planar(1), ObstacleAvoidance([jtik.Circle((1.2, 0.0), 0.1)], bodies="links"))
    found = distances.smallest(np.array([0.0, 1.0]), np.array([[-0.9], [0.7]]), accuracy=1e-6)
    assert found.bound <= 0.1 < found.distance
    assert found.distance - found.bound > 1e-3
