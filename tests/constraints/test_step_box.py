"""The box of a step in time: never empty, wherever a joint is and however fast; kept up for ever once it is kept."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq, linprog

import jtik
from jtik.constraints.limits import Limits
from jtik.constraints.step_box import StepBox, box_function, braking
from jtik.symbolic import function, symbol
from jtik.symbolic.compile import CompiledFunction

LOWER, UPPER = -0.4, 0.5
DT = 0.01
GAINS = (1.0, 0.9, 0.5, 0.3, 0.05)
"""Shares of the distance to a limit that a step may use."""
ROUNDING = 1e-13
"""Of differences of positions of order one."""


@functools.cache
def box_of(velocity=1.5, acceleration=8.0, lower=LOWER, upper=UPPER, gain=1.0):
    robot = jtik.Robot.planar(1, lower=lower, upper=upper)
    limits = Limits(velocity=velocity, acceleration=acceleration, position_gain=gain)
    return CompiledFunction(box_function(limits.of(robot)))


def ends(box, q, last, dt=DT, before=None):
    lower, upper = box(q, last, [dt, before or dt])
    return float(lower[0, 0]), float(upper[0, 0])


@functools.cache
def braking_step():
    distance, change = symbol("distance", 1), symbol("change", 1)
    return CompiledFunction(function("braking_step", [distance, change], [braking(distance, change)]))


class TestBraking:
    @pytest.mark.parametrize("change", [1e-6, 1e-3, 0.2, 50.0])
    @pytest.mark.parametrize("distance", [1e-9, 1e-4, 0.1, 3.0])
    def test_is_the_root_of_its_equation(self, distance, change):
        found = float(braking_step()(distance, change)[0][0, 0])
        root = brentq(lambda s: s + s**2 / (2 * change) - distance, 0, distance, xtol=1e-300, rtol=1e-14)
        assert found == pytest.approx(root, rel=1e-12)

    def test_at_the_limit_the_step_is_zero_and_outside_it_returns(self):
        assert [float(braking_step()(distance, 0.1)[0][0, 0]) for distance in (0.0, -0.3)] == [0.0, -0.3]

    @pytest.mark.parametrize("distance", [0.001, 0.03, 0.7])
    def test_no_step_that_a_joint_can_recover_from_is_much_longer(self, distance):
        """The longest first step of 200 that change by ``change`` at most, stop, and stay inside: a linear program."""
        change, count = 0.01, 200
        sums, differences = np.tril(np.ones((count, count))), np.diff(np.eye(count), axis=0)
        end = np.eye(count)[-1:]
        best = linprog(
            -np.eye(count)[0],
            A_ub=np.vstack([sums, differences, -differences, end, -end]),
            b_ub=np.concatenate([np.full(count, distance), np.full(2 * count - 2, change), np.zeros(2)]),
            bounds=[(0, None)] * count,
        ).x[0]
        ours = float(braking_step()(distance, change)[0][0, 0])
        assert best - change / 2 <= ours <= best + 1e-9


@settings(deadline=None, max_examples=300)
@given(
    q=st.floats(-3, 3),
    last=st.floats(-0.5, 0.5),
    dt=st.sampled_from([1e-4, 0.01, 0.3]),
    before=st.sampled_from([1e-4, 0.01, 0.3]),
    velocity=st.sampled_from([0.1, 1.5, math.inf]),
    acceleration=st.sampled_from([0.5, 8.0, 1e4, math.inf]),
    limits=st.sampled_from([(LOWER, UPPER), (0.2, 0.2), (-math.inf, 0.1), (-math.inf, math.inf)]),
    gain=st.sampled_from(GAINS),
)
@example(0.6, 0.0, 0.3, 0.3, math.inf, 0.5, (0.2, 0.2), 1.0)
@example(2.0, 0.0, 0.3, 0.3, math.inf, math.inf, (0.2, 0.2), 0.5)
def test_never_empty_and_in_the_order_of_precedence(q, last, dt, before, velocity, acceleration, limits, gain):
    """Whatever the state: acceleration holds; so does velocity, where acceleration lets it; then position."""
    low, high = ends(box_of(velocity, acceleration, *limits, gain), q, last, dt, before)
    assert low <= high
    step, reach, change = last * dt / before, velocity * dt, acceleration * dt**2
    tolerance = ROUNDING * (1 + abs(step))
    for end in (low - q, high - q):
        assert abs(end - step) <= change + tolerance
        excess = max(abs(step) - change, reach)  # the least speed there can be, if that is above the limit
        assert abs(end) <= excess + tolerance
    if limits[0] <= q <= limits[1] and abs(last) == 0:
        assert limits[0] <= low <= q <= high <= limits[1]


@settings(deadline=None, max_examples=60)
@given(
    seed=st.integers(0, 2**32 - 1),
    start=st.sampled_from([LOWER, UPPER, UPPER - 1e-9, 0.0, 0.3]),
    greed=st.sampled_from([0.0, 0.5, 0.95, 1.0]),
    dts=st.sampled_from([(DT,), (0.001, 0.01, 0.05)]),
    velocity=st.sampled_from([0.3, 1.5, math.inf]),
    acceleration=st.sampled_from([0.5, 8.0, 300.0, math.inf]),
    gain=st.sampled_from(GAINS),
)
def test_any_sequence_of_steps_in_the_box_keeps_all_limits(seed, start, greed, dts, velocity, acceleration, gain):
    """From rest; greedy steps go to an end of the box, to the same for a while.

    A share of the distance to a limit is kept, too, but by the hardest braking: that can be too long for shares below
    a half.
    """
    rng, box = np.random.default_rng(seed), box_of(velocity, acceleration, gain=gain)
    q, last, before, side = start, 0.0, DT, 1
    for _ in range(300):
        dt = float(rng.choice(dts))
        low, high = ends(box, q, last, dt, before)
        assert low <= high
        if rng.random() < 0.02:
            side = -side
        after = (high if side > 0 else low) if rng.random() < greed else rng.uniform(low, high)
        assert LOWER <= after <= UPPER
        assert abs(after - q) <= velocity * dt + ROUNDING
        assert abs((after - q) / dt - last / before) <= acceleration * dt + ROUNDING / dt + ROUNDING / before
        step, distance = abs(after - q), UPPER - q if after > q else q - LOWER
        if gain >= 0.5 or step > abs(last) * dt / before - acceleration * dt**2 + ROUNDING:
            assert step <= gain * distance + ROUNDING
        q, last, before = after, after - q, dt


def test_a_joint_that_runs_into_its_limit_ends_there():
    q, last = 0.0, 0.0
    for _ in range(200):
        _, after = ends(box_of(), q, last)
        q, last = after, after - q
    assert q == UPPER
    assert last == 0.0


@pytest.mark.parametrize("gain", [0.9, 0.5, 0.1])
def test_a_joint_that_runs_into_its_limit_leaves_the_rest_of_the_distance_each_time(gain):
    """In closed form: the distance decreases by the share in each step."""
    box, q = box_of(math.inf, math.inf, gain=gain), 0.0
    for k in range(1, 30):
        _, q = ends(box, q, 0.0)
        assert UPPER - q == pytest.approx((1 - gain) ** k * UPPER, abs=ROUNDING)


@pytest.mark.parametrize("gain", [0.9, 0.5, 0.1])
@pytest.mark.parametrize("acceleration", [300.0, math.inf])
def test_the_share_does_not_shorten_the_way_back_from_outside(gain, acceleration):
    for q in (0.6, 0.9, -0.7):
        with_share, without = (ends(box_of(1.5, acceleration, gain=g), q, 0.0) for g in (gain, 1.0))
        nearer = 1 if q > UPPER else 0
        assert with_share[nearer] == pytest.approx(without[nearer], abs=ROUNDING)


def test_without_accelerations_it_is_where_limits_and_speeds_meet():
    box = box_of(1.5, math.inf)
    for q in (-0.6, LOWER, -0.39, 0.0, 0.492, UPPER, 0.508, 0.9):
        low, high = q - 1.5 * DT, q + 1.5 * DT
        assert ends(box, q, 0.3) == pytest.approx((np.clip(LOWER, low, high), np.clip(UPPER, low, high)), abs=1e-15)


@settings(deadline=None, max_examples=60)
@given(
    start=st.floats(0.501, 2.0),
    acceleration=st.sampled_from([0.5, 8.0, 300.0, math.inf]),
    limits=st.sampled_from([(LOWER, UPPER), (UPPER, UPPER), (UPPER - 1e-3, UPPER)]),
    gain=st.sampled_from([1.0, 0.9, 0.5, 0.3]),
)
def test_from_outside_it_leads_back_in_and_not_out_at_the_other_end(start, acceleration, limits, gain):
    """Greedy for the far end, from rest: monotone to inside, and then inside for ever; a range may have no width."""
    box, q, last = box_of(1.5, acceleration, *limits, gain), start, 0.0
    entered = False
    for _ in range(1500):
        low, high = ends(box, q, last)
        if not entered:
            assert high <= q
        entered = entered or limits[0] <= low <= limits[1]
        if entered:
            assert limits[0] - ROUNDING <= low <= limits[1] + ROUNDING
        q, last = low, low - q
    assert q == pytest.approx(limits[0], abs=1e-9)


def test_it_is_written_where_a_solver_reads_it():
    robot = jtik.Robot.planar(2, lower=-1.0, upper=1.0, velocity_limit=[0.5, 1.0])
    bounds = Limits(acceleration=10.0).of(robot)
    lower, upper, share = np.zeros(2), np.zeros(2), np.zeros(1)
    box = StepBox(bounds, box_function(bounds), lower, upper, share=share, null_space_rate=2.0)
    q = np.array([0.2, -0.3])
    box.narrow(q, 0.01)
    assert upper - q == pytest.approx([1e-3, 1e-3])
    box.moved(upper)
    box.narrow(upper.copy(), 0.01)
    assert upper == pytest.approx(q + 3e-3)
    box.rest()
    box.narrow(q, 0.1)
    assert upper - q == pytest.approx([0.05, 0.1])


def test_a_step_starts_where_the_last_motion_leads():
    robot = jtik.Robot.planar(2, lower=-1.0, upper=1.0, velocity_limit=2.0)
    bounds, share = Limits(acceleration=10.0).of(robot), np.zeros(1)
    lower, upper = np.zeros(2), np.zeros(2)
    box = StepBox(bounds, box_function(bounds), lower, upper, share=share, null_space_rate=5.0)
    q, motion = np.array([0.2, -0.3]), np.array([8e-4, -9e-4])
    box.narrow(q, DT)
    assert box.start().tolist() == q.tolist()
    box.moved(q + motion)
    box.narrow(q + motion, DT)
    assert box.start() == pytest.approx(q + motion + math.exp(-10 * DT) * motion)
    assert share[0] == pytest.approx((1 - math.exp(-5 * DT)) * (1 - math.exp(-10 * DT)))
    box.narrow(q + motion, 2 * DT)  # the same velocity in twice the time
    assert box.start() == pytest.approx(q + motion + 2 * math.exp(-20 * DT) * motion)
    assert box.braked() == pytest.approx(q + motion)
    box.rest()
    box.narrow(q, DT)
    assert box.start().tolist() == q.tolist()


def test_the_start_is_in_the_box():
    """A joint that moves towards its limit starts where it can still stop."""
    robot = jtik.Robot.planar(1, lower=-1.0, upper=1.0)
    bounds = Limits(acceleration=10.0).of(robot)
    lower, upper = np.zeros(1), np.zeros(1)
    box = StepBox(bounds, box_function(bounds), lower, upper, share=np.zeros(1), null_space_rate=5.0)
    box.narrow(np.array([0.979]), DT)
    box.moved(np.array([0.985]))
    box.narrow(np.array([0.985]), DT)
    assert box.start() == upper < 0.985 + math.exp(-10 * DT) * 0.006
    assert box.braked() == lower
