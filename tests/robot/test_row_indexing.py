"""Rows of a Jacobian, of numbers and of symbols alike: what J[:3] means, and the keyword ``rows``."""

from __future__ import annotations

import copy

import casadi
import numpy as np
import pytest

import jtik
from jtik.errors import ArgumentError
from jtik.robot import Robot

from .conftest import make_arm

ARM = make_arm()
Q = np.array([0.3, -0.4, 0.5, 0.2, 0.7, -0.1])
J = ARM.jacobian(Q)
INDICES = {
    "[:3]": lambda A: A[:3],
    "[3:]": lambda A: A[3:],
    "[-2:]": lambda A: A[-2:],
    "[::2]": lambda A: A[::2],
    "[0]": lambda A: A[0],
    "[-1]": lambda A: A[-1],
    "[numpy.int64]": lambda A: A[np.int64(2)],
    "[[0, 2]]": lambda A: A[[0, 2]],
    "[array]": lambda A: A[np.array([5, 1])],
    "[range]": lambda A: A[range(2, 4)],
    "[:3][0]": lambda A: A[:3][0],
    "[:3][:2]": lambda A: A[:3][:2],
    "[0][2]": lambda A: A[0][2],
    "[0][:3]": lambda A: A[0][:3],
    "[1, 2]": lambda A: A[1, 2],
    "[:3, :]": lambda A: A[:3, :],
    "[:3, :][0]": lambda A: A[:3, :][0],
    "[:, 1]": lambda A: A[:, 1],
    "[:, 1][3]": lambda A: A[:, 1][3],
    "[[0, 1], :]": lambda A: A[[0, 1], :],
    ".T[:2]": lambda A: A.T[:2],
    ".T[0]": lambda A: A.T[0],
    "[:3].T": lambda A: A[:3].T,
    "[:3] @ v": lambda A: A[:3] @ np.arange(6.0),
    "A @ A.T": lambda A: A @ A.T,
    "2 * A - A": lambda A: 2 * A - A,
    "(2 * A)[:3]": lambda A: (2 * A)[:3],
    "(A + A)[0]": lambda A: (A + A)[0],
    "(A - 1)[0]": lambda A: (A - 1)[0],
    "(1 - A)[0]": lambda A: (1 - A)[0],
    "(-A)[0]": lambda A: (-A)[0],
    "(+A)[:2]": lambda A: (+A)[:2],
    "abs(A)[0]": lambda A: abs(A)[0],
    "(A / 2)[0]": lambda A: (A / 2)[0],
    "(A**2)[0]": lambda A: (A**2)[0],
    "(A[:3] * 2)[0]": lambda A: (A[:3] * 2)[0],
    "(A[:1] * 2)[0]": lambda A: (A[:1] * 2)[0],
    "(2 * A[0])[1]": lambda A: (2 * A[0])[1],
    "(A @ A.T)[:2]": lambda A: (A @ A.T)[:2],
    "(W @ A)[:2]": lambda A: (np.diag(np.arange(6.0)) @ A)[:2],
    "(w * A)[1]": lambda A: (np.arange(6.0)[:, None] * A)[1],
    "(A @ v)[2]": lambda A: (A @ np.arange(6.0))[2],
    "numpy.sin(A)[0]": lambda A: np.sin(A)[0],
    "numpy.abs(A)[0]": lambda A: np.abs(A)[0],
    "numpy.vstack([A, A])[7]": lambda A: np.vstack([A, A])[7],
    "numpy.transpose(A)[1]": lambda A: np.transpose(A)[1],
    "A.reshape((4, 9))[1]": lambda A: A.reshape((4, 9))[1],
}


def at_numbers(build, kind):
    """The value at Q of what ``build`` makes of a symbolic q."""
    q = kind.sym("q", 6)
    return casadi.densify(casadi.Function("f", [q], [build(q)])(Q)).full()


@pytest.mark.thinned
@pytest.mark.filterwarnings("ignore:\\s*casadi. a numpy function:FutureWarning")
@pytest.mark.parametrize("kind", [casadi.SX, casadi.MX])
@pytest.mark.parametrize("index", INDICES)
def test_an_index_selects_the_same_entries_of_symbols_and_of_numbers(index, kind):
    take = INDICES[index]
    expected = np.array(take(J))
    found = at_numbers(lambda q: take(ARM.jacobian(q)), kind)
    assert found.size == expected.size
    assert found.reshape(expected.shape) == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize("take", [lambda A: A[:3], lambda A: A[0], lambda A: A[1:, 0]])
def test_poses_and_rotations_are_read_by_rows_too(take):
    found = at_numbers(lambda q: take(ARM.pose(q)), casadi.SX)
    assert found.ravel() == pytest.approx(take(ARM.pose(Q)).ravel(), abs=1e-14)
    found = at_numbers(lambda q: take(ARM.at(q).rotation()), casadi.SX)
    assert found.ravel() == pytest.approx(take(ARM.pose(Q)[:3, :3]).ravel(), abs=1e-14)
    found = at_numbers(lambda q: take(ARM.at(q).jacobian()), casadi.SX)
    assert found.ravel() == pytest.approx(take(J).ravel(), abs=1e-14)


@pytest.mark.parametrize("index", ["x", 1.5, None, ..., True, (0, 1, 2), [0.5], [[0], [1]], slice])
def test_an_index_that_selects_no_rows_is_refused(index):
    q = casadi.SX.sym("q", 6)
    with pytest.raises(ArgumentError, match="^index: given"):
        ARM.jacobian(q)[index]


def test_the_message_says_what_selects_rows():
    accepted = r"rows such as J\[:3\], J\[0\] or J\[\[0, 2\]\], or rows and columns such as J\[:3, 0\]"
    with pytest.raises(ArgumentError, match=f"^index: given None; accepted: {accepted}$"):
        ARM.jacobian(casadi.SX.sym("q", 6))[None]


class TestInCasadi:
    """The result is a CasADi matrix like any other."""

    def test_operations(self):
        q = casadi.SX.sym("q", 6)
        A = ARM.jacobian(q)
        assert isinstance(A, casadi.SX)
        outputs = [
            casadi.mtimes(A, q),
            casadi.horzcat(A, A),
            casadi.vertcat(A, A),
            casadi.sumsqr(A),
            casadi.jacobian(A[:3] @ q, q),
            casadi.substitute(A, q, 2 * q),
            casadi.vec(A),
            casadi.reshape(A, 3, 12),
            np.ones((2, 6)) @ A,
            A - np.ones((6, 6)),
            casadi.if_else(q[0] > 0, A, 0),
            copy.copy(A),
            copy.deepcopy(A),
        ]
        values = [value.full() for value in casadi.Function("f", [q], outputs)(Q)]
        assert values[0].ravel() == pytest.approx(J @ Q)
        assert values[1] == pytest.approx(np.hstack([J, J]))
        assert values[2] == pytest.approx(np.vstack([J, J]))
        assert values[3].item() == pytest.approx((J**2).sum())
        assert values[5] == pytest.approx(ARM.jacobian(2 * Q))
        assert values[6].ravel() == pytest.approx(J.ravel(order="F"))
        assert values[8] == pytest.approx(np.ones((2, 6)) @ J)
        for value in (values[10], values[11], values[12]):
            assert value == pytest.approx(J)

    def test_a_call_with_it(self):
        q, A = casadi.MX.sym("q", 6), casadi.MX.sym("A", 6, 6)
        trace = casadi.Function("trace", [A], [casadi.trace(A)])
        found = casadi.Function("f", [q], [trace(ARM.jacobian(q))])
        assert float(found(Q)) == pytest.approx(np.trace(J))

    def test_the_engines_matrix_is_a_casadi_matrix(self):
        kinematics = ARM.at(casadi.SX.sym("q", 6))
        assert type(kinematics.plain_jacobian()) is casadi.SX
        assert kinematics.plain_jacobian()[:3].shape == (3, 1)


class TestRows:
    def test_numbers(self):
        assert ARM.jacobian(Q, rows="linear").tolist() == J[:3].tolist()
        assert ARM.jacobian(Q, rows="angular").tolist() == J[3:].tolist()
        assert ARM.jacobian(Q, "link3", rows=None).tolist() == ARM.jacobian(Q, "link3").tolist()

    @pytest.mark.parametrize("kind", [casadi.SX, casadi.MX])
    def test_symbols(self, kind):
        for rows, expected in (("linear", J[:3]), ("angular", J[3:])):
            assert at_numbers(lambda q, r=rows: ARM.jacobian(q, rows=r), kind) == pytest.approx(expected, abs=1e-14)
        found = at_numbers(lambda q: ARM.at(q).jacobian("link3", rows="linear"), casadi.SX)
        assert found == pytest.approx(ARM.jacobian(Q, "link3")[:3], abs=1e-14)

    def test_on_a_planar_robot_they_are_those_of_its_position_and_its_angle(self):
        arm, q = Robot.planar(3), [0.1, 0.2, 0.3]
        assert arm.jacobian(q, rows="linear").tolist() == arm.jacobian(q)[:2].tolist()
        assert arm.jacobian(q, rows="angular").tolist() == [[1.0, 1.0, 1.0]]
        assert arm.jacobian(casadi.SX.sym("q", 3), rows="linear").shape == (2, 3)

    @pytest.mark.parametrize("q", [Q, casadi.SX.sym("q", 6)])
    def test_anything_else_is_refused(self, q):
        with pytest.raises(
            ArgumentError, match="^rows: given position; accepted: 'linear', 'angular', or None for all six$"
        ):
            ARM.jacobian(q, rows="position")


@pytest.mark.parametrize(
    "use",
    [lambda A: np.linalg.norm(A[0], 1), lambda A: np.linalg.norm(A[0], ord=np.inf), np.any, lambda A: np.all(A > 0)],
)
def test_what_casadi_would_answer_otherwise_than_numpy_is_refused(use):
    @jtik.criterion
    def value(q, robot):
        return use(robot.jacobian(q))

    with pytest.raises(jtik.CriterionError, match="give it the column x.T|has no symbolic form"):
        value(Q, ARM)


def test_a_row_that_does_not_exist_names_the_users_line():
    @jtik.criterion
    def value(q, robot):
        return casadi.sumsqr(robot.jacobian(q)[6])

    with pytest.raises(jtik.CriterionError, match=r"`return casadi\.sumsqr\(robot\.jacobian\(q\)\[6\]\)` \(line"):
        value(Q, ARM)


def test_a_criterion_reads_rows_of_its_jacobian():
    @jtik.criterion
    def manipulability(q, robot):
        A = robot.jacobian(q)[:2]
        return -casadi.det(A @ A.T)

    arm = Robot.planar(3)
    ik = jtik.InverseKinematics(arm, jtik.FrameTask(), criteria=manipulability(), strategy="hybrid")
    q = np.array([0.3, 0.5, 0.7])
    A = arm.jacobian(q)[:2]
    assert ik.solve(arm.position(q), q0=q, max_iterations=0).cost == pytest.approx(-np.linalg.det(A @ A.T))
