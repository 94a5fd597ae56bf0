"""Circles, lines and Lissajous figures: geometry; and paths of given targets."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik import problems

from ..conftest import EXACT, planar, planar_points
from .conftest import gallery, mujoco_pose

ROBOTS = {"planar": (lambda: planar(5), "position"), "panda": (lambda: gallery("panda"), "pose")}
EACH = pytest.mark.parametrize(("robot", "kind"), ROBOTS.values(), ids=ROBOTS)


def places(robot, case):
    """Positions along the path, after a check that it starts at MuJoCo's tip position."""
    begin = mujoco_pose(robot, case.q0)[: robot.dimension, 3]
    path = np.array([target[: robot.dimension, 3] if target.ndim == 2 else target for target in case.targets])
    assert path[0] == pytest.approx(begin, abs=1e-9)
    return path


@EACH
def test_a_circle_is_round_and_evenly_spaced(robot, kind):
    robot = robot()
    for case in problems.circle(robot, jtik.FrameTask(kind=kind), 2, points=24, dt=0.01):
        path = places(robot, case)
        center = path[:-1].mean(axis=0)
        assert np.linalg.norm(path - center, axis=1) == pytest.approx(case.known["size"], rel=1e-9)
        assert np.linalg.matrix_rank(path - center, tol=1e-9) == 2
        steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
        assert steps == pytest.approx(2 * case.known["size"] * np.sin(np.pi / 24), rel=1e-9)
        assert (case.closed, case.dt, len(case.targets)) == (True, 0.01, 25)
        assert np.array_equal(case.targets[0], case.targets[-1])


@EACH
def test_a_line_is_straight_and_evenly_spaced(robot, kind):
    robot = robot()
    for case in problems.line(robot, jtik.FrameTask(kind=kind), 2, points=20):
        path = places(robot, case)
        assert np.linalg.norm(path[-1] - path[0]) == pytest.approx(case.known["size"], rel=1e-9)
        assert np.diff(path, axis=0) == pytest.approx(np.tile((path[-1] - path[0]) / 20, (20, 1)), abs=1e-9)
        assert not case.closed


def test_a_line_with_back_returns_to_its_start():
    case = problems.line(planar(5), jtik.FrameTask(), 1, points=20, length=1.5, back=True)[0]
    path = places(planar(5), case)
    assert case.closed
    assert np.linalg.norm(path[10] - path[0]) == pytest.approx(1.5, rel=1e-12)
    assert path[:11] == pytest.approx(path[::-1][:11], abs=EXACT)


@EACH
def test_a_lissajous_figure_has_its_closed_form(robot, kind):
    robot = robot()
    for case in problems.lissajous(robot, jtik.FrameTask(kind=kind), 2, points=32, frequencies=(2, 3)):
        path = places(robot, case)
        s, a = np.linspace(0, 2 * np.pi, 33), case.known["size"]
        wanted = np.column_stack([a * np.sin(2 * s), a / 2 * np.sin(3 * s)])
        moved = path - path[0]
        # equal Gram matrices: the same figure up to a rotation
        assert moved @ moved.T == pytest.approx(wanted @ wanted.T, abs=1e-12)
        assert case.closed


@pytest.mark.parametrize(("generator", "option"), [("circle", "radius"), ("lissajous", "amplitude")])
def test_a_given_size_is_used(generator, option):
    made = getattr(problems, generator)(planar(5), jtik.FrameTask(), 3, points=12, **{option: 0.3})
    assert [case.known["size"] for case in made] == [0.3] * 3


def test_drawn_sizes_scale_with_the_robot():
    small = jtik.Robot.planar([0.05] * 4)
    for case in problems.circle(small, jtik.FrameTask(), 5, points=12):
        assert case.known["size"] <= 0.15 * 0.2
        assert np.linalg.norm(np.array(case.targets), axis=1).max() <= 0.2


def test_orientations_are_constant_on_a_path():
    for case in problems.circle(gallery("panda"), jtik.FrameTask(kind="pose"), 1, points=8):
        assert all((target[:3, :3] == case.targets[0][:3, :3]).all() for target in case.targets)


def test_a_path_moves_only_the_coordinates_of_the_task():
    case = problems.line(gallery("panda"), jtik.FrameTask(axes="xz"), 1, points=8)[0]
    assert np.ptp([target[1] for target in case.targets]) == 0
    with pytest.raises(jtik.ArgumentError, match="at least 2 coordinates"):
        problems.circle(gallery("panda"), jtik.FrameTask(axes="z"), 1)


def test_a_path_of_given_targets_starts_at_its_first_target():
    targets = [[1.0, 1.0], [1.1, 1.0], [1.1, 1.1], [1.0, 1.0]]
    made = problems.path(planar(3), jtik.FrameTask(), targets, dt=0.5, name="mine", parameters={"a.b": [1.0]})
    case = made[0]
    assert planar_points(case.q0)[-1] == pytest.approx([1.0, 1.0], abs=1e-6)
    assert (case.name, case.kind, case.dt, case.closed, case.reachable) == ("mine", "path", 0.5, True, None)
    assert [target.tolist() for target in case.targets] == targets
    assert case.parameters["a.b"].tolist() == [1.0]
    assert not problems.path(planar(3), jtik.FrameTask(), targets[:3])[0].closed


def test_an_unreachable_path_starts_at_q0_or_at_the_neutral_configuration():
    q0 = [0.1, 0.2, 0.3]
    assert problems.path(planar(3), jtik.FrameTask(), [[9.0, 0.0]], q0=q0)[0].q0.tolist() == q0
    assert problems.path(planar(3), jtik.FrameTask(), [[9.0, 0.0]])[0].q0.tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    ("targets", "options", "argument"),
    [
        ([], {}, "targets"),
        ([[1.0, 1.0], [1.0]], {}, "problems['path'].targets[1]"),
        ([[1.0, 1.0]], {"q0": [0.0]}, "q0"),
        ([[1.0, 1.0]], {"dt": -1.0}, "dt"),
    ],
)
def test_a_path_that_does_not_fit_is_refused(targets, options, argument):
    with pytest.raises(jtik.ArgumentError) as caught:
        problems.path(planar(3), jtik.FrameTask(), targets, **options)
    assert caught.value.argument == argument
