"""Error messages for what cannot be traced, and the NumPy functions that can."""

from __future__ import annotations

import math

import casadi
import numpy as np
import pytest

import jtik
from jtik.symbolic import solve_ldl
from jtik.symbolic.factorization import RowSpace
from jtik.symbolic.svd import SingularValues

from ..conftest import planar
from .shared import solver


class TestMessages:
    """Each names the criterion and shows the operation that cannot be traced."""

    def refused(self, function, *words):
        with pytest.raises(jtik.CriterionError) as caught:
            solver(planar(3), jtik.criterion(function))
        error = caught.value
        assert error.criterion == function.__name__
        for word in (repr(function.__name__), *words):
            assert word in str(error)
        return error

    def test_a_vector(self):
        def spread(q, robot):
            return q

        self.refused(spread, "(3, 1)", "scalar")

    def test_a_list(self):
        def pair(q, robot):
            return [q[0], q[1]]

        self.refused(pair, "scalar")

    def test_nothing(self):
        def forgotten(q, robot):
            q[0] ** 2

        self.refused(forgotten, "return", "NoneType")

    def test_the_math_module(self):
        def mathematical(q, robot):
            a = q[1] ** 2
            return a + math.sin(q[0])

        self.refused(mathematical, "math.sin(q[0])", "numpy.sin", "line")

    def test_a_comparison(self):
        def branching(q, robot):
            if q[0] > 0:
                return q[0]
            return -q[0]

        self.refused(branching, "if q[0] > 0", "if_else")

    def test_a_function_of_ones_own_with_the_name_of_a_numpy_function(self):
        class Tools:
            norm = staticmethod(abs)

        def lookalike(q, robot):
            return Tools.norm(math.sin(q[0]))

        assert "In place of" not in str(self.refused(lookalike, "Tools.norm", "in place of math functions"))

    def test_an_array_of_objects(self):
        def objects(q, robot):
            return np.linalg.det(np.array([[q[0], q[1]], [q[1], q[2]]]))

        self.refused(
            objects,
            "In place of NumPy's det use casadi.det(A)",
            "Make matrices of expressions with stack(rows) (from jtik.symbolic import stack)",
        )

    def test_a_call_into_float(self):
        def floated(q, robot):
            return float(q[0]) ** 2

        self.refused(floated, "float(q[0])")

    def test_an_index_out_of_range(self):
        def beyond(q, robot):
            return q[7] ** 2

        self.refused(beyond, "q[7]")

    def test_a_foreign_symbol(self):
        other = casadi.SX.sym("wind")

        def blown(q, robot):
            return q[0] ** 2 + other

        self.refused(blown, "wind", "not its own")

    def test_a_foreign_symbol_with_a_familiar_name(self):
        """Another symbol with the name of q is not q."""
        impostor = casadi.SX.sym("q", 3)

        def confused(q, robot):
            return casadi.sumsqr(impostor)

        self.refused(confused, "not its own")

    @pytest.mark.parametrize(
        ("given", "message"),
        [
            ("1.5", "must return one scalar expression, not str '1.5'"),
            (None, "not NoneType"),
            (1j, "not complex 1j"),
            (np.complex128(2.0), "not complex128"),
            (True, "not bool True"),
            ([1.0, 2.0], r"not shape (2,)"),
            (np.ones(3), r"not shape (3,)"),
            (casadi.SX.ones(2), r"not shape (2, 1); sum it, take its norm, or declare"),
            (casadi.SX.ones(2), "@jtik.criterion(residual=True)"),
        ],
    )
    def test_what_is_no_scalar(self, given, message):
        self.refused(lambda q, robot: given, message)

    @pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
    def test_a_value_that_is_not_finite_is_refused_with_the_configuration(self, value):
        self.refused(lambda q, robot: value, f"is {value} at q = [0., 0., 0.]; expected a finite number")

    def test_a_value_that_is_finite_at_home_only(self):
        def lonely(q, robot):
            return np.sqrt(-casadi.sumsqr(q))

        self.refused(lonely, "is nan at q = [ 0.86", "and not finite at 3 more random configurations")

    def test_a_value_that_is_not_finite_at_home(self):
        def inverse(q, robot):
            return 1 / q[0] ** 2

        self.refused(inverse, "is inf at q = [0., 0., 0.]; expected a finite number")

    def test_an_unknown_frame_keeps_its_own_error(self):
        @jtik.criterion
        def lost(q, robot):
            return robot.position(q, "hand")[0]

        with pytest.raises(jtik.UnknownNameError, match="hand"):
            solver(planar(3), lost)

    def test_nothing_is_printed(self, capsys):
        def mathematical(q, robot):
            return math.sin(q[0])

        self.refused(mathematical)
        assert capsys.readouterr() == ("", "")


SVD = "from jtik.symbolic.svd import SingularValues"
ROWS = "from jtik.symbolic.factorization import RowSpace"


def matrix(robot, q):
    """The rows of the Jacobian for x, y and the rotation about z of a planar arm, (3, n)."""
    return robot.jacobian(q)[[0, 1, 5], :]


def of_matrix(function):
    """A criterion that is a function of that matrix."""
    return jtik.criterion(lambda q, robot: function(matrix(robot, q)))


class TestNumpyLinearAlgebra:
    """Each function of numpy.linalg works on expressions, or the error names what does."""

    @pytest.mark.parametrize(
        ("name", "of", "replacement"),
        [
            ("svd", lambda J: np.linalg.svd(J), f"SingularValues(J).values ({SVD})"),
            ("svdvals", lambda J: np.linalg.svdvals(J), f"SingularValues(J).values ({SVD})"),
            ("eigvalsh", lambda J: np.linalg.eigvalsh(J @ J.T), "SingularValues(J).squared, the eigenvalues of J J'"),
            ("eigh", lambda J: np.linalg.eigh(J @ J.T), "SingularValues(J).squared, the eigenvalues of J J'"),
            ("eigvals", lambda J: np.linalg.eigvals(J @ J.T), "SingularValues(J).squared, the eigenvalues of J J'"),
            ("eig", lambda J: np.linalg.eig(J @ J.T), "SingularValues(J).squared, the eigenvalues of J J'"),
            ("cond", lambda J: np.linalg.cond(J), f"the first of SingularValues(J).values divided by the last ({SVD})"),
            ("matrix_rank", lambda J: np.linalg.matrix_rank(J), f"RowSpace(J).rank ({ROWS})"),
        ],
    )
    def test_what_cannot_be_traced_names_its_replacement(self, name, of, replacement):
        def criterion(q, robot):
            return of(matrix(robot, q))

        with pytest.raises(jtik.CriterionError) as caught:
            solver(planar(4), jtik.criterion(criterion))
        text = str(caught.value)
        assert f"np.linalg.{name}(J" in text
        assert f"In place of NumPy's {name} use {replacement}" in text

    @pytest.mark.parametrize(
        "of",
        [
            lambda J: np.linalg.norm(J),
            lambda J: np.linalg.norm(J[:, 1]),
            lambda J: np.linalg.norm(J[:, 1], 1),
            lambda J: np.linalg.det(J @ J.T),
            lambda J: np.linalg.slogdet(J @ J.T)[1],
            lambda J: np.linalg.inv(J @ J.T)[0, 1],
            lambda J: np.linalg.pinv(J)[2, 1],
            lambda J: np.linalg.solve(J @ J.T, J[:, 0])[1],
            lambda J: np.linalg.lstsq(J, J[:, 0] + 1)[0][1],
            lambda J: np.linalg.lstsq(J.T, J[0, :].T + 1)[0][1],
        ],
    )
    def test_what_works_has_the_value_of_numpy(self, of):
        robot, q = planar(4), np.array([0.3, 0.5, -0.7, 0.4])
        assert of_matrix(of)(q, robot) == pytest.approx(np.squeeze(of(matrix(robot, q))), rel=1e-10)

    def test_the_replacements_have_the_values_of_numpy(self):
        robot, q = planar(4), np.array([0.3, 0.5, -0.7, 0.4])
        J = matrix(robot, q)
        singular = np.linalg.svd(J)[1]
        for of, expected in (
            (lambda J: sum(SingularValues(J).values), singular.sum()),
            (lambda J: SingularValues(J).squared[2], np.linalg.eigvalsh(J @ J.T)[0]),
            (lambda J: SingularValues(J).values[0] / SingularValues(J).values[-1], np.linalg.cond(J)),
            (lambda J: RowSpace(J).rank, 3),
            (lambda J: RowSpace(J).volume, np.sqrt(np.linalg.det(J @ J.T))),
            (lambda J: RowSpace(J).least_squares(J[:, 0]).vector[1], np.linalg.lstsq(J, J[:, 0])[0][1]),
            (lambda J: solve_ldl(J @ J.T, J[:, 0])[1], np.linalg.solve(J @ J.T, J[:, 0])[1]),
        ):
            assert of_matrix(of)(q, robot) == pytest.approx(expected, rel=1e-10)

    def test_the_gradient_of_the_norm_is_zero_at_zero(self):
        robot = planar(3)
        length = jtik.criterion(lambda q, robot: np.linalg.norm(q))
        assert length.gradient(np.zeros(3), robot).tolist() == [0, 0, 0]
        assert length.gradient([3.0, 0.0, 4.0], robot) == pytest.approx([0.6, 0, 0.8])

    def test_numpy_is_as_before_once_a_criterion_was_traced(self):
        before = casadi.SX.__array_function__
        jtik.criterion(lambda q, robot: np.linalg.norm(q))(np.ones(3), planar(3))
        assert casadi.SX.__array_function__ is before
        assert math.isnan(float(casadi.SX.sym("x")))
