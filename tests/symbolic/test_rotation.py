"""log: the rotation vector of a rotation matrix, correct and differentiable from angle zero to pi."""

from __future__ import annotations

import functools

import casadi
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation as Turn

from jtik.symbolic import rotation

from ..conftest import EXACT

EPS = np.finfo(float).eps
NEAR_PI = 1e-9
"""At pi - 1e-6 the matrix itself, rounded to 1e-16, fixes the axis only to 1e-16 / 1e-6 in the worst direction."""


@functools.cache
def compiled():
    """log R and its derivative along body rotations: d log(R exp(w)) / dw at w = 0."""
    R = casadi.SX.sym("R", 3, 3)
    phi = rotation.log(R)
    generators = [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]]]
    generators.append([[0, -1, 0], [1, 0, 0], [0, 0, 0]])
    turned = casadi.horzcat(*[casadi.vec(R @ casadi.DM(generator)) for generator in generators])
    return casadi.Function("log", [R], [phi, casadi.jacobian(phi, casadi.vec(R)) @ turned])


def log(R):
    return compiled()(R)[0].full()[:, 0]


def derivative(R):
    return compiled()(R)[1].full()


def numeric_derivative(R, step=1e-5):
    """Central differences on the manifold, with scipy's logarithm."""
    columns = []
    for unit in np.eye(3):
        ahead, behind = ((Turn.from_matrix(R) * Turn.from_rotvec(s * step * unit)).as_rotvec() for s in (1, -1))
        columns.append((ahead - behind) / (2 * step))
    return np.array(columns).T


def random_axis(rng):
    axis = rng.standard_normal(3)
    return axis / np.linalg.norm(axis)


def test_agrees_with_scipy_at_random_rotations(rng):
    for rotation_of in Turn.random(300, random_state=3):
        assert log(rotation_of.as_matrix()) == pytest.approx(rotation_of.as_rotvec(), abs=EXACT)


@pytest.mark.parametrize("angle", [1e-2, 1e-4, 1e-6, 1e-8, 1e-12, 1e-15])
def test_small_angles_keep_their_relative_accuracy(angle, rng):
    for _ in range(20):
        vector = angle * random_axis(rng)
        # the matrix holds the vector to the rounding of its unit diagonal at worst, its off-diagonal far better
        assert log(Turn.from_rotvec(vector).as_matrix()) == pytest.approx(vector, rel=1e-9, abs=1e-10 * angle)


@pytest.mark.parametrize("angle", [1e-9, 1e-7, 5e-7, 1e-6, 1.5e-6, 1.99e-6, 2.01e-6, 3e-6, 1e-5])
def test_the_series_at_small_angles_has_the_digits_of_the_matrix(angle, rng):
    """Against Rodrigues' formula, exact to t^4 / 120, below 1e-22; the branch changes at 2e-6."""
    for _ in range(20):
        vector = angle * random_axis(rng)
        x, y, z = vector
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        squared = vector @ vector
        R = np.eye(3) + (1 - squared / 6) * cross + (1 - squared / 12) / 2 * cross @ cross
        assert np.linalg.norm(log(R) - vector) <= 8 * EPS * angle


def test_the_identity_has_no_rotation():
    assert log(np.eye(3)).tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("gap", [1e-1, 1e-3, 1e-6])
def test_close_to_an_angle_of_pi(gap, rng):
    for _ in range(50):
        vector = (np.pi - gap) * random_axis(rng)
        assert log(Turn.from_rotvec(vector).as_matrix()) == pytest.approx(vector, abs=NEAR_PI)


def test_at_pi_it_is_about_the_axis_whose_largest_component_is_positive(rng):
    for _ in range(100):
        axis = random_axis(rng)
        axis *= np.sign(axis[np.argmax(np.abs(axis))])
        assert log(2 * np.outer(axis, axis) - np.eye(3)) == pytest.approx(np.pi * axis, abs=EXACT)


@pytest.mark.parametrize("axis", np.eye(3))
def test_at_pi_about_a_coordinate_axis(axis):
    assert log(2 * np.outer(axis, axis) - np.eye(3)) == pytest.approx(np.pi * axis, abs=EXACT)


@pytest.mark.parametrize("axis", [(1, 1, 0), (1, 0, -1), (1, 1, 1), (-1, 1, 1)])
def test_at_pi_about_a_diagonal_is_correct_up_to_its_sign(axis):
    unit = np.array(axis) / np.linalg.norm(axis)
    found = log(2 * np.outer(unit, unit) - np.eye(3))
    assert np.linalg.norm(found) == pytest.approx(np.pi, abs=EXACT)
    assert abs(found @ unit) == pytest.approx(np.pi, abs=EXACT)


@given(st.lists(st.floats(-1, 1), min_size=3, max_size=3), st.floats(0, np.pi - 1e-3))
def test_log_is_the_inverse_of_the_exponential(direction, angle):
    length = np.linalg.norm(direction)
    if length < 1e-3:
        return
    vector = angle * np.array(direction) / length
    assert log(Turn.from_rotvec(vector).as_matrix()) == pytest.approx(vector, abs=1e-11)


def closed_form_derivative(phi):
    """Inverse right Jacobian of SO(3): I + 1/2 [phi] + (1/t^2 - cot(t/2) / 2t) [phi]^2."""
    t = np.linalg.norm(phi)
    cross = np.array([[0, -phi[2], phi[1]], [phi[2], 0, -phi[0]], [-phi[1], phi[0], 0]])
    return np.eye(3) + cross / 2 + (1 / t**2 - 1 / (2 * t * np.tan(t / 2))) * cross @ cross


@pytest.mark.parametrize("angle", [1e-1, 1.0, 2.0, 3.0, np.pi - 1e-3, np.pi - 1e-6])
def test_derivative_is_the_inverse_right_jacobian(angle, rng):
    for _ in range(20):
        phi = angle * random_axis(rng)
        # what the rounded matrix does to the axis at angles close to pi, NEAR_PI, it does to the derivative
        assert derivative(Turn.from_rotvec(phi).as_matrix()) == pytest.approx(closed_form_derivative(phi), abs=1e-8)


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-8, 1e-7, 1e-6, 2e-6, 1e-4, 1e-2, 0.5, 2.5])
def test_derivative_agrees_with_differences_on_the_manifold(angle, rng):
    for _ in range(10):
        R = Turn.from_rotvec(angle * random_axis(rng)).as_matrix()
        assert derivative(R) == pytest.approx(numeric_derivative(R), abs=1e-9)


def test_derivative_at_the_identity_is_the_identity():
    assert derivative(np.eye(3)) == pytest.approx(np.eye(3), abs=EXACT)


@pytest.mark.parametrize("angle", [0.0, 1e-300, 1e-20, 1e-9, 1e-3, np.pi - 1e-9, np.pi])
def test_value_and_derivative_are_finite_everywhere(angle, rng):
    for axis in (*np.eye(3), *-np.eye(3), *[random_axis(rng) for _ in range(20)]):
        R = Turn.from_rotvec(angle * axis).as_matrix()
        assert np.isfinite(log(R)).all()
        assert np.isfinite(derivative(R)).all()


class TestLogRate:
    """d/dt log R = G w for dR/dt = [w] R."""

    @functools.cached_property
    def rate(self):
        turn = casadi.SX.sym("turn", 3)
        return casadi.Function("rate", [turn], [rotation.log_rate(turn)])

    @pytest.mark.parametrize("angle", [1e-9, 1e-7, 1e-6, 1.1e-6, 1e-3, 0.5, 2.0, 3.1, np.pi - 1e-9])
    def test_is_the_derivative_of_the_logarithm(self, angle, rng):
        """Against the derivative that CasADi finds, itself checked above; body rates w_b = R' w."""
        for _ in range(10):
            vector = angle * random_axis(rng)
            R = Turn.from_rotvec(vector).as_matrix()
            assert self.rate(vector).full() == pytest.approx(derivative(R) @ R.T, abs=1e-7)

    def test_at_the_identity_is_the_identity(self):
        assert np.array_equal(self.rate([0, 0, 0]).full(), np.eye(3))

    def test_is_the_inverse_of_the_left_jacobian(self, rng):
        """Closed form: I + (1 - cos a) / a [u] + (1 - sin a / a) [u]^2."""
        for _ in range(100):
            u, a = random_axis(rng), rng.uniform(0.0, np.pi)
            U = np.array([[0, -u[2], u[1]], [u[2], 0, -u[0]], [-u[1], u[0], 0]])
            left = np.eye(3) + (1 - np.cos(a)) / a * U + (1 - np.sin(a) / a) * U @ U
            assert self.rate(a * u).full() @ left == pytest.approx(np.eye(3), abs=EXACT)
