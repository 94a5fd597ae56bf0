"""Links as segments with a radius, against sampled points."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.problems.bodies import Bodies, Links

from ..conftest import planar, planar_points


def test_segments_of_a_planar_arm_are_its_links():
    q = np.array([0.3, -0.5, 1.1])
    links = Bodies(planar(3), shapes=False).at(q)
    joints = np.vstack([[0, 0], planar_points(q)])
    np.testing.assert_allclose(links.start, joints[:-1], atol=1e-12)
    np.testing.assert_allclose(links.end, joints[1:], atol=1e-12)
    assert links.radius.tolist() == [0, 0, 0]


def test_the_distance_is_that_to_the_nearest_surface():
    links = Links(np.array([[0.0, 0.0], [5.0, 0.0]]), np.array([[1.0, 0.0], [5.0, 2.0]]), np.array([0.1, 0.5]))
    for point, distance in (((0.5, 1.0), 0.9), ((-3.0, 4.0), 4.9), ((4.0, 1.0), 0.5), ((5.0, 1.0), -0.5)):
        assert links.distance(np.array(point)) == pytest.approx(distance)


def test_random_points_lie_on_the_links():
    links, generator = Bodies(planar(3), shapes=False).at(np.array([0.3, -0.5, 1.1])), np.random.default_rng(0)
    assert max(abs(links.distance(links.point(generator))) for _ in range(50)) < 1e-12


def test_a_robot_without_solids_is_refused():
    with pytest.raises(jtik.ArgumentError, match="shapes"):
        Bodies(planar(3), shapes=True)
