"""Displacements of a step: defaults filled in from the local model, row-space coordinates, shares."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

from jtik.strategy import NullSpaceDisplacement, TaskDisplacement
from jtik.symbolic.factorization import RowSpace

from .conftest import numbers, quadratic_model

J = np.array([[1.0, 2.0, 0.5], [0.0, 1.0, -1.0]])
DQ = np.array([0.3, -0.4, 1.2])


def model(**options):
    return quadratic_model(J, np.ones(2), **options)


class TestTask:
    def test_image_and_length_follow_from_dq_and_the_free_joints(self):
        found = TaskDisplacement(casadi.SX(DQ)).completed(model(active=[1]))
        assert numbers(found.image) == pytest.approx(J[:, [0, 2]] @ DQ[[0, 2]])
        assert numbers(found.length) == pytest.approx(1.3)
        assert np.isnan(found.alpha)

    def test_what_is_given_stays(self):
        given = TaskDisplacement(casadi.SX(DQ), casadi.SX([8.0, 9.0]), casadi.SX(7.0), 0.5)
        found = given.completed(model())
        assert (numbers(found.image).tolist(), numbers(found.length), found.alpha) == ([8.0, 9.0], 7.0, 0.5)

    def test_along_a_row_vector_all_fields_agree_with_dq(self):
        row = RowSpace(casadi.SX(J)).least_squares(casadi.SX([1.0, 2.0]))
        found = TaskDisplacement.along(row, 0.25)
        dq = np.linalg.pinv(J) @ [1.0, 2.0]
        assert numbers(found.dq) == pytest.approx(dq)
        assert numbers(found.image) == pytest.approx([1.0, 2.0])
        assert numbers(found.length) == pytest.approx(np.linalg.norm(dq))
        assert (found.alpha, found.row_vector) == (0.25, row)


class TestNullSpace:
    def test_length_and_decrease_follow_from_dq_and_the_gradient_of_all_joints(self):
        gradient = np.array([1.0, -2.0, 3.0])
        found = NullSpaceDisplacement(casadi.SX(DQ)).completed(model(gradient=gradient, active=[1]))
        assert numbers(found.length) == pytest.approx(1.3)
        assert numbers(found.decrease) == pytest.approx(-gradient @ DQ)

    def test_what_is_given_stays(self):
        found = NullSpaceDisplacement(casadi.SX(DQ), casadi.SX(7.0), casadi.SX(8.0)).completed(model())
        assert (numbers(found.length), numbers(found.decrease)) == (7.0, 8.0)

    def test_none_is_zero_in_every_field(self):
        found = NullSpaceDisplacement.none(3).completed(model())
        assert numbers(found.dq).tolist() == [0, 0, 0]
        assert (found.length, found.decrease, found.beta) == (0, 0, 0)

    def test_a_share_scales_what_is_linear_in_dq(self):
        given = NullSpaceDisplacement(casadi.SX(DQ), 2.0, 3.0, beta=4.0, stationarity_residual=5.0, figures={"a": 6.0})
        found = given.scaled(0.5)
        assert numbers(found.dq) == pytest.approx(0.5 * DQ)
        assert (found.length, found.decrease, found.beta) == (1.0, 1.5, 2.0)
        assert (found.stationarity_residual, found.figures) == (5.0, {"a": 6.0})
