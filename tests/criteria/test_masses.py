"""GravityTorque, KineticEnergy, EffectiveMass and SupportPolygon."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import jtik
from jtik.robot import Mass
from jtik_formulations import EffectiveMass, GravityTorque, KineticEnergy, MinimumDisplacement, SupportPolygon

from ..conftest import ball_arm, dh_arm, floating_arm, planar, shared_solver, weighted
from .derivatives import panda, ten_links

SQUARE = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]


class TestGravityTorque:
    def test_it_is_half_the_squared_torques_over_the_effort_limits(self, rng):
        robot, q = panda(), panda().random_configuration(rng)
        torque = robot.gravity_torque(q)
        assert GravityTorque()(q, robot) == pytest.approx(((torque / robot.effort_limit) ** 2).sum() / 2)
        assert GravityTorque(2.0)(q, robot) == pytest.approx((torque**2).sum() / 8)
        scale = rng.uniform(1, 2, robot.n)
        assert GravityTorque(scale)(q, robot) == pytest.approx(((torque / scale) ** 2).sum() / 2)
        one = {"panda_joint2": 10.0}
        wanted = robot.effort_limit.copy()
        wanted[1] = 10.0
        assert GravityTorque(one)(q, robot) == pytest.approx(((torque / wanted) ** 2).sum() / 2)

    def test_without_effort_limits_the_scale_is_one(self, rng):
        robot = weighted(dh_arm(6, 3))
        q = robot.random_configuration(rng)
        assert GravityTorque()(q, robot) == pytest.approx((robot.gravity_torque(q) ** 2).sum() / 2)

    def test_gravity_is_live(self, rng):
        robot, g = panda(), np.array([3.0, -1.0, 2.0])
        q = robot.random_configuration(rng)
        assert GravityTorque()(q, robot, gravity=g) == GravityTorque(gravity=g)(q, robot)
        assert GravityTorque()(q, robot, gravity=-g) == pytest.approx(GravityTorque()(q, robot, gravity=g))
        assert GravityTorque()(q, robot, gravity=np.zeros(3)) == 0
        assert GravityTorque(gravity=g)(q, robot) == pytest.approx(
            ((robot.gravity_torque(q, gravity=g) / robot.effort_limit) ** 2).sum() / 2
        )

    def test_a_free_base_has_no_motor(self, rng):
        robot = weighted(floating_arm())
        q = robot.random_configuration(rng)
        torque = robot.gravity_torque(q)
        assert GravityTorque()(q, robot) == pytest.approx((torque[6:] ** 2).sum() / 2)
        assert GravityTorque(3.0)(q, robot) == pytest.approx((torque[6:] ** 2).sum() / 18)
        assert GravityTorque(np.ones(robot.n))(q, robot) == pytest.approx((torque**2).sum() / 2)

    def test_an_arm_hangs_or_stands(self):
        """Straight down and straight up have no torques; a solve ends at one of them."""
        robot = ten_links()
        for angle in (-math.pi / 2, math.pi / 2):
            assert GravityTorque()([angle, *[0.0] * 9], robot) == pytest.approx(0.0, abs=1e-20)
        free = planar(3).with_masses(dict.fromkeys(("link2", "link3", "tip"), 1.0))
        ik = shared_solver(
            free,
            jtik.FrameTask(free.tip, "position", axes="x"),
            criteria=GravityTorque(),
            strategy="hybrid+second_order",
        )
        solution = ik.solve([0.0, 0.0], q0=[-1.2, -0.5, 0.3], until="stationary")
        assert solution.cost < 1e-12

    def test_a_load_counts(self):
        robot, T = panda(), np.eye(4)
        loaded = robot.with_tool(T, mass=3.0)
        difference = loaded.gravity_torque(robot.home) - robot.gravity_torque(robot.home)
        assert difference == pytest.approx(3 * 9.81 * robot.jacobian(robot.home)[2])
        assert GravityTorque()(robot.home, loaded) > GravityTorque()(robot.home, robot)


class TestKineticEnergy:
    def test_it_is_the_energy_of_the_displacement(self, rng):
        robot = panda()
        q, reference = robot.random_configuration(rng), robot.random_configuration(rng)
        d, M = q - reference, robot.mass_matrix(q)
        assert KineticEnergy(reference)(q, robot) == pytest.approx(d @ M @ d / 2)
        more = rng.uniform(0, 1, robot.n)
        assert KineticEnergy(reference, rotor_inertia=more)(q, robot) == pytest.approx(d @ (M + np.diag(more)) @ d / 2)
        assert KineticEnergy()(robot.home, robot) == 0

    @pytest.mark.parametrize("robot", [ball_arm, floating_arm])
    def test_of_a_small_motion_it_is_the_energy_of_the_velocity(self, robot, rng):
        body = weighted(robot())
        reference, v = body.random_configuration(rng), rng.standard_normal(body.n)
        step = 1e-5
        energy = KineticEnergy(reference)(body.integrate(reference, step * v), body)
        assert energy == pytest.approx(step**2 * v @ body.mass_matrix(reference) @ v / 2, rel=1e-3)

    def test_of_equal_inertias_it_is_the_minimum_displacement(self, rng):
        """A wheel on every axis of a robot without other masses: M is constant and diagonal."""
        robot = jtik.Robot.planar(1).with_masses({"link1": Mass(1e-9, np.zeros(3), np.diag([0, 0, 2.0]))})
        assert KineticEnergy([0.3])([1.1], robot) == pytest.approx(MinimumDisplacement([0.3], 2.0)([1.1], robot))

    def test_heavy_joints_move_less_than_with_the_minimum_displacement(self):
        robot = jtik.Robot.builtin("vehicle_panda")
        target = robot.pose(robot.home)
        target[:3, 3] += [0.05, -0.1, -0.1]
        moved = {}
        for criterion in (MinimumDisplacement(), KineticEnergy()):
            ik = shared_solver(robot, jtik.FrameTask(), criteria=criterion)
            moved[criterion.name] = ik.solve(target, q0=robot.home, until="stationary").q - robot.home
        vehicle = {name: np.abs(d[:2]).max() for name, d in moved.items()}
        assert vehicle["kinetic_energy"] < 0.3 * vehicle["minimum_displacement"]


class TestEffectiveMass:
    def test_it_is_half_the_logarithm_of_khatibs_mass(self, rng):
        robot, u = panda(), np.array([0.6, 0.8, 0.5])
        q = robot.random_configuration(rng)
        n, J = u / np.linalg.norm(u), robot.jacobian(q, rows="linear")
        mass = 1 / (n @ J @ np.linalg.inv(robot.mass_matrix(q) + 1e-4 * np.eye(robot.n)) @ J.T @ n)
        assert EffectiveMass(u)(q, robot) == pytest.approx(math.log(mass) / 2, abs=1e-5)
        rotors = rng.uniform(0.1, 0.5, robot.n)
        mass = 1 / (n @ J @ np.linalg.inv(robot.mass_matrix(q) + np.diag(rotors)) @ J.T @ n)
        assert EffectiveMass(u, rotor_inertia=rotors)(q, robot) == pytest.approx(math.log(mass) / 2, abs=1e-5)

    def test_a_sled_has_its_mass(self):
        robot = jtik.Robot.vehicle([1.0, 1.0]).with_masses({"slide_x": 7.0, "link1": 1e-3, "link2": 1e-3, "tip": 1e-3})
        sled = robot.subset(["x"])
        total = 7.0 + 3e-3 + 1e-4
        assert EffectiveMass([1, 0])([0.3], sled) == pytest.approx(math.log(total) / 2, abs=1e-5)

    def test_a_point_mass_at_the_tip_is_felt_across_the_link(self):
        robot = planar(1).with_masses({"tip": 4.0})
        assert EffectiveMass([0, 1])([0.0], robot) == pytest.approx(math.log(4.0) / 2, abs=1e-4)

    def test_where_the_frame_cannot_move_it_levels_off(self):
        robot = planar(1).with_masses({"tip": 4.0})
        assert EffectiveMass([1, 0])([0.0], robot) == pytest.approx(math.log(1e6) / 2)
        assert np.isfinite(EffectiveMass([1, 0]).gradient([0.0], robot)).all()

    def test_masses_on_the_axis_of_a_joint_are_finite(self):
        """A point mass on the axis has no inertia about it, so that M is singular."""
        robot = planar(2).with_masses({"link2": 1.0, "tip": 1e-300})
        assert math.isfinite(EffectiveMass([0, 1], rotor_inertia=0.0)([0.1, 0.2], robot))

    def test_a_solve_makes_the_arm_lighter(self):
        robot = panda()
        ik = shared_solver(robot, jtik.FrameTask(), criteria=EffectiveMass([1, 0, 0]))
        before = EffectiveMass([1, 0, 0])(robot.home, robot)
        solution = ik.solve(robot.pose(robot.home), q0=robot.home, until="stationary")
        assert solution.cost < before - 0.05


@functools.cache
def made(vertices, margin):
    """Compiled once."""
    return SupportPolygon(vertices, margin=margin)


class TestSupportPolygon:
    """One heavy joint in the plane: the centre of mass is where x and y put it."""

    robot = jtik.Robot.vehicle([1.0]).with_masses({"vehicle": 1.0})

    def at(self, point, *, vertices=SQUARE, margin=0.2):
        return made(tuple(vertices), margin)([*point, 0.0], self.robot)

    @pytest.mark.parametrize("point", [(0, 0), (0.8, 0.0), (-0.8, 0.8), (0.79, -0.79)])
    def test_it_is_zero_inside_by_the_margin(self, point):
        assert self.at(point) == pytest.approx(0, abs=1e-30)

    @pytest.mark.parametrize(
        ("x", "wanted"),
        [(0.9, 0.5**3 / 6), (1.0, 1 / 6), (1.5, 3.5**2 / 2 - 3.5 / 2 + 1 / 6)],
        ids=["in the margin", "on the edge", "outside"],
    )
    def test_beyond_one_edge(self, x, wanted):
        for point in ((x, 0), (-x, 0), (0, x), (0, -x)):
            assert self.at(point) == pytest.approx(wanted)

    def test_the_order_of_the_corners_does_not_matter(self, rng):
        for point in rng.uniform(-2, 2, (10, 2)):
            assert self.at(point, vertices=SQUARE[::-1]) == pytest.approx(self.at(point))
            assert self.at(point, vertices=[*SQUARE[1:], SQUARE[0]]) == pytest.approx(self.at(point))

    def test_it_grows_on_the_way_out(self, rng):
        triangle = [(0.0, 0.0), (1.0, 0.2), (0.3, 0.9)]
        for direction in rng.standard_normal((8, 2)):
            away = [
                self.at(np.mean(triangle, axis=0) + s * direction, vertices=triangle) for s in np.linspace(0, 3, 40)
            ]
            assert np.all(np.diff(away) >= -1e-12)
            assert away[-1] > 0

    def test_a_live_margin_of_zero_counts_as_a_millimetre(self):
        criterion, q = made(tuple(SQUARE), 0.2), [0.9995, 0.0, 0.0]
        assert criterion(q, self.robot, margin=0.0) == pytest.approx(0.5**3 / 6)

    def test_a_corner_that_is_repeated_counts_once(self):
        criterion, q = SupportPolygon(SQUARE, margin=0.2), [1.4, 0.3, 0.0]
        triangle = [(-1.0, -1.0), (1.0, -1.0), (0.0, 1.0)]
        live = criterion(q, self.robot, vertices=[*triangle, triangle[-1]])
        assert live == pytest.approx(SupportPolygon(triangle, margin=0.2)(q, self.robot))

    def test_the_polygon_moves_with_its_frame(self, rng):
        robot = jtik.Robot.builtin("vehicle_panda")
        corners = [(0.4, 0.3), (-0.4, 0.3), (-0.4, -0.3), (0.4, -0.3)]
        criterion = SupportPolygon(corners, margin=0.5, frame="vehicle")
        q = robot.random_configuration(rng)
        moved = q.copy()
        moved[:3] += 3.0, -2.0, 1.3
        assert criterion(moved, robot) == pytest.approx(criterion(q, robot))
        assert criterion(q, robot) > 0

    def test_a_solve_brings_the_centre_of_mass_back(self):
        robot = jtik.Robot.builtin("panda")
        polygon = [(-0.2, -0.2), (0.0, -0.2), (0.0, 0.2), (-0.2, 0.2)]
        ik = shared_solver(robot, jtik.FrameTask(kind="position"), criteria=SupportPolygon(polygon), strategy="hybrid")
        q0 = robot.home
        assert SupportPolygon(polygon)(q0, robot) > 0
        solution = ik.solve(robot.position(q0), q0=q0, until="stationary")
        assert solution.cost < SupportPolygon(polygon)(q0, robot)

    @pytest.mark.parametrize(
        "vertices",
        [
            [(0, 0), (1, 0)],
            [(0, 0), (1, 0), (2, 0)],
            [(0, 0), (1, 0), (1, 0), (0, 1)],
            [(0, 0), (2, 0), (0.5, 0.5), (0, 2)],
            [(0, 0), (1, 1), (1, 0), (0, 1)],
            [(math.cos(a), math.sin(a)) for a in np.arange(5) * 4 * math.pi / 5],
            [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
            "square",
        ],
        ids=["two", "no area", "repeated", "not convex", "crossed", "star", "in space", "text"],
    )
    def test_what_is_no_convex_polygon_is_refused(self, vertices):
        with pytest.raises(jtik.ArgumentError, match=r"^vertices: .*accepted: at least three corners \(k, 2\)"):
            SupportPolygon(vertices)


@pytest.mark.parametrize(
    "criterion", [GravityTorque(), KineticEnergy(), EffectiveMass([1, 0, 0]), SupportPolygon(SQUARE)]
)
class TestWithoutMasses:
    def test_the_links_are_named(self, criterion):
        robot = jtik.Robot.builtin("iiwa14")
        links = (
            "without a mass on or after iiwa_link_1, iiwa_link_2" if criterion.name != "support_polygon" else "iiwa14"
        )
        with pytest.raises(jtik.ArgumentError, match=f"robot: given .*{links}.*Robot.with_masses"):
            jtik.InverseKinematics(robot, jtik.FrameTask(), criteria=criterion)

    @pytest.mark.quick(1)
    def test_with_masses_it_is_accepted(self, criterion):
        arm = jtik.Robot.builtin("iiwa14")
        robot = arm.with_masses({frame: Mass(2.0, [0.0, 0.02, 0.05]) for frame in arm.massless_frames})
        ik = shared_solver(robot, jtik.FrameTask(), criteria=criterion)
        solution = ik.solve(robot.pose(robot.home))
        assert solution.status in (jtik.Status.CONVERGED, jtik.Status.REACHED)


def test_joints_beyond_the_last_mass_are_named():
    robot = planar(3).with_masses({"link2": 1.0})
    with pytest.raises(
        jtik.ArgumentError, match=r"without a mass on or after link3; accepted: a mass beyond every joint"
    ):
        GravityTorque()([0.1, 0.2, 0.3], robot)
    locked = robot.subset(["joint1", "joint2"])
    assert GravityTorque()([0.1, 0.2], locked) > 0


class TestWrongArguments:
    def test_gravity_torque(self):
        robot = weighted(planar(2))
        for scale in (0.0, -1.0, [1.0, 0.0], {"joint1": -2.0}):
            with pytest.raises(jtik.ArgumentError, match=r"^scale.*positive"):
                GravityTorque(scale)
        with pytest.raises(jtik.ArgumentError, match=r"^scale"):
            GravityTorque([1.0, 2.0, 3.0])([0.1, 0.2], robot)
        with pytest.raises(jtik.ArgumentError, match=r"^gravity"):
            GravityTorque(gravity=[0.0, 0.0, -9.81])([0.1, 0.2], robot)
        with pytest.raises(jtik.UnknownNameError, match="joint9"):
            GravityTorque({"joint9": 1.0})([0.1, 0.2], robot)
        ik = shared_solver(robot, jtik.FrameTask(kind="position"), criteria=GravityTorque())
        with pytest.raises(jtik.ArgumentError, match="non-negative"):
            ik.parameters["gravity_torque.inverse_scale"] = [-1.0, 1.0]

    def test_kinetic_energy_and_effective_mass(self):
        robot = weighted(planar(2))
        for criterion in (KineticEnergy, lambda **given: EffectiveMass([1, 0], **given)):
            with pytest.raises(jtik.ArgumentError, match=r"^rotor_inertia.*non-negative"):
                criterion(rotor_inertia=-1.0)
            with pytest.raises(jtik.ArgumentError, match=r"^rotor_inertia"):
                criterion(rotor_inertia=[1.0, 2.0, 3.0])([0.1, 0.2], robot)
        with pytest.raises(jtik.ArgumentError, match=r"^direction.*not all zero"):
            EffectiveMass([0.0, 0.0])
        with pytest.raises(jtik.ArgumentError, match=r"^direction"):
            EffectiveMass([0.0, 0.0, 1.0])([0.1, 0.2], robot)
        with pytest.raises(jtik.UnknownNameError, match="hand"):
            EffectiveMass([0.0, 1.0], "hand")([0.1, 0.2], robot)
        with pytest.raises(jtik.ArgumentError, match=r"^reference"):
            KineticEnergy([0.1, 0.2, 0.3])([0.1, 0.2], robot)

    def test_support_polygon(self):
        with pytest.raises(jtik.ArgumentError, match=r"^margin: given 0.0; accepted: a positive distance"):
            SupportPolygon(SQUARE, margin=0.0)
        with pytest.raises(jtik.UnknownNameError, match="hand"):
            SupportPolygon(SQUARE, frame="hand")([0.1, 0.2], weighted(planar(2)))
        with pytest.raises(jtik.ArgumentError, match=r"^vertices: given .*; accepted: at least three corners"):
            SupportPolygon(SQUARE)([0.1, 0.2], weighted(planar(2)), vertices=[SQUARE[i] for i in (0, 2, 1, 3)])
