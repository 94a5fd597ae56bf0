"""Report: what a Solution shows, computed from the numbers of one configuration alone."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from jtik.result.report import Report

TOLERANCES = (1e-6, 1e-6, 1e-6)


def report(**fields):
    """Two task rows, a length and an angle, of three joints; the task fixes the first two."""
    fields_of_a_solution = {
        "error": np.array([3e-7, -4e-7]),
        "jacobian": np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]),
        "linear": np.array([True, False]),
        "residual": np.array([3e-7, -4e-7]),
        "weighted": np.array([[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]),
        "values": {"h": 0.5},
        "gradient": np.array([0.3, 0.4, 0.0]),
        "at_upper": (),
        "at_lower": (),
        "active_limits": (),
        "tolerances": TOLERANCES,
        "rank_threshold": 1e-9,
    }
    return Report(**fields_of_a_solution | fields)


def test_errors_are_norms_of_their_rows():
    assert report().position_error == pytest.approx(3e-7)
    assert report().orientation_error == pytest.approx(4e-7)
    assert report().reached
    assert not report(tolerances=(1e-6, 1e-7, 1e-6)).reached


def test_the_residual_is_the_gradient_that_the_task_leaves():
    assert report().null_space_residual == pytest.approx(0.0, abs=1e-15)
    assert report().stationary
    moved = report(gradient=np.array([0.3, 0.4, 0.5]))
    assert moved.null_space_residual == pytest.approx(0.5)
    assert not moved.stationary


def test_a_limit_holds_what_is_pushed_outward_only():
    outward = report(gradient=np.array([0.0, 0.0, 0.5]), at_lower=(2,))
    inward = report(gradient=np.array([0.0, 0.0, -0.5]), at_lower=(2,))
    assert outward.null_space_residual == 0.0  # descent decreases joint 3, which is at its lower limit
    assert inward.null_space_residual == pytest.approx(0.5)


@pytest.mark.parametrize(("curvature", "kind"), [(1.0, "minimum"), (-1.0, "saddle"), (0.0, "flat")])
def test_the_second_order_follows_from_the_hessian_on_the_null_space(curvature, kind):
    hessian = np.diag([-5.0, -5.0, curvature])  # only the third joint is free of the task
    assert report(curvature=lambda multipliers: hessian).second_order == kind


def test_there_is_no_second_order_off_the_target_or_without_a_criterion():
    assert report().second_order is None
    off = report(error=np.array([1.0, 0.0]), curvature=lambda multipliers: np.eye(3))
    assert off.second_order is None


def test_a_report_that_is_not_finite_is_nan_and_not_stationary():
    broken = report(gradient=np.array([np.nan, 0.0, 0.0]))
    assert not broken.finite
    assert np.isnan(broken.null_space_residual)
    assert not broken.stationary


def test_the_relative_gradient_leaves_out_what_limits_hold():
    off = report(residual=np.array([1.0, 0.0]), at_lower=(0,))
    assert off.relative_gradient == (pytest.approx(1 / np.sqrt(5)), 0.0)
    away = report(residual=np.array([1.0, 0.0]), at_upper=(0,))
    assert away.relative_gradient == (pytest.approx(1 / np.sqrt(5)),) * 2


def test_it_is_pickled_with_its_results():
    original = report(curvature=lambda multipliers: np.eye(3), relaxations=lambda: ())
    again = pickle.loads(pickle.dumps(original))
    assert again.second_order == "minimum"
    assert again.relaxed == ()
    assert again.curvature is None
