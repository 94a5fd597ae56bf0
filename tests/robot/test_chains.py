"""Planar arms, Denavit-Hartenberg chains and vehicles against their textbook formulas."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from jtik.errors import ArgumentError
from jtik.robot import DHRow, Robot

from .conftest import pose, poses_of_interest

EXACT = 1e-12


@settings(max_examples=30, deadline=None)
@given(st.lists(st.tuples(st.floats(0.01, 5), st.floats(-4, 4)), min_size=1, max_size=6))
def test_a_planar_arm_adds_up_its_links(links):
    lengths, q = np.array(links).T
    arm = Robot.planar(lengths)
    heading = np.cumsum(q)
    x, y = np.cos(heading) @ lengths, np.sin(heading) @ lengths
    assert arm.position(q) == pytest.approx([x, y], abs=EXACT)
    J = arm.jacobian(q)
    for k in range(len(q)):
        tail = slice(k, None)
        expected = [-np.sin(heading[tail]) @ lengths[tail], np.cos(heading[tail]) @ lengths[tail], 0, 0, 0, 1]
        assert J[:, k] == pytest.approx(expected, abs=EXACT)
    T = arm.pose(q)
    assert T[:2, 0] == pytest.approx([np.cos(heading[-1]), np.sin(heading[-1])], abs=EXACT)


def test_a_planar_arm_describes_itself():
    arm = Robot.planar(3, lower=-1.0, upper=[1.0, 2.0, 3.0], velocity_limit=2.0)
    assert arm.dimension == 2
    assert arm.dimension == 2
    assert arm.joint_names == ("joint1", "joint2", "joint3")
    assert arm.frame_names == ("base", "link1", "link2", "link3", "tip")
    assert arm.lower.tolist() == [-1, -1, -1]
    assert arm.upper.tolist() == [1, 2, 3]
    assert arm.velocity_limit.tolist() == [2, 2, 2]
    assert arm.rotational.all()
    assert arm.moving_frames == ("link2", "link3", "tip")
    assert arm.segments == (("link1", "link2"), ("link2", "link3"), ("link3", "tip"))
    assert repr(arm) == "Robot('planar3', n=3, nq=3, tip='tip')"
    assert np.isinf(Robot.planar(3).upper).all()


@pytest.mark.parametrize("links", [0, -1, 2.5, [], [1.0, 0.0], [1.0, -2.0], [1.0, np.nan], "three", None])
def test_invalid_links_are_refused(links):
    with pytest.raises(ArgumentError, match=r"^links: given"):
        Robot.planar(links)


def test_limits_that_do_not_fit_are_refused():
    with pytest.raises(ArgumentError, match=r"upper: given .*accepted: one number, or 3 numbers"):
        Robot.planar(3, upper=[1.0, 2.0])
    with pytest.raises(ArgumentError, match="joint 'joint2' limits: given lower 3, upper 2"):
        Robot.planar(3, lower=[0, 3, 0], upper=2.0)


def textbook(rows, q, convention):
    """The product of the textbook's matrices, standard or Craig's."""
    T = np.eye(4)
    for row, value in zip(rows, q, strict=True):
        theta = row.theta + (value if row.joint == "revolute" else 0.0)
        d = row.d + (value if row.joint == "prismatic" else 0.0)
        ct, st_, ca, sa = np.cos(theta), np.sin(theta), np.cos(row.alpha), np.sin(row.alpha)
        if convention == "standard":
            A = [[ct, -st_ * ca, st_ * sa, row.a * ct], [st_, ct * ca, -ct * sa, row.a * st_], [0, sa, ca, d]]
        else:
            A = [
                [ct, -st_, 0, row.a],
                [st_ * ca, ct * ca, -sa, -sa * d],
                [st_ * sa, ct * sa, ca, ca * d],
            ]
        T = T @ np.vstack([A, [0, 0, 0, 1]])
    return T


ROWS = [
    DHRow(0.1, np.pi / 2, 0.3, 0.2),
    DHRow(0.4, 0.0, 0.05, -np.pi / 2),
    DHRow(0.0, -np.pi / 2, 0.2, 0.6, joint="prismatic", lower=0.0, upper=0.5),
    DHRow(-0.2, 0.7, 0.1, 0.4),
    DHRow(0.0, -1.1, 0.0, 0.0),
]


@pytest.mark.parametrize("convention", ["standard", "modified"])
def test_dh_chains_are_the_product_of_the_textbook_matrices(convention):
    base, tool = pose((0.1, -0.2, 0.7), (0.1, 0.9, 0.3)), pose((0, 0, 0.2), (0.5, 0, 0))
    arm = Robot.from_dh(ROWS, convention=convention, base=base, tool=tool)
    for q in poses_of_interest(arm):
        assert arm.pose(q) == pytest.approx(base @ textbook(ROWS, q, convention) @ tool, abs=EXACT)


def test_modified_frames_are_the_textbook_frames():
    arm = Robot.from_dh(ROWS, convention="modified")
    q = arm.random_configuration(0)
    for k in range(1, len(ROWS) + 1):
        expected = textbook(ROWS[:k], q[:k], "modified")
        assert arm.pose(q, f"link{k}") == pytest.approx(expected, abs=EXACT)


def test_standard_frames_are_on_the_axis_of_their_joint():
    arm = Robot.from_dh(ROWS)
    q = arm.random_configuration(0)
    for k in range(1, len(ROWS) + 1):
        before = textbook(ROWS[: k - 1], q[: k - 1], "standard")
        T = arm.pose(q, f"link{k}")
        assert T[:3, 2] == pytest.approx(before[:3, 2], abs=EXACT)
        assert np.cross(T[:3, 3] - before[:3, 3], before[:3, 2]) == pytest.approx(np.zeros(3), abs=EXACT)


def test_rows_may_be_tuples_or_mappings():
    forms = [
        (0.4, 0.1, 0.2, 0.3),
        {"a": 0.4, "alpha": 0.1, "d": 0.2, "theta": 0.3},
        DHRow(0.4, 0.1, 0.2, 0.3),
    ]
    tips = [Robot.from_dh([row]).pose([0.5]) for row in forms]
    assert np.array_equal(tips[0], tips[1])
    assert np.array_equal(tips[0], tips[2])


def test_a_fixed_row_moves_the_tip_but_not_the_count():
    rows = [DHRow(0.4, 0.0), DHRow(0.2, 0.3, 0.1, 0.5, joint="fixed"), DHRow(0.3, 0.0)]
    arm = Robot.from_dh(rows)
    assert arm.joint_names == ("joint1", "joint3")
    expected = textbook(rows, [0.7, 0.0, -0.4], "standard")
    assert arm.pose([0.7, -0.4]) == pytest.approx(expected, abs=EXACT)


def test_dh_limits_reach_the_robot():
    arm = Robot.from_dh(ROWS)
    assert (arm.lower[2], arm.upper[2]) == (0.0, 0.5)
    assert np.flatnonzero(~arm.rotational).tolist() == [2]


@pytest.mark.parametrize(
    ("rows", "options", "complaint"),
    [
        (
            [(0, 0, 0, 0)],
            {"convention": "craig"},
            "convention: given craig; accepted: 'standard'",
        ),
        ([(0, 0, 0)], {}, r"rows, row 1: given shape \(3,\)"),
        ([(0, 0, 0, 0), {"a": 0, "beta": 1}], {}, "rows, row 2: given keys"),
        ([(0, np.nan, 0, 0)], {}, "rows, row 1: given nan at index 1"),
        ([(0, 0, 0, 0)], {"tool": np.eye(3)}, "tool: given shape"),
        ([(0, 0, 0, 0)], {"base": np.full((4, 4), np.nan)}, "base: given nan"),
        ([], {}, "none of which moves"),
    ],
)
def test_invalid_dh_tables_are_refused(rows, options, complaint):
    with pytest.raises(ArgumentError, match=complaint):
        Robot.from_dh(rows, **options)


def test_dh_rows_are_checked():
    with pytest.raises(ArgumentError, match=r"DHRow\.joint: given helical; accepted: 'revolute', 'prismatic'"):
        DHRow(0, 0, joint="helical")
    with pytest.raises(ArgumentError, match=r"DHRow\.alpha: given inf"):
        DHRow(0, np.inf)


@pytest.mark.parametrize("heading", [False, True])
def test_a_vehicle_carries_its_arm(heading):
    lengths = np.array([0.5, 0.3])
    robot = Robot.vehicle(lengths, heading=heading, upper=2.0, vehicle_lower=-4.0, vehicle_velocity_limit=1.5)
    moving = ["x", "y", "heading"] if heading else ["x", "y"]
    assert robot.joint_names == (*moving, "joint1", "joint2")
    assert robot.rotational.tolist() == [False, False] + [True] * (robot.n - 2)
    assert robot.lower.tolist() == [-4.0] * len(moving) + [-np.inf] * 2
    assert robot.upper.tolist() == [np.inf] * len(moving) + [2.0] * 2
    assert robot.velocity_limit.tolist() == [1.5] * len(moving) + [np.inf] * 2
    assert robot.dimension == 2
    q = robot.random_configuration(6)
    angles = np.cumsum(q[2:])[-2:]
    expected = q[:2] + np.array([np.cos(angles) @ lengths, np.sin(angles) @ lengths])
    assert robot.position(q) == pytest.approx(expected, abs=EXACT)
    assert robot.position(q, "vehicle") == pytest.approx(q[:2], abs=EXACT)
    assert robot.jacobian(q)[:, 0].tolist() == [1, 0, 0, 0, 0, 0]


def test_a_vehicle_is_drawn_as_its_arm():
    robot = Robot.vehicle(2, heading=True)
    assert robot.moving_frames == ("link1", "link2", "tip")
    assert robot.segments == (("link1", "link2"), ("link2", "tip"))
