"""Rotations of a chain as expressions: against SciPy's products, and how few operations they cost."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.spatial.transform import Rotation as Reference

from jtik.robot.rotation import ROUNDING, AxisRotation, Rotation, snapped

from ..conftest import EXACT

ANGLE = casadi.SX.sym("angle", 3)
X, Y, Z = np.eye(3)


def unit(rng):
    axis = rng.normal(size=3)
    return axis / np.linalg.norm(axis)


def values(expression, angles):
    return casadi.Function("f", [ANGLE], [expression])(angles).full()


def test_a_rotation_about_an_axis_is_scipys(rng):
    for _ in range(10):
        axis, vector, angles = unit(rng), rng.normal(size=3), rng.uniform(-4, 4, 3)
        found = values(AxisRotation.about(axis, ANGLE[0]).apply(vector), angles)
        assert found[:, 0] == pytest.approx(Reference.from_rotvec(angles[0] * axis).apply(vector), abs=EXACT)


def test_a_chain_of_rotations_is_the_product(rng):
    """Constants, symbolic angles and symbolic matrices in any order; axes that are generic, parallel and opposite."""
    for _ in range(30):
        angles, axis = rng.uniform(-3, 3, 3), unit(rng)
        chain, expected = Rotation(), Reference.identity()
        for k in rng.permutation(3):
            constant = Reference.random(random_state=int(rng.integers(1e6)))
            own = [axis, -axis, unit(rng), Z][rng.integers(4)]
            kind = rng.integers(3)
            if kind == 0:
                chain, expected = chain.then_constant(constant.as_matrix()), expected * constant
            if kind <= 1:
                chain = chain.then_rotation(own, ANGLE[int(k)])
                expected = expected * Reference.from_rotvec(angles[k] * own)
            else:
                chain = chain.then_matrix(casadi.SX(constant.as_matrix()))
                expected = expected * constant
        assert values(chain.matrix(), angles) == pytest.approx(expected.as_matrix(), abs=1e-11)
        vector = rng.normal(size=3)
        assert values(chain.apply(vector), angles)[:, 0] == pytest.approx(expected.apply(vector), abs=1e-11)


def test_nothing_is_the_identity():
    assert np.array(casadi.DM(Rotation().matrix())).tolist() == np.eye(3).tolist()
    assert Rotation().then_constant(np.eye(3)).constant is None


@pytest.mark.parametrize("side", [1, -1])
def test_parallel_axes_add_their_angles(side):
    """One sine and one cosine for both joints."""
    chain = Rotation().then_rotation(Z, ANGLE[0]).then_rotation(side * Z, ANGLE[1])
    matrix = casadi.Function("f", [ANGLE], [chain.matrix()], {"cse": True})
    operations = [matrix.instruction_id(k) for k in range(matrix.n_instructions())]
    assert operations.count(casadi.OP_SIN) == operations.count(casadi.OP_COS) == 1
    angle = 0.3 + side * 0.4
    expected = Reference.from_rotvec(angle * Z).as_matrix()
    assert values(chain.matrix(), [0.3, 0.4, 0]) == pytest.approx(expected, abs=EXACT)


def test_a_constant_turns_the_axis_behind_it():
    """A quarter turn about x takes z to -y; a joint about the turned z is one about -y."""
    quarter = Reference.from_rotvec(np.pi / 2 * X).as_matrix()
    chain = Rotation().then_constant(quarter).then_rotation(Z, ANGLE[0])
    assert chain.about.axis.tolist() == (-Y).tolist()
    expected = quarter @ Reference.from_rotvec(0.7 * Z).as_matrix()
    assert values(chain.matrix(), [0.7, 0, 0]) == pytest.approx(expected, abs=EXACT)


def test_rounding_errors_of_unit_entries_are_removed_and_other_numbers_stay():
    given = np.array([1 - ROUNDING / 2, ROUNDING / 2, -1 + ROUNDING / 2, 0.6, 1e-3])
    assert snapped(given).tolist() == [1, 0, -1, 0.6, 1e-3]
