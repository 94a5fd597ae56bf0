"""Kinematics of any robot: Jacobians against differences and automatic derivatives, numbers and symbols, sharing."""

from __future__ import annotations

import casadi
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from jtik.errors import ArgumentError, JtikError, UnknownNameError
from jtik.robot import Joint, JointType, Robot
from jtik.symbolic import function, is_equal, symbol

from .conftest import make_arm, pose, poses_of_interest, unit

DIFFERENCE_STEP = 1e-6
DIFFERENCE_TOLERANCE = 1e-8  # step squared, and rounding over the step
EXACT = 1e-12


@pytest.mark.quick(2)
def test_jacobian_is_the_rate_of_the_pose_under_integrate(robot):
    for q in poses_of_interest(robot):
        for frame in robot.frame_names:
            J = robot.jacobian(q, frame)
            assert J.shape == (6, robot.n)
            for k, column in enumerate(J.T):
                step = np.zeros(robot.n)
                step[k] = DIFFERENCE_STEP
                ahead = robot.pose(robot.integrate(q, step), frame)
                behind = robot.pose(robot.integrate(q, -step), frame)
                linear = (ahead[:3, 3] - behind[:3, 3]) / (2 * DIFFERENCE_STEP)
                rotation = Rotation.from_matrix(ahead[:3, :3] @ behind[:3, :3].T).as_rotvec()
                assert column[:3] == pytest.approx(linear, abs=DIFFERENCE_TOLERANCE)
                assert column[3:] == pytest.approx(rotation / (2 * DIFFERENCE_STEP), abs=DIFFERENCE_TOLERANCE)


def test_linear_rows_are_the_derivative_of_the_position_times_the_tangent_map(robot):
    q = symbol("q", robot.nq)
    kinematics = robot.at(q)
    size = robot.dimension
    derived = casadi.jacobian(kinematics.position(), q) @ robot.tangent(q)
    gap = function("gap", [q], [derived - kinematics.jacobian()[:size, :]])
    for value in poses_of_interest(robot):
        assert np.abs(gap(value).full()).max() < EXACT


def test_rotations_stay_rotations(robot):
    for q in poses_of_interest(robot):
        R = robot.pose(q)[:3, :3]
        assert pytest.approx(np.eye(3), abs=EXACT) == R @ R.T
        assert np.linalg.det(R) == pytest.approx(1.0, abs=EXACT)


def test_pose_rotation_and_position_agree(robot):
    q = symbol("q", robot.nq)
    k = robot.at(q)
    value = robot.random_configuration(5)
    R, p = function("f", [q], [k.rotation(), k.position()])(value)
    T = robot.pose(value)
    assert T[:3, :3] == pytest.approx(R.full(), abs=EXACT)
    assert T[: robot.dimension, 3] == pytest.approx(p.full().ravel(), abs=EXACT)
    assert T[: robot.dimension, 3] == pytest.approx(robot.position(value), abs=EXACT)
    assert T[3].tolist() == [0, 0, 0, 1]


def test_results_keep_their_shapes_for_a_single_joint():
    arm = Robot.planar(1)
    assert arm.position([0.3]).shape == (2,)
    assert arm.jacobian([0.3]).shape == (6, 1)
    assert arm.tangent([0.3]).shape == (1, 1)
    assert arm.integrate([0.3], [0.1]).shape == (1,)


def test_the_base_frame_does_not_move(robot):
    q = robot.random_configuration(0)
    assert np.array_equal(robot.pose(q, robot.base), np.eye(4))
    assert not robot.jacobian(q, robot.base).any()


def test_numbers_sx_and_mx_agree(robot):
    value = robot.random_configuration(2)
    step = np.linspace(-0.2, 0.3, robot.n)
    for kind in (casadi.SX, casadi.MX):
        q, dq = kind.sym("q", robot.nq), kind.sym("dq", robot.n)
        outputs = [
            robot.pose(q),
            robot.position(q),
            robot.jacobian(q),
            robot.tangent(q),
            robot.integrate(q, dq),
        ]
        results = casadi.Function("f", [q, dq], outputs)(value, step)
        expected = [
            robot.pose(value),
            robot.position(value),
            robot.jacobian(value),
            robot.tangent(value),
            robot.integrate(value, step),
        ]
        for given, wanted in zip(results, expected, strict=True):
            assert casadi.densify(given).full().reshape(wanted.shape) == pytest.approx(wanted, abs=EXACT)


def test_difference_is_the_inverse_of_integrate(robot):
    q = robot.random_configuration(1)
    dq = np.linspace(-1.0, 1.2, robot.n)
    assert robot.difference(q, robot.integrate(q, dq)) == pytest.approx(dq, abs=EXACT)


def test_symbolic_and_numeric_arguments_mix():
    arm = Robot.planar(2)
    q = symbol("q", 2)
    ahead = function("f", [q], [arm.integrate(q, [0.5, -0.5])])
    assert ahead([1, 1]).full().ravel().tolist() == [1.5, 0.5]


def test_the_same_symbol_shares_one_kinematics_and_another_does_not():
    arm = Robot.planar(2)
    q, other = symbol("q", 2), symbol("q", 2)
    first = arm.at(q)
    assert arm.at(q) is first
    assert arm.at(casadi.SX(q)) is first
    assert arm.at(other) is not first
    assert first.plain_jacobian() is first.plain_jacobian("tip")
    assert is_equal(first.jacobian(), first.plain_jacobian(), 0)
    assert first.robot is arm


def test_changing_the_expression_in_place_does_not_confuse_the_cache():
    arm = Robot.planar(1)
    q = symbol("q", 1)
    own = casadi.SX(q)
    arm.position(own)
    own[0] = 2 * q
    assert function("f", [q], [arm.position(own)])(0.5).full().ravel() == pytest.approx([np.cos(1), np.sin(1)])


def test_parallel_and_antiparallel_axes_merge_whatever_lies_between():
    z, between = unit(0, 0, 1), pose((0.3, 0.0, 0.1), (np.pi, 0.0, 0.0))
    joints = [
        Joint("a", JointType.REVOLUTE, "base", "a", origin=pose((0, 0, 1), (0.3, 0.2, 0.1)), axis=z),
        Joint("b", JointType.REVOLUTE, "a", "b", origin=between, axis=z),
        Joint("c", JointType.REVOLUTE, "b", "c", origin=pose((0.2, 0.1, 0.0), (0, 0, 0.7)), axis=-z),
        Joint("end", JointType.FIXED, "c", "end", origin=pose((0.1, 0.2, 0.3))),
    ]
    T = Robot(joints).pose([0.4, -0.9, 1.3])
    expected = np.eye(4)
    for joint, angle in zip(joints, [0.4, -0.9, 1.3, 0.0], strict=True):
        expected = expected @ joint.origin @ pose(rotvec=angle * joint.axis)
    assert pytest.approx(expected, abs=EXACT) == T


def test_mimic_joints_follow_in_position_and_in_the_jacobian(gripper):
    assert gripper.joint_names == ("lift", "left")
    assert gripper.n == 2
    q = np.array([0.6, 0.02])
    lift = pose((0, 0, 0.5), (0, 0.6, 0))
    right = lift @ pose((0.3, -2.0 * 0.02 + 0.01, 0))
    assert gripper.pose(q, "right") == pytest.approx(right, abs=EXACT)
    nail = lift @ pose((0.3, 0.02, 0)) @ pose((0.1, 0, 0), (0, 0, 0.5 * 0.6 + 0.2))
    assert gripper.pose(q, "nail") == pytest.approx(nail, abs=EXACT)
    assert gripper.jacobian(q, "right")[:3, 1] == pytest.approx([0, -2, 0], abs=EXACT)


def test_mimic_joints_reduce_the_limits_of_their_leader(gripper):
    # right = -2 left + 0.01 in [-0.05, 0] leaves left in [0.005, 0.03], inside its own [0, 0.04]
    assert gripper.lower[1] == pytest.approx(0.005, abs=EXACT)
    assert gripper.upper[1] == pytest.approx(0.03, abs=EXACT)
    assert gripper.velocity_limit[1] == pytest.approx(1.5, abs=EXACT)


def test_a_ten_link_tip_costs_ten_sines_ten_cosines_and_three_operations_a_link():
    arm = Robot.planar(10)
    q = symbol("q", 10)
    tip = function("tip", [q], [arm.position(q)])
    operations = [tip.instruction_id(i) for i in range(tip.n_instructions())]
    assert operations.count(casadi.OP_SIN) == 10
    assert operations.count(casadi.OP_COS) == 10
    moves = operations.count(casadi.OP_INPUT) + operations.count(casadi.OP_OUTPUT)
    assert len(operations) - moves <= 20 + 3 * 10


def test_a_six_axis_pose_and_jacobian_stay_cheap():
    arm = make_arm()
    q = symbol("q", 6)
    both = function("both", [q], [arm.pose(q), arm.jacobian(q)])
    assert both.n_instructions() < 250


@pytest.mark.parametrize(
    ("q", "complaint"),
    [
        ([0.0, 1.0], r"q: given shape \(2,\); accepted: finite numbers of shape \(3,\)"),
        ([0.0, np.nan, 1.0], r"q: given nan at index 1; accepted: finite numbers"),
        ([0.0, 1.0, np.inf], r"q: given inf at index 2"),
        (["a", "b", "c"], r"q: given non-numeric list"),
        ([[1.0], [1.0, 2.0]], r"q: given a ragged list"),
        ("123", r"q: given non-numeric str"),
        (1.0, r"q: given shape \(\)"),
    ],
)
def test_configurations_are_checked(q, complaint):
    with pytest.raises(ArgumentError, match=complaint) as caught:
        Robot.planar(3).pose(q)
    assert caught.value.argument == "q"
    assert isinstance(caught.value, JtikError)


def test_a_wrong_displacement_is_named():
    with pytest.raises(ArgumentError, match=r"dq: given shape \(2,\); accepted: .* shape \(3,\)"):
        Robot.planar(3).integrate([0, 0, 0], [0, 0])


@pytest.mark.parametrize("call", ["pose", "integrate", "tangent", "difference"])
def test_symbols_of_the_wrong_shape_are_refused(call):
    q = symbol("q", 2)
    arguments = (q, q) if call in ("integrate", "difference") else (q,)
    with pytest.raises(ArgumentError, match=r"shape \(3, 1\)"):
        getattr(Robot.planar(3), call)(*arguments)


def test_a_zero_quaternion_is_refused(mixed):
    q = mixed.neutral.copy()
    q[mixed.q_slice("shoulder")] = 0
    with pytest.raises(ArgumentError, match="zero quaternion for joint 'shoulder'"):
        mixed.pose(q)


def test_an_unknown_frame_lists_the_known_ones_and_the_closest():
    with pytest.raises(UnknownNameError, match="unknown frame 'lnk2'; did you mean 'link2'") as caught:
        Robot.planar(2).pose([0, 0], "lnk2")
    assert str(caught.value).endswith("(known: base, link1, link2, tip)")
    assert (caught.value.kind, caught.value.name, caught.value.closest) == ("frame", "lnk2", "link2")
