"""Slots: obstacles come, change and go as live parameters of one compiled step."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik.geometry import Slots
from jtik_formulations import ObstacleAvoidance

from ..conftest import EXACT, dh_arm, planar, shared_solver
from .shapes import PLANAR, SPATIAL, random_obstacle

KINDS_OF = {2: PLANAR, 3: SPATIAL}


def arm_of(dimension):
    return planar(4) if dimension == 2 else dh_arm(5, 1)


def scene_of(dimension, rng, count=2):
    """Obstacles of every kind, in random order."""
    found = [random_obstacle(kind, dimension, rng) for kind in KINDS_OF[dimension] for _ in range(count)]
    return [found[i] for i in rng.permutation(len(found))]


@pytest.mark.thinned
@pytest.mark.parametrize("bodies", ["joints", "links", "both"])
@pytest.mark.parametrize("dimension", [2, 3])
def test_a_scene_in_slots_is_the_scene_itself(dimension, bodies, rng):
    """H of slots filled later equals H of the obstacles alone, whatever was in the slots before."""
    robot = arm_of(dimension)
    counts = dict.fromkeys(KINDS_OF[dimension], 3)
    criterion = ObstacleAvoidance([], capacity=counts, bodies=bodies)
    slots = criterion.slots(robot)
    for count in (2, 3, 0):
        obstacles = scene_of(dimension, rng, count)
        parameters = slots.parameters(obstacles)
        alone = ObstacleAvoidance(obstacles, bodies=bodies)
        for q in (robot.random_configuration(rng) for _ in range(3)):
            wanted = alone(q, robot) if obstacles else 0.0
            assert criterion(q, robot, **parameters) == pytest.approx(wanted, rel=1e-9, abs=1e-9)


def test_the_gain_multiplies_the_terms_of_its_obstacle(rng):
    robot = planar(4)
    obstacles = scene_of(2, rng)
    gains = rng.uniform(0, 2, len(obstacles))
    scene = jtik.Scene(obstacles, gains)
    q = robot.random_configuration(rng)
    single = [ObstacleAvoidance(each, bodies="links")(q, robot) for each in obstacles]
    assert ObstacleAvoidance(scene, bodies="links")(q, robot) == pytest.approx(gains @ single, rel=1e-9)
    one = gains * (np.arange(len(gains)) == 3)
    assert ObstacleAvoidance(jtik.Scene(obstacles, one))(q, robot) == pytest.approx(
        one[3] * ObstacleAvoidance(obstacles[3])(q, robot), rel=1e-9
    )


def test_an_empty_scene_has_sixteen_slots_and_no_effect():
    robot = planar(5)
    ik = shared_solver(robot, jtik.FrameTask(), criteria=ObstacleAvoidance([]))
    assert ik.parameters["obstacle_avoidance.gains"].tolist() == [0.0] * 16
    assert ik.parameters["obstacle_avoidance.centers"].shape == (16, 2)
    assert ik.solve([2, 2], q0=[0.1] * 5).cost == 0.0
    with pytest.raises(jtik.ArgumentError, match="gains"):
        ik.parameters["obstacle_avoidance.gains"] = -1.0


def test_obstacles_come_and_go_without_another_step():
    robot = planar(6)
    ik = shared_solver(robot, jtik.FrameTask(), criteria=ObstacleAvoidance([], capacity={"box": 2, "ball": 2}))
    slots = Slots({"box": 2, "ball": 2}, 2)
    q0, target = np.full(6, 0.2), [3.0, 3.0]
    for obstacles in ([jtik.Box.at((2.0, 1.0), (0.3, 0.2), 0.4)], [], [jtik.Circle((1, 2), 0.3), jtik.Point((3, 1))]):
        for name, value in slots.parameters(obstacles).items():
            ik.parameters[f"obstacle_avoidance.{name}"] = value
        alone = shared_solver(robot, jtik.FrameTask(), criteria=ObstacleAvoidance(obstacles))
        assert ik.solve(target, q0=q0).q == pytest.approx(alone.solve(target, q0=q0).q, abs=1e-6)


class TestOf:
    def test_spare_slots_are_divided_among_the_kinds_that_occur(self):
        box, ball = jtik.Box.at((0, 0), (1, 1)), jtik.Point((3, 3))
        assert {k: n for k, n in Slots.of([box, ball, ball], 16, 2).counts.items() if n} == {"ball": 9, "box": 7}
        assert {k: n for k, n in Slots.of([], 5, 3).counts.items() if n} == {"ball": 5}
        assert len(Slots.of([], None, 2)) == 16
        assert len(Slots.of([ball] * 20, None, 2)) == 20

    def test_a_dict_gives_the_number_of_each_kind(self):
        assert Slots.of([], {"box": 2, "polygon": 1}, 2).names == ("box 0", "box 1", "polygon 0")
        assert Slots.of([], 2, 2).names == ("obstacle 0", "obstacle 1")

    def test_the_place_of_each_obstacle(self):
        slots = Slots({"ball": 2, "box": 2}, 2)
        box, ball = jtik.Box.at((0, 0), (1, 1)), jtik.Point((3, 3))
        assert slots.place([box, ball, box]) == (2, 0, 3)
        assert slots.parameters([box, ball], [0.5, 2.0])["gains"].tolist() == [2.0, 0.0, 0.5, 0.0]


@pytest.mark.parametrize(
    ("build", "error", "says"),
    [
        (lambda: Slots({"ball": -1}, 2), jtik.ArgumentError, "counts.*ball"),
        (lambda: Slots({"cube": 1}, 2), jtik.UnknownNameError, "cube.*box"),
        (lambda: Slots({"cylinder": 1}, 2), jtik.ArgumentError, "cylinder.*plane"),
        (lambda: Slots({"polygon": 1}, 3), jtik.ArgumentError, "polygon.*space"),
        (lambda: Slots({}, 4), jtik.ArgumentError, "dimension"),
        (lambda: Slots.of([jtik.Point((0, 0))] * 3, 2, 2), jtik.ArgumentError, "3 obstacles.*at most 2"),
        (lambda: Slots.of([jtik.Point((0, 0, 0))], 2, 2), jtik.ArgumentError, "2-dimensional"),
        (lambda: Slots({"ball": 1}, 2).parameters([jtik.Capsule((0, 0), (1, 0), 1)]), jtik.ArgumentError, "capsule"),
        (lambda: Slots({"ball": 1}, 2).parameters([jtik.Point((0, 0))], [-1.0]), jtik.ArgumentError, "gains"),
        (lambda: Slots({"ball": 2}, 2).parameters([jtik.Point((0, 0))], [1.0, 1.0]), jtik.ArgumentError, "gains"),
        (
            lambda: Slots({"polygon": 1}, 2, corners=3).parameters(jtik.Polygon([(0, 0), (1, 0), (1, 1), (0, 1)])),
            jtik.ArgumentError,
            "4 corners.*at most 3",
        ),
    ],
)
def test_what_does_not_fit_is_refused(build, error, says):
    with pytest.raises(error, match=says):
        build()


def test_degenerate_live_values_stay_finite():
    """A box without extent, a capsule at one point, a cylinder without an axis."""
    robot = dh_arm(4, 1)
    criterion = ObstacleAvoidance([], capacity={"box": 1, "half_space": 1, "cylinder": 1, "capsule": 1}, bodies="links")
    zero = {name: np.zeros_like(value) for name, value in criterion.slots(robot).parameters([]).items()}
    zero = {name: value for name, value in zero.items() if name not in ("box_rotations", "half_space_normals")}
    zero["gains"] = np.ones(4)
    q = robot.random_configuration(np.random.default_rng(0))
    assert np.isfinite(criterion(q, robot, **zero))
    assert np.isfinite(criterion.gradient(q, robot, **zero)).all()


SQUARE = [0, 0, 1, 0, 1, 1, 0, 1]
TRIANGLE = [0, 0, 1, 0, 0, 1, 0, 1]


@pytest.mark.thinned
@pytest.mark.parametrize(
    ("dimension", "parameter", "wrong", "right"),
    [
        (3, "half_space_normals", [0, 0, 0], [0, 0, -3]),
        (2, "half_space_normals", [0, 0], [1e-3, 0]),
        (3, "box_rotations", [0, 0, 0, 0], [0, 0, 2, 0]),
        (2, "polygon_vertices", [0, 0, 1, 0, 0.2, 0.2, 0, 1], SQUARE),  # not convex
        (2, "polygon_vertices", [0, 0, 1, 0, 2, 0, 3, 0], TRIANGLE),  # no area
        (2, "polygon_vertices", [1] * 8, TRIANGLE),  # one point
        (2, "polygon_vertices", [0, 0, 0, 1, 1, 1, 1, 0], SQUARE),  # clockwise
        (2, "polygon_vertices", [0, 0, 1, 1, 1, 0, 0, 1], SQUARE),  # it crosses itself
    ],
)
@pytest.mark.parametrize("place", ["criterion", "clearance", "call"])
def test_a_live_value_that_is_no_obstacle_is_refused(dimension, parameter, wrong, right, place):
    """Of two slots the second one is wrong; what was there before stays."""
    obstacle = {"polygon_vertices": jtik.Polygon([(5, 5), (6, 5), (6, 6), (5, 6)])} if dimension == 2 else {}
    obstacle["half_space_normals"] = jtik.HalfSpace([5.0] * dimension, [1.0] * dimension)
    if dimension == 3:
        obstacle["box_rotations"] = jtik.Box.at([5.0] * 3, [1.0] * 3)
    robot = arm_of(dimension)
    field = ObstacleAvoidance([obstacle[parameter]] * 2, name="field")
    rows = [right, wrong]
    if place == "call":
        with pytest.raises(jtik.ArgumentError, match=f"^{parameter}: given .*; accepted: "):
            field(robot.neutral, robot, **{parameter: rows})
        assert np.isfinite(field(robot.neutral, robot, **{parameter: [right, right]}))
        return
    if place == "criterion":
        options, name = {"criteria": field}, f"field.{parameter}"
    else:
        options, name = {"clearances": jtik.Clearance(field, name="row"), "strategy": "weighted_qp"}, f"row.{parameter}"
    ik = shared_solver(robot, jtik.FrameTask(kind="position"), **options)
    before = ik.parameters[name]
    with pytest.raises(jtik.ArgumentError, match=f"^{name}: given .*; accepted: "):
        ik.parameters[name] = rows
    assert np.array_equal(ik.parameters[name], before)
    ik.parameters[name] = [right, right]
    assert ik.parameters[name][1].tolist() == right


def test_a_live_rotation_turns_the_box():
    robot = planar(1)
    criterion = ObstacleAvoidance(jtik.Box.at((3.0, 0.0), (1.0, 0.1)), floor=1e-3)
    for angle, distance in ((0.0, 1.0), (np.pi / 2, 1.9), (np.pi / 4, (1.9 + 0.1 * np.sqrt(2)) / np.sqrt(2))):
        if angle == np.pi / 4:  # the corner of a square turned by it
            found = criterion([0.0], robot, box_rotations=[angle], box_halves=[[0.1, 0.1]])
            assert found == pytest.approx(-np.log(2 - 0.1 * np.sqrt(2)), abs=EXACT)
        else:
            assert criterion([0.0], robot, box_rotations=[angle]) == pytest.approx(-np.log(distance), abs=EXACT)
