"""LimitCentering, LimitBarrier, LimitActivation and LimitNorm: the place of each joint within its range."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik_formulations import LimitActivation, LimitBarrier, LimitCentering, LimitNorm

from ..conftest import EXACT, ball_arm, planar

LOWER, UPPER = np.array([-2.0, -1.0, 0.5]), np.array([1.0, 3.0, 0.9])
ALL = (LimitCentering, LimitBarrier, LimitActivation, LimitNorm)


def arm():
    return jtik.Robot.planar(3, lower=LOWER, upper=UPPER)


def fraction(q):
    """Deviation from the middle, in halves of the range."""
    return (q - (LOWER + UPPER) / 2) / ((UPPER - LOWER) / 2)


def at_fractions(x):
    return (LOWER + UPPER) / 2 + np.asarray(x) * (UPPER - LOWER) / 2


def test_centering_is_the_formula_of_liegeois(rng):
    robot = arm()
    for _ in range(5):
        q = robot.random_configuration(rng)
        formula = np.sum(((q - (LOWER + UPPER) / 2) / (UPPER - LOWER)) ** 2) / (2 * 3)
        assert LimitCentering()(q, robot) == pytest.approx(formula, rel=EXACT)


def test_barrier_is_the_formula_of_zghal_inside(rng):
    robot = arm()
    for _ in range(5):
        q = at_fractions(rng.uniform(-0.97, 0.97, 3))
        formula = np.sum((UPPER - LOWER) ** 2 / (4 * (UPPER - q) * (q - LOWER)))
        slope = (UPPER - LOWER) ** 2 * (2 * q - UPPER - LOWER) / (4 * (UPPER - q) ** 2 * (q - LOWER) ** 2)
        assert LimitBarrier()(q, robot) == pytest.approx(formula, rel=1e-10)
        assert LimitBarrier().gradient(q, robot) == pytest.approx(slope, rel=1e-9)
    assert LimitBarrier()(at_fractions([0, 0, 0]), robot) == pytest.approx(3, rel=EXACT)


@pytest.mark.parametrize("margin", [0.02, 0.2])
def test_barrier_rises_through_the_limit_and_beyond(margin):
    robot, criterion = arm(), LimitBarrier(margin=margin)
    along = [criterion(at_fractions([x, 0, 0]), robot) for x in np.linspace(0, 2, 401)]
    assert np.all(np.diff(along, 2) > 0)  # convex, and rising from the middle on
    assert np.isfinite(along).all()


@pytest.mark.parametrize("margin", [0.02, 0.2])
def test_barrier_is_twice_continuously_differentiable_where_it_is_continued(margin):
    robot, criterion, h = arm(), LimitBarrier(margin=margin), 1e-6
    slopes = [criterion.gradient(at_fractions([1 - margin + k * h, 0, 0]), robot)[0] for k in (-2, -1, 1, 2)]
    below, above = slopes[1] - slopes[0], slopes[3] - slopes[2]
    assert below == pytest.approx(above, rel=1e-3)


def test_activation_is_zero_until_start_and_one_at_a_limit():
    robot, criterion = arm(), LimitActivation(start=0.75)
    assert criterion(at_fractions([0.75, -0.74, 0.3]), robot) == pytest.approx(0, abs=EXACT)
    assert criterion.gradient(at_fractions([0.7, -0.74, 0.3]), robot).tolist() == [0, 0, 0]
    assert criterion(at_fractions([1, 0, 0]), robot) == pytest.approx(1, rel=1e-10)
    assert criterion(at_fractions([1, -1, 0]), robot) == pytest.approx(2, rel=1e-10)
    assert criterion(at_fractions([0.875, 0, 0]), robot) == pytest.approx(1 / 8, rel=1e-10)
    assert criterion.gradient(at_fractions([-1.3, 0, 0]), robot)[0] < 0


@pytest.mark.parametrize("power", [2.0, 8.0, 64.0])
def test_norm_is_numpys_norm_but_for_the_smoothing(power, rng):
    robot = arm()
    for _ in range(5):
        q = robot.random_configuration(rng)
        x = fraction(q)
        norm = np.linalg.norm(x, power) / 3 ** (1 / power)
        assert LimitNorm(power=power)(q, robot) == pytest.approx(norm, abs=0.01)
    assert LimitNorm(power=64.0)(at_fractions([0.2, -0.9, 0.5]), robot) == pytest.approx(0.9, rel=0.02)


@pytest.mark.parametrize("criterion", ALL)
def test_joints_without_two_limits_do_not_count(criterion, rng):
    robot = jtik.Robot.planar(3, lower=[-1.0, -np.inf, -2.0], upper=[2.0, 1.0, np.inf])
    q = robot.random_configuration(rng)
    assert criterion().gradient(q, robot)[1:].tolist() == [0, 0]
    free = planar(4)
    assert np.isfinite(criterion()(np.zeros(4), free))
    assert criterion().gradient(free.random_configuration(rng), free).tolist() == [0, 0, 0, 0]


@pytest.mark.parametrize("criterion", ALL)
def test_limits_given_make_joints_count(criterion, rng):
    free = planar(3)
    given = criterion(lower=LOWER, upper=UPPER)
    q = arm().random_configuration(rng)
    assert given(q, free) == pytest.approx(criterion()(q, arm()), rel=EXACT)
    first = free.joint_names[0]
    q[0] = -2.0
    one = criterion(lower={first: -2.0}, upper={first: 1.0}).gradient(q, free)
    assert one[0] < 0
    assert one[1:].tolist() == [0, 0]


@pytest.mark.parametrize("criterion", ALL)
def test_live_parameters_act_as_if_built_with_them(criterion, rng):
    robot = arm()
    weights = [0.5, 0.0, 2.0]
    built = criterion(lower=-2.5, upper=3.5, weights=weights)
    q = robot.random_configuration(rng)
    live = criterion()(q, robot, lower=[-2.5] * 3, upper=[3.5] * 3, weights=weights)
    assert live == pytest.approx(built(q, robot), rel=EXACT)
    for name in criterion().options():
        assert (
            criterion()(at_fractions([0.99, 0.9, 0]), robot, **{name: 0.5})
            != pytest.approx(criterion()(at_fractions([0.99, 0.9, 0]), robot), rel=1e-3)
            or name == "power"
        )


@pytest.mark.parametrize("criterion", ALL)
@pytest.mark.parametrize("x", [0.0, 1.0, -1.0, 3.0])
def test_finite_in_the_middle_at_limits_and_beyond(criterion, x):
    robot = arm()
    for live in ({}, {"weights": [0.0, 0.0, 0.0]}, {"lower": UPPER, "upper": UPPER}):
        assert np.isfinite(criterion()(at_fractions([x] * 3), robot, **live))
        assert np.isfinite(criterion().gradient(at_fractions([x] * 3), robot, **live)).all()


@pytest.mark.parametrize("criterion", ALL)
def test_a_quaternion_has_no_range(criterion, rng):
    robot = ball_arm()
    q = robot.random_configuration(rng)
    moved = robot.velocity_values({"elbow": 1.0, "lift": 1.0}, default=0.0)
    assert np.all(criterion(upper=0.1, lower=-0.1).gradient(q, robot)[moved == 0] == 0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: LimitBarrier(margin=0.0), "^margin: given 0.0; accepted: a number between 0 and 1"),
        (lambda: LimitActivation(start=1.0), "^start: given 1.0"),
        (lambda: LimitActivation(start=np.nan), "^start: given nan"),
        (lambda: LimitNorm(power=1.0), "^power: given 1.0"),
        (lambda: LimitNorm(power=np.inf), "^power: given inf"),
        (lambda: LimitNorm(power=64.5), "^power: given 64.5; accepted: a number from 2 to 64"),
        (lambda: LimitBarrier(lower={"elbow": True}), r"^lower\['elbow'\]: given"),
        (lambda: LimitBarrier(weights={"elbow": -1.0}), r"^weights\['elbow'\]: given -1.0; accepted: non-negative"),
        (lambda: LimitBarrier(weights=[1.0, -1.0]), "^weights: given -1.0 at index 1"),
        (lambda: LimitBarrier(upper=np.inf), "^upper: given inf"),
    ],
)
def test_options_out_of_range_are_refused(make, message):
    with pytest.raises(jtik.ArgumentError, match=message):
        make()


@pytest.mark.parametrize("criterion", ALL)
def test_a_negative_live_weight_is_refused(criterion):
    with pytest.raises(jtik.ArgumentError, match="weights.*non-negative"):
        criterion()([0.0, 0.0, 0.6], arm(), weights=[1.0, -1.0, 0.0])


@pytest.mark.parametrize("power", [2, 64])
def test_both_ends_of_the_powers_are_accepted(power):
    assert np.isfinite(LimitNorm(power=power)([0.1, 0.0, 0.6], arm()))


@pytest.mark.parametrize("criterion", ALL)
def test_limits_and_weights_that_do_not_fit_are_refused(criterion):
    robot, q = arm(), [0.0, 0.0, 0.6]
    with pytest.raises(jtik.ArgumentError, match="^weights: given -1"):
        criterion(weights=[1.0, -1.0, 0.0])(q, robot)
    with pytest.raises(jtik.ArgumentError, match="^lower: given 2 at index 0; accepted: at most the upper limit 1"):
        criterion(lower=[2.0, -1.0, 0.5])(q, robot)
    with pytest.raises(jtik.ArgumentError, match="^upper"):
        criterion(upper=[2.0, 1.0])(q, robot)
    with pytest.raises(jtik.UnknownNameError):
        criterion(weights={"elbows": 1.0})(q, robot)


@pytest.mark.parametrize("criterion", ALL)
def test_the_repr_shows_what_was_given(criterion):
    assert repr(criterion()).startswith(f"{criterion.__name__}(")
    assert "weights=[0.5, 1.0, 2.0]" in repr(criterion(weights=[0.5, 1.0, 2.0]))
    assert "name='mine'" in repr(criterion(name="mine"))
