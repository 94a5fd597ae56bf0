"""ObstacleAvoidance: the paper's potential with the sign that repels, finite inside and on obstacles."""

from __future__ import annotations

import itertools

import casadi
import numpy as np
import pytest

import jtik
from jtik_formulations import ObstacleAvoidance, SoftClearance

from ..conftest import (
    DIFFERENCES,
    ball_arm,
    dh_arm,
    differences,
    planar,
    planar_jacobian,
    planar_points,
    report_at,
    shared_solver,
)

PAPER = 1e-8
"""Agreement with the paper's formula: rounding of sums of some dozen terms of order one to a hundred."""


def solver(robot, obstacles, **options):
    return shared_solver(robot, jtik.FrameTask(), criteria=ObstacleAvoidance(obstacles, **options), limits=False)


def at(ik, q):
    return report_at(ik, q, ik.robot.position(q))


def joint_jacobian(q, j):
    """(2, n) of the end of link j of a unit planar arm."""
    J = np.zeros((2, len(q)))
    J[:, : j + 1] = planar_jacobian(q[: j + 1])
    return J


def test_gradient_is_the_papers_sum_with_a_minus(rng):
    """-K_obs sum_j J_j' sum_i x_ij / (x_ij' x_ij), x_ij = p_j - o_i."""
    robot, gain = planar(6), 0.7
    centers = rng.uniform(-5, 5, (3, 2))
    ik = solver(robot, [jtik.Point(center) for center in centers], gain=gain)
    for _ in range(10):
        q = robot.random_configuration(rng)
        points = planar_points(q)
        H, gradient = 0.0, np.zeros(6)
        for j, point in enumerate(points):
            for center in centers:
                x = point - center
                H -= gain * np.log(np.linalg.norm(x))
                gradient -= gain * joint_jacobian(q, j).T @ x / (x @ x)
        found = at(ik, q)
        assert found.cost == pytest.approx(H, abs=PAPER)
        assert found.gradient == pytest.approx(gradient, abs=PAPER)


def test_circles_measure_from_their_surface(rng):
    robot = planar(4)
    ik = solver(robot, jtik.Circle((6.0, 0.0), 1.5))
    for _ in range(10):
        q = rng.uniform(-0.5, 0.5, 4)
        distances = np.linalg.norm(planar_points(q) - (6.0, 0.0), axis=1) - 1.5
        assert at(ik, q).cost == pytest.approx(-np.log(distances).sum(), abs=PAPER)


def segment_distance(start, end, center):
    along = end - start
    t = np.clip((center - start) @ along / (along @ along), 0, 1)
    return np.linalg.norm(start + t * along - center)


@pytest.mark.parametrize("bodies", ["joints", "links", "both"])
def test_bodies_select_joints_links_or_both(bodies, rng):
    robot, center = planar(4), np.array([1.7, 2.6])
    ik = solver(robot, jtik.Circle(center, 0.1), bodies=bodies)
    for _ in range(10):
        q = robot.random_configuration(rng)
        nodes = np.vstack([np.zeros(2), planar_points(q)])
        joints = np.linalg.norm(nodes[1:] - center, axis=1) - 0.1
        links = np.array([segment_distance(a, b, center) for a, b in itertools.pairwise(nodes)]) - 0.1
        if min(*joints, *links) < 0.05:
            continue
        wanted = {"joints": joints, "links": links, "both": np.concatenate([joints, links])}[bodies]
        assert at(ik, q).cost == pytest.approx(-np.log(wanted).sum(), abs=PAPER)
        numeric = differences(lambda p: at(ik, p).cost, robot, q)[0]
        assert at(ik, q).gradient == pytest.approx(numeric, abs=DIFFERENCES * 10)


def nearest(robot, q, center):
    return min(np.linalg.norm(robot.position(q, frame) - center) for frame in robot.moving_frames)


@pytest.mark.quick(1)
@pytest.mark.parametrize("name", ["planar", "dh", "ball"])
def test_a_step_against_the_gradient_increases_the_distance(name, rng):
    robot = {"planar": planar(4), "dh": dh_arm(6, 2), "ball": ball_arm()}[name]
    for _ in range(5):
        q = robot.random_configuration(rng)
        beside = robot.position(q, robot.moving_frames[-2]) + 0.02 * rng.standard_normal(robot.dimension)
        gradient = at(solver(robot, jtik.Point(beside)), q).gradient
        there = robot.integrate(q, -1e-4 * gradient / np.linalg.norm(gradient))
        assert nearest(robot, there, beside) > nearest(robot, q, beside)


def test_against_the_gradient_the_product_of_distances_grows(rng):
    """Along -grad H the product of all distances grows, which is what H measures."""
    robot, center = planar(5), np.array([2.0, 1.0])
    ik = solver(robot, jtik.Point(center))
    for _ in range(10):
        q = robot.random_configuration(rng)
        there = q - 1e-6 * at(ik, q).gradient
        before, after = (np.linalg.norm(planar_points(p) - center, axis=1).prod() for p in (q, there))
        assert after > before


def test_the_force_of_each_obstacle_points_away_from_it_and_the_sum_need_not():
    """The tip between a near obstacle and a far one in line: the near one pushes it towards the far one."""
    robot, q = planar(2), np.array([0.3, 0.9])
    tip, J = planar_points(q)[-1], planar_jacobian(q)
    along = np.array([0.6, 0.8])
    near, far = tip - 0.2 * along, tip + 1.0 * along

    def force(*centers):
        """-dH/dp of the tip: J' times it is -dH/dq without the share of the other joint."""
        points = [jtik.Point(center) for center in centers]
        pull = -at(solver(robot, points), q).gradient
        others = sum((elbow - c) / ((elbow - c) @ (elbow - c)) for c in centers for elbow in [planar_points(q)[0]])
        return np.linalg.solve(J.T, pull - joint_jacobian(q, 0).T @ others)

    assert force(near) @ along == pytest.approx(5)
    assert force(far) @ along == pytest.approx(-1)
    assert force(near, far) @ along == pytest.approx(4)  # towards the far one


@pytest.mark.parametrize(("bodies", "smooth"), [("joints", True), ("links", False), ("both", False)])
def test_the_hessian_jumps_where_the_closest_point_leaves_the_end_of_a_link(bodies, smooth):
    """One link, and an obstacle beside its end: on one side the closest point is the end, on the other before it."""
    robot = planar(1)
    ik = solver(robot, jtik.Point((1.0, 0.4)), bodies=bodies)
    corner = np.arctan2(0.4, 1.0) - np.arccos(1 / np.hypot(1.0, 0.4))  # at 0: the obstacle is beside the end
    slope = {side: [at(ik, [corner + side * h]).gradient[0] for h in (1e-6, 2e-6)] for side in (-1, 1)}
    below, above = ((far - near) / (side * 1e-6) for side, (near, far) in slope.items())
    assert slope[-1][0] == pytest.approx(slope[1][0], abs=1e-4)  # once differentiable
    assert (abs(below - above) < 1e-2) == smooth


@pytest.mark.thinned
@pytest.mark.parametrize("depth", [1e-9, 1e-4, 0.1, 0.49])
@pytest.mark.parametrize("bodies", ["joints", "links", "both"])
def test_inside_an_obstacle_the_force_is_finite_and_points_outwards(depth, bodies):
    robot = planar(3)
    q = np.array([0.4, 0.5, -0.6])
    outward = np.array([0.6, 0.8])
    # the circle's edge passes the tip at that depth, and nothing else is near
    center = robot.position(q) - (0.5 - depth) * outward
    if bodies != "joints":
        center = robot.position(q) + (0.5 - depth) * np.array([np.cos(0.3), np.sin(0.3)])
    ik = solver(robot, jtik.Circle(center, 0.5), bodies=bodies)
    found = at(ik, q)
    assert np.isfinite(found.cost)
    assert np.isfinite(found.gradient).all()
    step = -1e-9 * found.gradient / np.linalg.norm(found.gradient)
    before, after = (np.linalg.norm(robot.position(p) - center) for p in (q, q + step))
    assert after > before


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("frame", "bodies", "radius"),
    [
        (frame, bodies, [0.0, 0.3][(row + column) % 2])
        for row, frame in enumerate(["link2", "link3", "tip"])
        for column, bodies in enumerate(["joints", "links", "both"])
    ],
)
def test_an_obstacle_exactly_on_a_joint_is_finite_and_the_solve_ends(bodies, radius, frame):
    robot = planar(4)
    q = np.array([0.4, 0.3, 0.2, 0.1])
    ik = solver(robot, jtik.Circle(robot.position(q, frame), radius), bodies=bodies)
    found = at(ik, q)
    assert np.isfinite(found.cost)
    assert np.isfinite(found.gradient).all()
    solution = ik.solve(robot.position(q), q0=q, max_iterations=200)
    assert np.isfinite(solution.q).all()
    assert solution.status is not jtik.Status.NOT_FINITE


@pytest.mark.thinned
@pytest.mark.parametrize("name", ["dh", "ball"])
@pytest.mark.parametrize("bodies", ["joints", "links", "both"])
def test_spheres_in_space(name, bodies, rng):
    robot = {"dh": dh_arm(6, 2), "ball": ball_arm()}[name]
    spheres = [jtik.Sphere((1.5, 0.5, 1.0), 0.1), jtik.Point((-1.0, -1.2, 0.5))]
    ik = solver(robot, spheres, bodies=bodies, gain=0.4)
    for _ in range(5):
        q = robot.random_configuration(rng)
        found = at(ik, q)
        if bodies == "joints":
            H = 0.0
            for frame in robot.moving_frames:
                for sphere in spheres:
                    H -= 0.4 * np.log(np.linalg.norm(robot.position(q, frame) - sphere.center) - sphere.radius)
            assert found.cost == pytest.approx(H, abs=PAPER)
        numeric = differences(lambda p: at(ik, p).cost, robot, q)[0]
        assert found.gradient == pytest.approx(numeric, abs=10 * DIFFERENCES)


def test_shapes_are_kept_away_by_their_surfaces(rng):
    """Each capsule's distance by sampling its axis; a box counts as the capsule about it."""
    arm = dh_arm(3, 2)
    pose = np.eye(4)
    pose[:3, 3] = 0.1, 0.0, 0.05
    shapes = {
        "base": [jtik.Sphere((0, 0, 0), 0.2)],
        "link1": [jtik.Capsule((0, 0, 0), (0.3, 0, 0.1), 0.05), jtik.Sphere((0.1, 0.1, 0), 0.08)],
        "link2": [jtik.Box(pose, (0.1, 0.03, 0.04))],
        "tip": [jtik.Cylinder((0, 0, 0), (0, 0, 0.2), 0.03)],
    }
    robot = jtik.Robot(arm.joints, shapes=shapes)
    segments = [
        ("link1", (0, 0, 0), (0.3, 0, 0.1), 0.05),
        ("link1", (0.1, 0.1, 0), (0.1, 0.1, 0), 0.08),
        ("link2", (0, 0, 0.05), (0.2, 0, 0.05), 0.05),
        ("tip", (0, 0, 0), (0, 0, 0.2), 0.03),
    ]
    sphere = jtik.Sphere((1.2, 0.4, 1.0), 0.1)
    ik = solver(robot, [sphere], bodies="shapes", gain=0.4)
    for _ in range(5):
        q = robot.random_configuration(rng)
        H = 0.0
        for frame, start, end, radius in segments:
            T = robot.pose(q, frame)
            along = np.linspace(start, end, 20001) @ T[:3, :3].T + T[:3, 3]
            H -= 0.4 * np.log(np.linalg.norm(along - sphere.center, axis=1).min() - radius - sphere.radius)
        assert at(ik, q).cost == pytest.approx(H, abs=1e-7)
        numeric = differences(lambda p: at(ik, p).cost, robot, q)[0]
        assert at(ik, q).gradient == pytest.approx(numeric, abs=10 * DIFFERENCES)


@pytest.mark.parametrize("bodies", ["shapes", "spheres"])
def test_shapes_need_a_robot_with_solids(bodies):
    with pytest.raises(jtik.ArgumentError, match="bodies.*solids.*none that moves"):
        solver(dh_arm(3, 2), [jtik.Sphere((1, 0, 0), 0.1)], bodies=bodies)


def test_the_chassis_of_a_vehicle_as_balls_is_thinner_than_as_a_capsule():
    """A sphere above its middle: the capsule overlaps it, the balls do not."""
    robot = jtik.Robot(jtik.Robot.vehicle(2).joints, shapes={"vehicle": [jtik.Box.at((0, 0, 0), (0.4, 0.3, 0.1))]})
    sphere = jtik.Sphere((0.0, 0.0, 0.5), 0.2)
    q = np.zeros(robot.nq)
    smallest = {}
    for bodies in ("shapes", "spheres"):
        measure = ObstacleAvoidance(sphere, bodies=bodies, gain=1.0, floor=1e-3)
        assert len(measure.rounding(robot, {"centers": casadi.SX(1, 3), "radii": casadi.SX([0.2])})) == len(
            measure.body_names(robot)
        )
        smallest[bodies] = SoftClearance(sphere, bodies=bodies, smoothing=1e-4)(q, robot)
    assert -smallest["shapes"] == pytest.approx(0.3 - np.sqrt(0.1), abs=1e-3)
    assert -smallest["spheres"] > 0.12


def test_live_parameters_act_as_if_built_with_them(rng):
    robot = planar(6)
    changed = solver(robot, [jtik.Circle((4, 2), 0.6), jtik.Point((9, 9))])
    built = solver(robot, [jtik.Circle((2, 3), 0.1), jtik.Circle((4, -1), 0.2)], gain=0.3)
    changed.parameters["obstacle_avoidance.centers"] = [(2, 3), (4, -1)]
    changed.parameters["obstacle_avoidance.radii"] = [0.1, 0.2]
    changed.parameters["obstacle_avoidance.gain"] = 0.3
    q0 = rng.uniform(-0.5, 0.5, 6)
    target = robot.position(rng.uniform(-0.5, 0.5, 6))
    assert changed.solve(target, q0=q0).q.tolist() == built.solve(target, q0=q0).q.tolist()


def potential(distance, floor):
    """-ln d, below the floor its second-order expansion about the floor."""
    below = max(0.0, 1 - distance / floor)
    return -np.log(max(distance, floor)) + below + below**2 / 2


@pytest.mark.quick(1)
@pytest.mark.parametrize("floor", [0.01, 0.1])
def test_below_the_floor_the_logarithm_goes_on_as_its_second_order_expansion(floor):
    robot = planar(2)
    for distance in (2 * floor, floor, 0.9 * floor, 1e-6, -floor, -3 * floor):
        ik = solver(robot, jtik.Circle((2.5 + distance, 0.0), 0.5), floor=floor)
        expected = potential(distance, floor) + potential(1 + distance, floor)
        assert at(ik, [0.0, 0.0]).cost == pytest.approx(expected, abs=PAPER)


@pytest.mark.parametrize("edge", [0.01, 0.0])
def test_the_potential_is_smooth_across_the_floor_and_the_surface(edge):
    """Value and force are continuous."""
    ik = solver(planar(2), jtik.Circle((0.0, 0.0), 0.5))
    samples = []
    for side in (-1e-7, 1e-7):
        ik.parameters["obstacle_avoidance.centers"] = [(2.0, 0.5 + edge + side)]
        found = at(ik, [0.0, 0.0])
        samples.append([found.cost, *found.gradient])
    # the force is 1 / floor = 100 and changes by up to 1 / floor^2 = 1e4 a metre
    assert samples[0] == pytest.approx(samples[1], abs=1e-2)
    assert samples[0][2] > 50


def test_a_solution_has_larger_distances_than_without():
    robot, q0, target = planar(10), np.full(10, 0.1), (6.0, 3.0)
    centering = jtik.criteria["joint_centering"]()
    without = shared_solver(robot, jtik.FrameTask(), criteria=centering).solve(target, q0=q0)
    center = planar_points(without.q)[4] + (0.05, 0.3)  # beside the elbow of that solution
    avoiding = centering + ObstacleAvoidance(jtik.Circle(center, 0.25), bodies="both")
    avoided = shared_solver(robot, jtik.FrameTask(), criteria=avoiding).solve(target, q0=q0)
    assert without.converged
    assert avoided.converged
    clearances = [np.linalg.norm(planar_points(s.q) - center, axis=1).min() - 0.25 for s in (without, avoided)]
    assert clearances[1] > clearances[0] + 0.1


class TestInvalidInput:
    @pytest.mark.parametrize(
        ("options", "argument"),
        [
            ({"obstacles": ["box"]}, "obstacles"),
            ({"obstacles": [jtik.Point((1, 1))] * 3, "capacity": 2}, "obstacles"),
            ({"capacity": 0}, "capacity"),
            ({"capacity": {"ball": 0}}, "capacity"),
            ({"capacity": {"ball": -1}}, "capacity['ball']"),
            ({"bodies": "elbows"}, "bodies"),
            ({"gain": -1.0}, "gain"),
            ({"gain": np.nan}, "gain"),
            ({"floor": 0.0}, "floor"),
            ({"floor": -1e-3}, "floor"),
            ({"floor": np.nan}, "floor"),
        ],
    )
    def test_arguments_out_of_range(self, options, argument):
        with pytest.raises(jtik.ArgumentError) as caught:
            ObstacleAvoidance(**{"obstacles": jtik.Point((1, 1)), **options})
        assert caught.value.argument == argument

    def test_obstacles_of_another_dimension(self):
        with pytest.raises(jtik.ArgumentError, match="obstacles.*2-dimensional"):
            solver(planar(3), jtik.Sphere((1, 1, 1), 0.1))
        with pytest.raises(jtik.ArgumentError, match="obstacles.*3-dimensional"):
            solver(dh_arm(), jtik.Circle((1, 1), 0.1))
