"""Khatib's potential, the barrier of finite range and the smoothed smallest distance: values, forces, smoothness."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.symbolic import norm, sumsqr
from jtik_formulations import KhatibPotential, ObstacleAvoidance, ObstacleBarrier, SoftClearance

from ..conftest import EXACT, dh_arm, differences, planar, shared_solver
from ..geometry.shapes import PLANAR, SPATIAL, distance, random_obstacle

CLASSES = (KhatibPotential, ObstacleBarrier, SoftClearance, ObstacleAvoidance)

ONE_LINK = planar(1)
"""Its only joint that moves is the tip, at (1, 0) for q = 0."""


def before(gap):
    """A wall that the tip is in front of, at this distance."""
    return jtik.HalfSpace((1.0 + gap, 0.0), (-1.0, 0.0))


def value(criterion, gap, **parameters):
    """H of the tip at this distance."""
    return criterion([0.0], ONE_LINK, half_space_points=[(1.0 + gap, 0.0)], **parameters)


def test_khatibs_force():
    eta, rho_0, h = 0.7, 0.4, 1e-6
    criterion = KhatibPotential(before(1), gain=eta, influence=rho_0)
    for rho in (0.03, 0.1, 0.39):
        assert value(criterion, rho) == pytest.approx(eta / 2 * (1 / rho - 1 / rho_0) ** 2, abs=EXACT)
        force = (value(criterion, rho - h) - value(criterion, rho + h)) / (2 * h)
        assert force == pytest.approx(eta * (1 / rho - 1 / rho_0) / rho**2, rel=1e-6)
    assert value(criterion, 0.41) == 0.0
    assert value(criterion, 0.41, influence=0.5) > 0.0


def test_the_barrier_of_incremental_potential_contact():
    criterion = ObstacleBarrier(before(1), gain=2.0, influence=0.5)
    for gap in (0.03, 0.1, 0.49):
        x = gap / 0.5
        assert value(criterion, gap) == pytest.approx(-2 * (1 - x) ** 2 * np.log(x), abs=EXACT)
    assert value(criterion, 0.51) == 0.0
    assert value(criterion, 10.0) == 0.0


def second(criterion, gap, h=1e-5):
    return (value(criterion, gap + h) - 2 * value(criterion, gap) + value(criterion, gap - h)) / h**2


def first(criterion, gap, h=1e-6):
    return (value(criterion, gap + h) - value(criterion, gap - h)) / (2 * h)


@pytest.mark.parametrize(
    ("criterion", "edges", "jumps"),
    [
        (KhatibPotential(before(1), influence=0.4, floor=0.1), (0.1, 0.4), (False, True)),
        (ObstacleBarrier(before(1), influence=0.4, floor=0.25), (0.1, 0.4), (False, False)),
    ],
)
def test_value_force_and_curvature_at_the_floor_and_where_the_range_ends(criterion, edges, jumps):
    for edge, jump in zip(edges, jumps, strict=True):
        sides = (edge - 1e-4, edge + 1e-4)
        assert value(criterion, sides[0]) == pytest.approx(value(criterion, sides[1]), rel=2e-2, abs=1e-3)
        assert first(criterion, sides[0]) == pytest.approx(first(criterion, sides[1]), rel=1e-2, abs=1e-2)
        low, high = (second(criterion, side) for side in sides)
        assert (abs(high - low) > 0.02 * max(abs(low), abs(high), 10)) == jump
    deep = [first(criterion, gap) for gap in (-1.0, -0.5, 0.0, 0.05)]
    assert deep == sorted(deep)
    assert deep[-1] < 0  # still outwards, and harder inside


def test_the_smoothed_distance_is_below_the_smallest_by_no_more_than_its_bound(rng):
    robot = planar(4)
    obstacles = [random_obstacle(kind, 2, rng) for kind in PLANAR for _ in range(2)]
    for smoothing in (1e-3, 0.05, 0.5):
        criterion = SoftClearance(obstacles, smoothing=smoothing, gain=2.0, bodies="links")
        for _ in range(5):
            q = robot.random_configuration(rng)
            nodes = np.vstack([np.zeros(2), [robot.position(q, f) for f in robot.moving_frames]])
            smallest = min(distance(each, *nodes[i : i + 2])[0] for i in range(4) for each in obstacles)
            smoothed = -criterion(q, robot) / 2.0
            assert smallest - smoothing * np.log(4 * len(obstacles)) - 1e-9 <= smoothed <= smallest + 1e-9


def test_a_gain_counts_like_that_many_obstacles(rng):
    robot, circle = planar(3), jtik.Circle((2.0, 1.0), 0.2)
    q = robot.random_configuration(rng)
    for kind in CLASSES:
        three = kind([circle] * 3, bodies="links")(q, robot)
        assert kind(jtik.Scene([circle], [3.0]), bodies="links")(q, robot) == pytest.approx(three, rel=1e-12)


@pytest.mark.quick(2)
@pytest.mark.parametrize("kind", CLASSES)
def test_absent_obstacles_have_no_part_in_it(kind, rng):
    robot = planar(3)
    near = jtik.Circle(robot.position([0.3, 0.2, 0.1]), 0.2)
    q, other = np.array([0.3, 0.2, 0.1]), jtik.Box.at((1.0, 1.0), (0.2, 0.1))
    empty = kind(jtik.Scene([near], [0.0]), bodies="links")
    assert empty(q, robot) == 0.0
    assert not empty.gradient(q, robot).any()
    both = kind(jtik.Scene([near, other], [0.0, 1.0]), bodies="links")
    assert both(q, robot) == pytest.approx(kind(other, bodies="links")(q, robot), rel=1e-12)
    assert both.gradient(q, robot) == pytest.approx(kind(other, bodies="links").gradient(q, robot), rel=1e-9, abs=1e-12)


@pytest.mark.thinned
@pytest.mark.parametrize("kind", CLASSES)
@pytest.mark.parametrize("dimension", [2, 3])
def test_gradients_with_every_shape_agree_with_differences(kind, dimension, rng):
    robot = planar(4) if dimension == 2 else dh_arm(5, 1)
    obstacles = [random_obstacle(shape, dimension, rng) for shape in (PLANAR if dimension == 2 else SPATIAL)]
    options = {} if kind in (SoftClearance, ObstacleAvoidance) else {"influence": 1.0}
    criterion = kind(obstacles, bodies="both", **options)
    agreeing = 0
    for _ in range(6):
        q = robot.random_configuration(rng)
        found = criterion.gradient(q, robot)
        close, wide = (differences(lambda p: criterion(p, robot), robot, q, step=h)[0] for h in (1e-6, 4e-6))
        scale = max(1.0, np.abs(found).max())
        if np.abs(close - wide).max() > 1e-4 * scale:
            continue  # a kink is near
        agreeing += 1
        assert found == pytest.approx(close, abs=1e-3 * scale)
    assert agreeing > 2


@pytest.mark.quick(2)
@pytest.mark.parametrize("kind", CLASSES)
def test_each_measures_for_a_clearance(kind):
    """The arm turns towards a box, and stops in front of it."""
    robot = planar(3)
    box = jtik.Box.at((1.5, 2.0), (0.4, 0.3), 0.3)
    clearance = jtik.Clearance(kind(box, bodies="links"), safe=0.05)
    ik = shared_solver(robot, jtik.FrameTask(kind="position"), strategy="weighted_qp", clearances=clearance)
    solution = ik.solve([0.4, 2.6], q0=[0.0, 0.1, 0.1])
    nodes = np.vstack([np.zeros(2), [robot.position(solution.q, f) for f in robot.moving_frames]])
    assert min(distance(box, *nodes[i : i + 2])[0] for i in range(3)) >= 0.05 - 1e-6


@pytest.mark.parametrize(
    ("build", "argument"),
    [
        (lambda: KhatibPotential([], influence=0.01), "influence"),
        (lambda: KhatibPotential([], floor=0), "floor"),
        (lambda: KhatibPotential([], gain=-1), "gain"),
        (lambda: ObstacleBarrier([], influence=0), "influence"),
        (lambda: ObstacleBarrier([], floor=1.0), "floor"),
        (lambda: SoftClearance([], smoothing=0.0), "smoothing"),
        (lambda: SoftClearance("box"), "obstacles"),
    ],
)
def test_arguments_out_of_range(build, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        build()
    assert caught.value.argument == argument


class Springs(ObstacleAvoidance):
    """Another potential, whose gradient is not that of the class."""

    name = "springs"

    def potential(self, distances, gains, parameters):
        return sumsqr(distances)


@jtik.criterion
def springs(q, robot):
    """The same without a class."""
    return sum((norm(robot.position(q, frame) - np.array([2.0, 1.0])) - 0.3) ** 2 for frame in robot.moving_frames)


def test_a_subclass_with_another_potential_has_the_gradient_of_that():
    arm, q = planar(4), np.array([0.3, 0.2, 0.4, 0.1])
    ends = []
    for criterion in (Springs([jtik.Circle((2.0, 1.0), 0.3)]), springs):
        ik = shared_solver(arm, jtik.FrameTask("tip", "position"), criteria=criterion, limits=False)
        ends.append(ik.solve(arm.position(q, "tip"), q0=q))
    assert [end.status for end in ends] == 2 * [jtik.Status.CONVERGED]
    assert ends[0].cost == pytest.approx(ends[1].cost, abs=1e-9)
