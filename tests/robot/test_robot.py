"""The robot as a value: its properties, its immutability, and the input that it refuses."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

from jtik.errors import ArgumentError, ImmutableError, JtikError, MissingExtraError, UnknownNameError
from jtik.robot import Joint, JointType, Mimic, Robot

from .conftest import ROBOTS, pose, unit


def revolute(name, parent, child, **options):
    return Joint(name, JointType.REVOLUTE, parent, child, **options)


def test_sizes_names_and_indices_of_a_mixed_tree(mixed):
    assert (mixed.nq, mixed.n) == (7 + 1 + 1 + 4 + 1 + 1 + 1, 6 + 1 + 1 + 3 + 1 + 1 + 1)
    assert mixed.joint_names == ("float", "turret", "boom", "shoulder", "side", "elbow", "wrist")
    assert mixed.frame_names[0] == mixed.base == "world"
    assert {"mount", "tool"} <= set(mixed.frame_names)
    assert mixed.tip == "tool"
    assert mixed.q_slice("shoulder") == slice(9, 13)
    assert mixed.v_slice("shoulder") == slice(8, 11)
    assert mixed.scalar_q.tolist() == [7, 8, 13, 14, 15]
    assert mixed.scalar_v.tolist() == [6, 7, 11, 12, 13]
    assert np.flatnonzero(~mixed.rotational).tolist() == [0, 1, 2, 7]


def test_limits_and_neutral_of_a_mixed_tree(mixed):
    assert mixed.lower[7:9].tolist() == [-1.0, 0.1]
    assert mixed.upper[7:9].tolist() == [2.0, 0.9]
    others = np.delete(np.arange(mixed.nq), [7, 8])
    assert np.isneginf(mixed.lower[others]).all()
    assert np.isposinf(mixed.upper[others]).all()
    assert mixed.velocity_limit[7] == 0.5
    assert mixed.neutral.tolist() == [0, 0, 0, 1, 0, 0, 0, 0, 0.1, 1, 0, 0, 0, 0, 0, 0]


def test_arrays_are_read_only(robot):
    for name in ("lower", "upper", "velocity_limit", "neutral", "rotational", "scalar_q", "scalar_v"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(robot, name)[0] = 0
    with pytest.raises(ValueError, match="read-only"):
        robot.joints[0].origin[0, 3] = 1.0


@pytest.mark.parametrize("attribute", ["name", "tip", "planar", "anything", "_joints"])
def test_attributes_cannot_change(attribute):
    arm = Robot.planar(2)
    with pytest.raises(ImmutableError, match=f"'{attribute}' cannot be changed"):
        setattr(arm, attribute, "new")
    with pytest.raises(AttributeError):
        delattr(arm, attribute)


def test_what_comes_in_is_copied():
    origin = pose((1.0, 0.0, 0.0))
    robot = Robot([revolute("a", "base", "a", origin=origin), revolute("b", "a", "b", origin=origin)])
    origin[0, 3] = 9.0
    assert robot.position([0.0, 0.0]).tolist() == [2.0, 0.0, 0.0]


def test_answers_do_not_alias_each_other():
    arm = Robot.planar(2)
    first = arm.pose([0, 0])
    first[:] = 7.0
    assert arm.pose([0, 0])[3].tolist() == [0, 0, 0, 1]


@pytest.mark.parametrize("again", [copy.deepcopy, lambda robot: pickle.loads(pickle.dumps(robot))])
@pytest.mark.parametrize("name", ROBOTS)
def test_copies_answer_alike_and_stay_frozen(name, again):
    robot = ROBOTS[name]()
    q = robot.random_configuration(3)
    before = robot.jacobian(q)
    copied = again(robot)
    assert np.array_equal(copied.jacobian(q), before)
    assert (copied.name, copied.dimension, copied.base, copied.tip) == (
        robot.name,
        robot.dimension,
        robot.base,
        robot.tip,
    )
    assert not copied.joints[0].origin.flags.writeable
    assert not copied.lower.flags.writeable
    assert copied.moving_frames == robot.moving_frames


def test_robots_compare_by_identity():
    one, other = Robot.planar(2), Robot.planar(2)
    assert one == one
    assert one != other
    assert len({one, other, one}) == 2


def test_random_configurations_follow_the_seed_and_the_limits(robot):
    assert np.array_equal(robot.random_configuration(4), robot.random_configuration(4))
    generator = np.random.default_rng(4)
    assert not np.array_equal(robot.random_configuration(generator), robot.random_configuration(generator))
    for seed in range(20):
        q = robot.random_configuration(seed)
        assert (q >= robot.lower).all()
        assert (q <= robot.upper).all()


def test_random_configurations_fill_their_ranges():
    robot = Robot(
        [
            revolute("free", "base", "a"),
            revolute("bounded", "a", "b", lower=1.0, upper=2.0),
            revolute("below", "b", "c", lower=10.0),
            revolute("above", "c", "d", upper=10.0),
            Joint("lift", JointType.PRISMATIC, "d", "e"),
        ]
    )
    generator = np.random.default_rng(0)
    q = np.array([robot.random_configuration(generator) for _ in range(2000)])
    low = [-np.pi, 1, 10, 10 - 2 * np.pi, -1]
    high = [np.pi, 2, 10 + 2 * np.pi, 10, 1]
    assert (q.min(axis=0) >= low).all()
    assert (q.max(axis=0) <= high).all()
    assert np.abs(q.min(axis=0) - low).max() < 0.05
    assert np.abs(q.max(axis=0) - high).max() < 0.05


def test_random_quaternions_are_unit_and_point_everywhere(mixed):
    generator = np.random.default_rng(0)
    quaternions = np.array([mixed.random_configuration(generator)[9:13] for _ in range(2000)])
    assert np.linalg.norm(quaternions, axis=1) == pytest.approx(1.0, abs=1e-14)
    assert np.abs(quaternions.mean(axis=0)).max() < 0.05
    assert np.cov(quaternions.T) == pytest.approx(np.eye(4) / 4, abs=0.03)


def test_joints_may_come_in_any_order():
    robot = Robot([revolute("b", "a", "b", origin=pose((2, 0, 0))), revolute("a", "base", "a")], tip="b")
    assert robot.joint_names == ("b", "a")
    assert robot.position([0.0, np.pi / 2]) == pytest.approx([0, 2, 0], abs=1e-15)


def test_points_and_segments_of_a_tree_with_a_floating_base(mixed):
    assert mixed.moving_frames == ("hull", "turret", "boom", "arm", "side", "forearm", "hand", "tool")
    assert mixed.segments == (
        ("hull", "turret"),
        ("turret", "boom"),
        ("boom", "arm"),
        ("hull", "side"),
        ("arm", "forearm"),
        ("forearm", "hand"),
        ("hand", "tool"),
    )


def test_points_that_stand_still_or_coincide_are_left_out():
    arm = Robot.from_dh([(0, np.pi / 2, 0.5, 0), (1.0, 0, 0, 0), (0, np.pi / 2, 0, 0), (0, 0, 0.3, 0)])
    # link1 and link2 meet above the base and stay there; link4, past its offset, is where the tip is
    assert arm.moving_frames == ("link3", "tip")
    assert arm.segments == (("base", "link2"), ("link2", "link3"), ("link3", "tip"))


def test_a_piston_is_a_link_but_a_rail_on_the_ground_is_none():
    piston = Robot.from_dh([{"a": 0, "alpha": np.pi / 2, "d": 0.4}, {"a": 0, "alpha": 0, "joint": "prismatic"}])
    assert piston.moving_frames == ("tip",)
    assert piston.segments == (("base", "link1"), ("link1", "tip"))
    rail = Robot(
        [
            Joint("rail", JointType.PRISMATIC, "base", "cart", axis=unit(1, 0, 0)),
            revolute("arm", "cart", "arm", origin=pose((0, 0, 0.2))),
            Joint("end", JointType.FIXED, "arm", "end", origin=pose((0.5, 0, 0))),
        ]
    )
    assert rail.moving_frames == ("cart", "arm", "end")
    assert rail.segments == (("cart", "arm"), ("arm", "end"))


@pytest.mark.parametrize(
    ("joints", "complaint"),
    [
        ([revolute("a", "base", "a"), revolute("a", "a", "b")], "joint name 'a' more than once"),
        ([revolute("a", "base", "x"), revolute("b", "base", "x")], "frame name 'x' more than once"),
        ([revolute("a", "base", "base")], "frame name 'base' more than once"),
        ([revolute("a", "base", "a"), revolute("b", "c", "b"), revolute("c", "b", "c")], "a cycle b -> c -> b"),
    ],
)
def test_joints_that_form_no_tree_are_refused(joints, complaint):
    with pytest.raises(ArgumentError, match=complaint):
        Robot(joints)


def test_a_robot_that_stands_still_has_an_empty_configuration():
    still = Robot([Joint("f", JointType.FIXED, "base", "f", origin=pose((0, 0, 1)))])
    assert (still.n, still.nq, still.tip) == (0, 0, "f")
    assert still.position([]).tolist() == [0.0, 0.0, 1.0]
    assert still.jacobian([]).shape == (6, 0)
    assert (still.moving_frames, still.segments) == ((), (("base", "f"),))
    assert Robot([]).tip == "base"


def test_unknown_parents_tips_and_leaders_are_refused():
    with pytest.raises(UnknownNameError, match="parent frame of joint 'b' 'aa'; did you mean 'a'"):
        Robot([revolute("a", "base", "a"), revolute("b", "aa", "b")])
    with pytest.raises(UnknownNameError, match="unknown tip frame 'hand'"):
        Robot([revolute("a", "base", "a")], tip="hand")
    with pytest.raises(UnknownNameError, match="joint for 'b' to mimic 'c'"):
        Robot([revolute("a", "base", "a"), revolute("b", "a", "b", mimic=Mimic("c"))])
    with pytest.raises(UnknownNameError, match="unknown moving joint 'jiont1'; did you mean 'joint1'"):
        Robot.planar(2).q_slice("jiont1")


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"lower": 2.0, "upper": 1.0}, "joint 'j' limits: given lower 2, upper 1; accepted: lower <= upper"),
        ({"lower": np.nan}, "joint 'j' limits: given nan"),
        ({"lower": np.inf}, "joint 'j' limits: given lower inf, upper inf"),
        ({"velocity_limit": 0.0}, "joint 'j' velocity_limit: given 0.0"),
        ({"velocity_limit": np.nan}, "joint 'j' velocity_limit: given nan"),
        ({"axis": np.zeros(3)}, "joint 'j' axis: given .* of length 0"),
        ({"axis": np.array([0, 0, 2.0])}, "joint 'j' axis: given .* of length 2"),
        ({"axis": np.array([0, np.nan, 1.0])}, "joint 'j' axis: given nan at index 1"),
        ({"origin": 2 * np.eye(4)}, "joint 'j' origin: given a rotation part off orthonormal by 3"),
        ({"origin": np.diag([1.0, 1.0, -1.0, 1.0])}, "joint 'j' origin: given .* determinant -1"),
        ({"origin": np.eye(3)}, r"joint 'j' origin: given shape \(3, 3\)"),
        ({"origin": np.vstack([np.eye(4)[:3], np.ones(4)])}, "joint 'j' origin: given last row"),
    ],
)
def test_invalid_joints_are_refused_by_name(options, complaint):
    with pytest.raises(ArgumentError, match=complaint):
        revolute("j", "base", "j", **options)


def test_limits_and_mimicry_belong_to_scalar_joints():
    with pytest.raises(ArgumentError, match=r"joint 'b' limits: .* ball joint"):
        Joint("b", JointType.BALL, "base", "b", lower=0.0)
    with pytest.raises(ArgumentError, match="joint 'b' mimic: given a ball joint"):
        Joint("b", JointType.BALL, "base", "b", mimic=Mimic("a"))
    with pytest.raises(ArgumentError, match="multiplier"):
        Mimic("a", 0.0)
    with pytest.raises(ArgumentError, match=r"joint 'j' type: given hinge; accepted: JointType\.FIXED"):
        Joint("j", "hinge", "base", "j")


def test_limits_of_a_mimic_joint_that_exclude_those_of_its_leader_are_refused():
    follower = revolute("b", "a", "b", lower=3.0, upper=4.0, mimic=Mimic("a"))
    with pytest.raises(ArgumentError, match="limits: given lower 3, upper 4, which 'a' cannot meet"):
        Robot([revolute("a", "base", "a", lower=0.0, upper=1.0), follower])


@pytest.mark.parametrize(
    "joint",
    [
        revolute("out", "base", "a", axis=unit(1, 0, 0)),
        revolute("out", "base", "a", origin=pose((0, 0, 0.1))),
        revolute("out", "base", "a", origin=pose(rotvec=(0.3, 0, 0))),
        Joint("out", JointType.PRISMATIC, "base", "a"),
        Joint("out", JointType.BALL, "base", "a"),
    ],
)
def test_a_planar_robot_stays_in_its_plane(joint):
    with pytest.raises(ArgumentError, match="planar: given True, but joint 'out' leaves the x-y plane"):
        Robot([joint], planar=True)
    assert Robot([joint]).dimension == 3


@pytest.mark.quick(2)
def test_a_subset_locks_the_other_joints_where_they_are(robot):
    q = robot.random_configuration(8)
    for name in robot.joint_names:
        part = robot.subset([name], at=q)
        assert part.joint_names == (name,)
        assert part.frame_names == robot.frame_names
        assert (part.dimension, part.base, part.tip) == (robot.dimension, robot.base, robot.tip)
        moved = q.copy()
        moved[robot.q_slice(name)] = robot.random_configuration(9)[robot.q_slice(name)]
        reduced = moved[robot.q_slice(name)]
        for frame in robot.frame_names:
            assert part.pose(reduced, frame) == pytest.approx(robot.pose(moved, frame), abs=1e-13)
            columns = robot.jacobian(moved, frame)[:, robot.v_slice(name)]
            assert part.jacobian(reduced, frame) == pytest.approx(columns, abs=1e-13)


def test_a_subset_is_locked_at_neutral_by_default_and_keeps_the_limits(mixed):
    part = mixed.subset(["turret", "boom"])
    assert part.lower.tolist() == [-1.0, 0.1]
    assert part.pose(part.neutral) == pytest.approx(mixed.pose(mixed.neutral), abs=1e-14)


def test_a_subset_of_joints_that_do_not_exist_is_refused(gripper):
    with pytest.raises(UnknownNameError, match="unknown independent joint 'right'"):
        gripper.subset(["left", "right"])
    with pytest.raises(ArgumentError, match="none of which moves"):
        gripper.subset([])
    with pytest.raises(ArgumentError, match=r"at: given shape \(1,\)"):
        gripper.subset(["left"], at=[0.0])


def test_a_missing_extra_says_how_to_get_it():
    error = MissingExtraError("matplotlib", "plot", "solution.plot()")
    assert str(error) == "solution.plot() needs matplotlib; install it with: pip install 'jtik[plot]'"
    assert (error.package, error.extra, error.feature) == ("matplotlib", "plot", "solution.plot()")


@pytest.mark.parametrize(
    "error",
    [
        ArgumentError("q", 3.0, "a vector"),
        UnknownNameError("frame", "a", ["b", "ab"]),
        MissingExtraError("x", "y", "z"),
        ImmutableError("robot", "name"),
    ],
)
def test_errors_survive_a_process_boundary(error):
    copied = pickle.loads(pickle.dumps(error))
    assert str(copied) == str(error)
    assert vars(copied) == vars(error)


def test_errors_have_one_base():
    for error in (ArgumentError, UnknownNameError, ImmutableError, MissingExtraError):
        assert issubclass(error, JtikError)
