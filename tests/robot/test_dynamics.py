"""Gravity torques and the mass matrix against MuJoCo, against energies, and in closed form."""

from __future__ import annotations

import math
import pickle

import casadi
import mujoco
import numpy as np
import pytest

import jtik
from jtik.interop.mujoco_model import MujocoCorrespondence, to_mujoco
from jtik.interop.urdf import to_urdf
from jtik.robot import JointType, Mass, Mimic

from ..conftest import ball_arm, dh_arm, differences, floating_arm, planar, random_mass, weighted

AGREEMENT = 1e-10
"""[N m], [kg m^2]: rounding along chains of metres and kilograms."""
FAR_AWAY = 1e-9
"""[kg m^2]: positions of 1e4 m have errors of 2e-12 m, which masses of 180 kg at lengths of a metre multiply."""
NEGLIGIBLE_MASSES = 1e-7
"""[N m], [kg m^2]: `to_mujoco` gives 1e-9 kg and 1e-9 kg m^2 to frames without masses."""


def follower_arm():
    """A prismatic leader and followers of both types, on branches, with masses on fixed frames."""
    x, z = np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    shift = np.eye(4)
    shift[:3, 3] = 0.2, -0.1, 0.4
    return jtik.Robot(
        [
            jtik.Joint("turn", JointType.REVOLUTE, "base", "a", axis=z),
            jtik.Joint("lean", JointType.REVOLUTE, "a", "b", origin=shift, axis=x),
            jtik.Joint("left", JointType.PRISMATIC, "b", "l", origin=shift, axis=x, lower=-0.3, upper=0.3),
            jtik.Joint("right", JointType.PRISMATIC, "b", "r", axis=z, mimic=Mimic("left", -2.0, 0.1)),
            jtik.Joint("after", JointType.REVOLUTE, "l", "m", origin=shift, axis=x, mimic=Mimic("lean", 0.5)),
            jtik.Joint("weld", JointType.FIXED, "m", "tip", origin=shift),
        ],
        name="followers",
    )


ROBOTS = {
    "planar": lambda: weighted(planar(4)),
    "vehicle": lambda: weighted(jtik.Robot.vehicle(3, heading=True)),
    "dh": lambda: weighted(dh_arm(6, 3)),
    "ball": lambda: weighted(ball_arm()),
    "floating": lambda: weighted(floating_arm()),
    "followers": lambda: weighted(FOLLOWERS),
    "panda": lambda: jtik.Robot.builtin("panda"),
    "vehicle_panda": lambda: jtik.Robot.builtin("vehicle_panda"),
}
FOLLOWERS = follower_arm()


@pytest.fixture(params=ROBOTS)
def robot(request):
    return ROBOTS[request.param]()


def mujoco_dynamics(robot, q, gravity):
    """M and the gravity torque by MuJoCo, in the robot's velocities."""
    model = to_mujoco(robot)
    model.opt.gravity[:] = gravity
    correspondence, data = MujocoCorrespondence(robot, model), mujoco.MjData(model)
    data.qpos[:] = correspondence.qpos(q)
    mujoco.mj_forward(model, data)
    columns = []
    for unit in np.eye(model.nv):
        column = np.zeros(model.nv)
        mujoco.mj_mulM(model, data, column, unit)
        columns.append(column)
    moves = correspondence.moves
    return moves.T @ np.array(columns) @ moves, moves.T @ data.qfrc_bias


@pytest.mark.quick(3)
def test_mujoco_has_the_same_dynamics(robot, rng):
    gravity = np.array([1.0, -2.0, 0.0 if robot.dimension == 2 else -9.0])
    for _ in range(4):
        q = robot.random_configuration(rng)
        M, torque = mujoco_dynamics(robot, q, gravity)
        assert robot.mass_matrix(q) == pytest.approx(M, abs=NEGLIGIBLE_MASSES)
        assert robot.gravity_torque(q, gravity=gravity[: robot.dimension]) == pytest.approx(
            torque, abs=NEGLIGIBLE_MASSES
        )


def test_the_gravity_torque_is_the_gradient_of_the_potential_energy(robot, rng):
    total = sum(mass.mass for mass in robot.masses.values())
    up = robot.dimension - 1
    for _ in range(3):
        q = robot.random_configuration(rng)
        slope = differences(lambda at: 9.81 * total * robot.center_of_mass(at)[up], robot, q)[0]
        assert robot.gravity_torque(q) == pytest.approx(slope, abs=1e-6)
    moment = differences(lambda at: total * robot.center_of_mass(at), robot, q)
    along = np.arange(1.0, robot.dimension + 1)
    assert robot.gravity_torque(q, gravity=along) == pytest.approx(-moment.T @ along, abs=1e-6)


def test_the_mass_matrix_is_symmetric_and_positive_definite(robot, rng):
    for _ in range(3):
        M = robot.mass_matrix(robot.random_configuration(rng))
        assert np.array_equal(M, M.T)
        assert np.linalg.eigvalsh(M)[0] > 0


def test_a_pendulum_in_closed_form():
    rod = Mass(2.0, [0.5, 0, 0], np.diag([0.0, 2 / 12, 2 / 12]))
    arm = jtik.Robot.planar(1).with_masses({"link1": rod, "tip": 3.0})
    angle = 0.7
    assert arm.mass_matrix([angle]) == pytest.approx(np.array([[2 / 3 + 3]]))
    assert arm.gravity_torque([angle]) == pytest.approx([9.81 * math.cos(angle) * (2 * 0.5 + 3)])
    assert arm.gravity_torque([angle], gravity=[0.0, 0.0]) == pytest.approx([0.0])


def test_a_robot_far_away_loses_no_digits():
    robot = jtik.Robot.builtin("vehicle_panda")
    q = robot.home.copy()
    near = robot.mass_matrix(q)
    q[:2] = 1e4, -1e4
    assert robot.mass_matrix(q) == pytest.approx(near, abs=FAR_AWAY)


class TestSymbols:
    def test_the_expressions_are_the_numbers(self, robot, rng):
        q, at = casadi.SX.sym("q", robot.nq), robot.random_configuration(rng)
        gravity = np.arange(1.0, robot.dimension + 1)
        results = [robot.gravity_torque(q, gravity=gravity), robot.mass_matrix(q), robot.at(q).gravity_torque()]
        torque, M, standard = (np.array(each) for each in casadi.Function("f", [q], results)(at))
        assert torque.shape == standard.shape == (robot.n, 1)
        assert torque[:, 0] == pytest.approx(robot.gravity_torque(at, gravity=gravity), abs=AGREEMENT)
        assert standard[:, 0] == pytest.approx(robot.gravity_torque(at), abs=AGREEMENT)
        assert pytest.approx(robot.mass_matrix(at), abs=AGREEMENT) == M

    def test_they_are_there_within_a_criterion(self):
        robot = weighted(planar(3))

        @jtik.criterion
        def effort(q, robot):
            torque, M = robot.gravity_torque(q), robot.mass_matrix(q)
            return torque.T @ torque / 2 + M[0, 0]

        q = robot.random_configuration(0)
        wanted = robot.gravity_torque(q) @ robot.gravity_torque(q) / 2 + robot.mass_matrix(q)[0, 0]
        assert effort(q, robot) == pytest.approx(wanted)
        ik = jtik.InverseKinematics(robot, jtik.FrameTask("tip", "position"), criteria=effort)
        solution = ik.solve(robot.position(q), q0=q, until="stationary")
        assert solution.cost < wanted

    def test_the_energy_is_that_of_the_mass_matrix(self, robot, rng):
        q, v = casadi.SX.sym("q", robot.nq), rng.standard_normal(robot.n)
        at = robot.random_configuration(rng)
        energy = float(casadi.Function("f", [q], [robot.at(q).kinetic_energy(v)])(at))
        assert energy == pytest.approx(v @ robot.mass_matrix(at) @ v / 2)

    def test_an_mx_calls_the_compiled_functions(self):
        robot = ROBOTS["dh"]()
        q, at = casadi.MX.sym("q", robot.nq), robot.random_configuration(0)
        torque, M = casadi.Function("f", [q], [robot.gravity_torque(q), robot.mass_matrix(q)])(at)
        assert np.array(torque)[:, 0] == pytest.approx(robot.gravity_torque(at))
        assert np.array(M) == pytest.approx(robot.mass_matrix(at))


class TestVariants:
    def test_locked_joints_leave_their_rows_out(self):
        robot = weighted(dh_arm(6, 3))
        q = robot.random_configuration(1)
        kept = [0, 2, 5]
        part = robot.subset([robot.joint_names[k] for k in kept], at=q)
        assert part.mass_matrix(q[kept]) == pytest.approx(robot.mass_matrix(q)[np.ix_(kept, kept)], abs=AGREEMENT)
        assert part.gravity_torque(q[kept]) == pytest.approx(robot.gravity_torque(q)[kept], abs=AGREEMENT)

    def test_a_tool_adds_its_own(self, rng):
        robot, tool, T = weighted(dh_arm(6, 3)), random_mass(rng), np.eye(4)
        T[:3, 3] = 0.1, 0.2, 0.3
        q = robot.random_configuration(2)
        J = robot.with_tool(T).jacobian(q)
        R = robot.pose(q)[:3, :3]
        at_center = J[:3] + np.cross(J[3:].T, R @ tool.center).T
        inertia = R @ tool.inertia @ R.T
        more = tool.mass * at_center.T @ at_center + J[3:].T @ inertia @ J[3:]
        assert robot.with_tool(T, mass=tool).mass_matrix(q) == pytest.approx(robot.mass_matrix(q) + more, abs=AGREEMENT)

    def test_a_base_turns_gravity(self):
        robot, T = weighted(dh_arm(6, 3)), np.diag([1.0, -1.0, -1.0, 1.0])
        q = robot.random_configuration(3)
        assert robot.with_base(T).gravity_torque(q) == pytest.approx(-robot.gravity_torque(q), abs=AGREEMENT)
        assert robot.with_base(T).mass_matrix(q) == pytest.approx(robot.mass_matrix(q), abs=AGREEMENT)

    def test_masses_on_a_base_count_for_the_center_of_mass_only(self):
        robot = weighted(dh_arm(6, 3))
        q = robot.random_configuration(4)
        heavy = robot.with_masses({robot.base: 100.0})
        assert np.linalg.norm(heavy.center_of_mass(q) - robot.center_of_mass(q)) > 0.1
        assert heavy.gravity_torque(q) == pytest.approx(robot.gravity_torque(q), abs=AGREEMENT)
        assert heavy.mass_matrix(q) == pytest.approx(robot.mass_matrix(q), abs=AGREEMENT)

    def test_a_pickle_keeps_inertias_and_efforts(self):
        robot = jtik.Robot.builtin("panda")
        again, q = pickle.loads(pickle.dumps(robot)), robot.home
        assert np.array_equal(again.mass_matrix(q), robot.mass_matrix(q))
        assert np.array_equal(again.effort_limit, robot.effort_limit)


class TestFiles:
    def test_urdf(self, rng):
        robot = weighted(FOLLOWERS)
        again = jtik.Robot.from_urdf(to_urdf(robot))
        q = robot.random_configuration(rng)
        assert again.mass_matrix(q) == pytest.approx(robot.mass_matrix(q), abs=AGREEMENT)
        assert again.gravity_torque(q) == pytest.approx(robot.gravity_torque(q), abs=AGREEMENT)

    def test_efforts(self):
        panda = jtik.Robot.builtin("panda")
        assert panda.effort_limit.tolist() == [87.0] * 4 + [12.0] * 3
        assert jtik.Robot.from_urdf(to_urdf(panda)).effort_limit.tolist() == panda.effort_limit.tolist()
        assert jtik.Robot.from_mujoco(to_mujoco(panda)).effort_limit.tolist() == panda.effort_limit.tolist()
        assert np.isinf(jtik.Robot.from_urdf(to_urdf(planar(2))).effort_limit).all()

    def test_an_effort_that_is_no_number_is_reported(self):
        text = to_urdf(jtik.Robot.builtin("panda")).replace('effort="87.0"', 'effort="much"', 1)
        with pytest.warns(UserWarning, match="joint 'panda_joint1' has no effort limit: effort='much'"):
            assert jtik.Robot.from_urdf(text).effort_limit[:2].tolist() == [math.inf, 87.0]

    def test_an_inertia_in_axes_of_its_own(self):
        """URDF gives the tensor in the axes of <inertial>: a quarter about z exchanges x and y."""
        text = """<robot name="r"><link name="base"/><link name="a"><inertial>
          <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/><mass value="2"/>
          <inertia ixx="1" iyy="2" izz="2.5" ixy="0.1" ixz="0" iyz="0"/></inertial></link>
          <joint name="j" type="continuous"><parent link="base"/><child link="a"/><axis xyz="1 0 0"/></joint></robot>"""
        mass = jtik.Robot.from_urdf(text).masses["a"]
        assert mass.inertia == pytest.approx(np.array([[2, -0.1, 0], [-0.1, 1, 0], [0, 0, 2.5]]), abs=1e-12)
        assert jtik.Robot.from_urdf(text).mass_matrix([0.3]) == pytest.approx(np.array([[2.0]]))

    def test_mujoco_and_mjcf(self, rng):
        robot = weighted(ball_arm())
        again = jtik.Robot.from_mujoco(to_mujoco(robot))
        q = robot.random_configuration(rng)
        assert again.mass_matrix(q) == pytest.approx(robot.mass_matrix(q), abs=NEGLIGIBLE_MASSES)
        text = """<mujoco><worldbody><body name="a"><joint axis="0 1 0"/>
          <inertial mass="2" pos="0 0 0" quat="1 1 0 0" diaginertia="1 2 2.5"/></body></worldbody></mujoco>"""
        assert jtik.Robot.from_mjcf(text).mass_matrix([0.0]) == pytest.approx(np.array([[2.5]]))
        ball = '<geom type="sphere" size="0.1" mass="3"/>'
        solid = f'<mujoco><worldbody><body name="a"><joint/>{ball}</body></worldbody></mujoco>'
        assert jtik.Robot.from_mjcf(solid).mass_matrix([0.0]) == pytest.approx(np.array([[0.4 * 3 * 0.01]]))

    def test_a_flat_body_that_mujoco_refuses(self):
        """A published tensor whose largest moment exceeds the sum of the others still makes a model."""
        mass = Mass(1.0, np.zeros(3), np.diag([1.0, 2.0, 9.0]))
        model = to_mujoco(planar(1).with_masses({"link1": mass}))
        assert model.body("link1").inertia.max() == pytest.approx(9.0)


class TestWithoutMasses:
    def test_the_frames_are_named(self):
        robot = jtik.Robot.builtin("iiwa14")
        named = "whose frames iiwa_link_1, .*, iiwa_link_7 move no mass; accepted: .* Robot.with_masses"
        for quantity in (robot.mass_matrix, robot.gravity_torque):
            with pytest.raises(jtik.ArgumentError, match=named):
                quantity(robot.home)

    def test_massless_frames(self):
        assert jtik.Robot.builtin("panda").massless_frames == ()
        assert planar(3).massless_frames == ("link1", "link2", "link3")
        assert planar(3).with_masses({"link2": 1.0}).massless_frames == ("link3",)
        assert planar(3).with_masses({"tip": 1.0}).massless_frames == ()

    def test_what_cannot_be_a_mass(self):
        with pytest.raises(jtik.ArgumentError, match=r"masses\['tip'\]: given -1"):
            planar(2).with_masses({"tip": -1.0})
        with pytest.raises(jtik.UnknownNameError, match="frame of a mass 'hand'"):
            planar(2).with_masses({"hand": 1.0})
        with pytest.raises(jtik.ArgumentError, match=r"gravity: given .*; accepted: .*\(2,\)"):
            weighted(planar(2)).gravity_torque([0.1, 0.2], gravity=[0, 0, -9.81])


@pytest.mark.parametrize(
    "inertia",
    [np.diag([1.0, 1.0, -0.1]), [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]], np.eye(2), np.full((3, 3), np.nan)],
    ids=["negative", "not symmetric", "shape", "nan"],
)
def test_what_cannot_be_an_inertia(inertia):
    with pytest.raises(jtik.ArgumentError, match=r"Mass.inertia"):
        Mass(1.0, np.zeros(3), inertia)


def test_an_inertia_without_a_mass_is_refused():
    """It would be left out with the mass."""
    with pytest.raises(jtik.ArgumentError, match=r"Mass.inertia: .*; accepted: zeros beside a mass of zero"):
        Mass(0.0, np.zeros(3), np.eye(3))
