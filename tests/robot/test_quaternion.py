"""Algebra of quaternions, against SciPy; `test_joint_type` has the exponential and the logarithm near their limits."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jtik.robot import quaternion

from ..conftest import EXACT


def random_quaternion(rng):
    q = rng.normal(size=4)
    return q / np.linalg.norm(q)


def reference(q):
    return Rotation.from_quat(np.roll(q, -1))


def values(expression):
    value = np.array(casadi.DM(expression))
    return value[:, 0] if value.shape[1] == 1 else value


def test_products_and_conjugates_are_those_of_rotations(rng):
    for _ in range(10):
        a, b = random_quaternion(rng), random_quaternion(rng)
        product = values(quaternion.product(casadi.SX(a), casadi.SX(b)))
        expected = (reference(a) * reference(b)).as_matrix()
        assert reference(product).as_matrix() == pytest.approx(expected, abs=EXACT)
        inverse = values(quaternion.product(casadi.SX(a), quaternion.conjugate(casadi.SX(a))))
        assert inverse == pytest.approx([1, 0, 0, 0], abs=EXACT)


def test_the_product_is_not_commutative():
    i, j = casadi.SX([0, 1, 0, 0]), casadi.SX([0, 0, 1, 0])
    assert values(quaternion.product(i, j)).tolist() == [0, 0, 0, 1]
    assert values(quaternion.product(j, i)).tolist() == [0, 0, 0, -1]


def test_integrate_and_difference_are_each_others_inverse(rng):
    for _ in range(10):
        q, omega = random_quaternion(rng), rng.uniform(-1.5, 1.5, 3)
        after = quaternion.integrate(casadi.SX(q), casadi.SX(omega))
        assert np.linalg.norm(values(after)) == pytest.approx(1, abs=EXACT)
        expected = (reference(q) * Rotation.from_rotvec(omega)).as_matrix()
        assert reference(values(after)).as_matrix() == pytest.approx(expected, abs=EXACT)
        assert values(quaternion.difference(casadi.SX(q), after)) == pytest.approx(omega, abs=1e-10)


def test_the_difference_does_not_depend_on_the_sign_of_a_quaternion(rng):
    a, b = random_quaternion(rng), random_quaternion(rng)
    same, other = (values(quaternion.difference(casadi.SX(a), casadi.SX(s * b))) for s in (1, -1))
    assert same == pytest.approx(other, abs=EXACT)
    assert np.linalg.norm(same) <= np.pi
