"""Built-in arms against their makers' Denavit-Hartenberg tables, multiplied out here in NumPy.

The tables are written down a second time, in the makers' units and conventions: metres, degrees.
"""

from __future__ import annotations

import numpy as np
import pytest

import jtik

EXACT = 1e-12
PRINTED = 1e-3
"""The Gen3 table is printed in tenths of a millimetre, and leaves out the 0.35 mm of its wrist: [m], [rad]."""


def multiplied(rows, q, convention):
    """The product of the rows (alpha [deg], a, d [m], theta at zero [deg]), standard or Craig's."""
    T = np.eye(4)
    for (alpha, a, d, offset), angle in zip(rows, q, strict=True):
        theta, twist = angle + np.deg2rad(offset), np.deg2rad(alpha)
        c, s = np.cos(theta), np.sin(theta)
        ca, sa = np.cos(twist), np.sin(twist)
        about_z = np.array([[c, -s, 0, 0], [s, c, 0, 0], [0, 0, 1, d], [0, 0, 0, 1]])
        about_x = np.array([[1, 0, 0, a], [0, ca, -sa, 0], [0, sa, ca, 0], [0, 0, 0, 1]])
        T = T @ (about_x @ about_z if convention == "craig" else about_z @ about_x)
    return T


def table(alphas, lengths, offsets, zeros=None):
    return list(zip(alphas, lengths, offsets, zeros or [0] * len(alphas), strict=True))


NONE = np.eye(4)
BACKWARDS = np.diag([-1.0, -1.0, 1.0, 1.0])
UPSIDE_DOWN = np.diag([1.0, -1.0, -1.0, 1.0])
AHEAD = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0.107], [0, 0, 0, 1]])

PANDA = table([0, -90, 90, 90, -90, 90, 90], [0, 0, 0, 0.0825, -0.0825, 0, 0.088], [0.333, 0, 0.316, 0, 0.384, 0, 0])
UR_TWISTS = [90, 0, 0, 90, -90, 0]
UR5E = table(UR_TWISTS, [0, -0.425, -0.3922, 0, 0, 0], [0.1625, 0, 0, 0.1333, 0.0997, 0.0996])
UR5 = table(UR_TWISTS, [0, -0.425, -0.39225, 0, 0, 0], [0.089159, 0, 0, 0.10915, 0.09465, 0.0823])
IIWA = table([-90, 90, 90, -90, -90, 90, 0], [0] * 7, [0.36, 0, 0.42, 0, 0.4, 0, 0.126])
XARM = table([0, -90, 90, 90, 90, 90, -90], [0, 0, 0, 0.0525, 0.0775, 0, 0.076], [0.267, 0, 0.293, 0, 0.3425, 0, 0.097])
GEN3_TWISTS, GEN3_ZEROS = [90, 90, 90, 90, 90, 90, 180], [0, 180, 180, 180, 180, 180, 180]
GEN3 = table(
    GEN3_TWISTS,
    [0] * 7,
    [-0.1564 - 0.1284, -0.0054 - 0.0064, -0.2104 * 2, -0.0064 * 2, -0.2084 - 0.1059, 0, -0.1059 - 0.0615],
    GEN3_ZEROS,
)
GEN3_FINE = table(
    GEN3_TWISTS,
    [0] * 7,
    [-0.28481, -0.01175, -0.42076, -0.01275, -0.31436, -0.0003501, -0.167455],
    GEN3_ZEROS,
)


@pytest.mark.parametrize(
    ("name", "frame", "before", "rows", "after", "convention", "agreement"),
    [
        ("panda", "panda_link8", NONE, PANDA, AHEAD, "craig", EXACT),
        ("ur5e", "tool0", BACKWARDS, UR5E, NONE, "standard", EXACT),
        ("ur5", "tool0", BACKWARDS, UR5, NONE, "standard", EXACT),
        ("iiwa14", "iiwa_link_ee", NONE, IIWA, NONE, "standard", EXACT),
        ("xarm7", "link_eef", NONE, XARM, NONE, "craig", EXACT),
        ("gen3", "end_effector_link", UPSIDE_DOWN, GEN3_FINE, NONE, "standard", EXACT),
        ("gen3", "end_effector_link", UPSIDE_DOWN, GEN3, NONE, "standard", PRINTED),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_flange_is_where_the_makers_table_puts_it(name, frame, before, rows, after, convention, agreement):
    robot = jtik.Robot.builtin(name)
    generator = np.random.default_rng(5)
    for _ in range(20):
        q = robot.random_configuration(generator)
        expected = before @ multiplied(rows, q, convention) @ after
        assert robot.pose(q, frame) == pytest.approx(expected, abs=agreement)


@pytest.mark.parametrize(
    ("name", "lower", "upper", "speed"),
    [
        ("ur5e", [-360, -360, -180, -360, -360, -360], [360, 360, 180, 360, 360, 360], [180] * 6),
        (
            "iiwa14",
            [-170, -120, -170, -120, -170, -120, -175],
            [170, 120, 170, 120, 170, 120, 175],
            [85, 85, 100, 75, 130, 135, 135],
        ),
        (
            "gen3",
            [-np.inf, -128.9, -np.inf, -147.8, -np.inf, -120.3, -np.inf],
            [np.inf, 128.9, np.inf, 147.8, np.inf, 120.3, np.inf],
            [80, 80, 80, 80, 70, 70, 70],
        ),
    ],
)
def test_limits_are_the_published_ones(name, lower, upper, speed):
    robot = jtik.Robot.builtin(name)
    assert np.rad2deg(robot.lower) == pytest.approx(lower, abs=1e-9)
    assert np.rad2deg(robot.upper) == pytest.approx(upper, abs=1e-9)
    assert np.rad2deg(robot.velocity_limit) == pytest.approx(speed, abs=0.01)


def test_the_iiwa_reaches_820_millimetres_from_shoulder_to_wrist():
    robot = jtik.Robot.builtin("iiwa14")
    stretched = np.zeros(7)
    reach = robot.position(stretched, "iiwa_link_6") - robot.position(stretched, "iiwa_link_2")
    assert np.linalg.norm(reach) == pytest.approx(0.820, abs=EXACT)


def test_the_pandas_tool_centre_is_its_hands():
    robot = jtik.Robot.builtin("panda")
    q = robot.random_configuration(0)
    flange, tip = robot.pose(q, "panda_link8"), robot.pose(q)
    across = np.sqrt(0.5)
    hand = np.array([[across, across, 0, 0], [-across, across, 0, 0], [0, 0, 1, 0.1034], [0, 0, 0, 1]])
    assert tip == pytest.approx(flange @ hand, abs=EXACT)
