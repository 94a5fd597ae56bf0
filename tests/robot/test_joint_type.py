"""Quaternions and joint types, against SciPy and against derivatives known in closed form."""

from __future__ import annotations

import pickle

import casadi
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jtik.robot import JointType, quaternion
from jtik.symbolic import function, symbol

ROUNDING = 1e-14
ANGLES = [0.0, 1e-300, 1e-12, 1e-6, 1e-3, 0.499, 0.501, 1.0, 3.0, 3.1415, 5.0]
DIRECTION = np.array([2.0, -1.0, 2.0]) / 3.0


def compiled(formula, *sizes):
    inputs = [symbol(f"x{i}", size) for i, size in enumerate(sizes)]
    return function("f", inputs, [formula(*inputs)])


def scalar_first(rotation):
    return np.roll(rotation.as_quat(), 1)


@pytest.mark.parametrize("angle", ANGLES)
def test_exponential_is_the_quaternion_of_the_rotation_vector(angle):
    given = compiled(quaternion.exponential, 3)(angle * DIRECTION).full().ravel()
    expected = np.concatenate([[np.cos(angle / 2)], np.sin(angle / 2) * DIRECTION])
    assert given == pytest.approx(expected, abs=ROUNDING)


@pytest.mark.parametrize("angle", ANGLES[:-1])
@pytest.mark.parametrize("sign", [1, -1])
def test_logarithm_inverts_the_exponential_for_either_sign_of_the_quaternion(angle, sign):
    q = compiled(quaternion.exponential, 3)(angle * DIRECTION)
    back = compiled(quaternion.logarithm, 4)(sign * q).full().ravel()
    assert back == pytest.approx(angle * DIRECTION, abs=ROUNDING)


def test_logarithm_is_the_shortest_rotation():
    q = compiled(quaternion.exponential, 3)(5.0 * DIRECTION)
    back = compiled(quaternion.logarithm, 4)(q).full().ravel()
    assert back == pytest.approx((5.0 - 2 * np.pi) * DIRECTION, abs=ROUNDING)


def test_a_rotation_by_pi_has_a_logarithm_of_norm_pi():
    back = compiled(quaternion.logarithm, 4)([0, 0, 1, 0]).full().ravel()
    assert back == pytest.approx([0, np.pi, 0], abs=ROUNDING)


def test_exponential_has_the_right_first_and_second_derivatives_at_zero():
    omega = symbol("omega", 3)
    q = quaternion.exponential(omega)
    first = function("f", [omega], [casadi.jacobian(q, omega)])(np.zeros(3)).full()
    assert first == pytest.approx(np.vstack([np.zeros(3), np.eye(3) / 2]), abs=0)
    for row, expected in enumerate([-np.eye(3) / 4, *[np.zeros((3, 3))] * 3]):
        second = function("h", [omega], [casadi.hessian(q[row], omega)[0]])(np.zeros(3)).full()
        assert second == pytest.approx(expected, abs=0)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.3, 2.0])
def test_derivative_of_the_logarithm_inverts_that_of_the_exponential(angle):
    omega, q = symbol("omega", 3), symbol("q", 4)
    d_exp = function("f", [omega], [casadi.jacobian(quaternion.exponential(omega), omega)])
    d_log = function("f", [q], [casadi.jacobian(quaternion.logarithm(q), q)])
    at = angle * DIRECTION
    here = compiled(quaternion.exponential, 3)(at)
    assert (d_log(here) @ d_exp(at)).full() == pytest.approx(np.eye(3), abs=1e-13)


def test_rotation_matrix_agrees_with_scipy_for_any_multiple():
    for seed in range(5):
        rotation = Rotation.random(random_state=seed)
        for scale in (1.0, -1.0, 0.01, 30.0):
            R = compiled(quaternion.rotation_matrix, 4)(scale * scalar_first(rotation)).full()
            assert pytest.approx(rotation.as_matrix(), abs=ROUNDING) == R


def test_integrate_rotates_in_the_body_frame_and_renormalises():
    start, step = Rotation.random(random_state=1), np.array([0.4, -1.2, 2.0])
    result = compiled(quaternion.integrate, 4, 3)(1.001 * scalar_first(start), step).full().ravel()
    expected = scalar_first(start * Rotation.from_rotvec(step))
    assert abs(result @ expected) == pytest.approx(1.0, abs=ROUNDING)
    assert np.linalg.norm(result) == pytest.approx(1.0, abs=ROUNDING)


def test_tangent_is_the_derivative_of_integrate():
    q, omega = symbol("q", 4), symbol("omega", 3)
    derivative = casadi.jacobian(quaternion.integrate(q, omega), omega)
    both = function("f", [q, omega], [derivative, quaternion.tangent(q)])
    for seed in range(3):
        d, t = both(scalar_first(Rotation.random(random_state=seed)), np.zeros(3))
        assert d.full() == pytest.approx(t.full(), abs=ROUNDING)


@pytest.mark.parametrize(
    ("kind", "nq", "nv", "rotational"),
    [
        (JointType.FIXED, 0, 0, ()),
        (JointType.REVOLUTE, 1, 1, (True,)),
        (JointType.PRISMATIC, 1, 1, (False,)),
        (JointType.BALL, 4, 3, (True,) * 3),
        (JointType.FREE, 7, 6, (False,) * 3 + (True,) * 3),
    ],
)
def test_sizes_and_units_of_each_type(kind, nq, nv, rotational):
    assert (kind.nq, kind.nv, kind.rotational) == (nq, nv, rotational)
    assert kind.neutral.shape == (nq,)
    assert kind.tangent(symbol("q", nq)).shape == (nq, nv)


def test_values_are_the_standard_terms():
    assert [kind.value for kind in JointType] == ["fixed", "revolute", "prismatic", "ball", "free"]


@pytest.mark.parametrize(("word", "kind"), [("hinge", JointType.REVOLUTE), ("slide", JointType.PRISMATIC)])
def test_mujocos_words_and_earlier_files_resolve_without_a_warning(word, kind):
    assert JointType(word) is kind


@pytest.mark.parametrize(("old", "new"), [("HINGE", "REVOLUTE"), ("SLIDE", "PRISMATIC")])
def test_old_members_are_aliases_that_name_the_new_one(old, new):
    with pytest.warns(DeprecationWarning, match=f"^JointType.{old} is now JointType.{new}$"):
        assert getattr(JointType, old) is JointType[new]
    with pytest.warns(DeprecationWarning, match=f"^JointType.{old} is now JointType.{new}$"):
        assert JointType[old] is JointType[new]


def test_a_member_that_does_not_exist_is_refused_with_the_members():
    with pytest.raises(AttributeError, match="JointType has no member 'SCREW'; members: FIXED, REVOLUTE, PRISMATIC"):
        JointType.SCREW  # noqa: B018
    with pytest.raises(ValueError, match="'screw' is not a valid JointType"):
        JointType("screw")


def test_members_survive_pickling():
    assert all(pickle.loads(pickle.dumps(kind)) is kind for kind in JointType)
