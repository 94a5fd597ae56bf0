"""The viewer without a browser: its server, the poses of its nodes, its sliders, its targets."""

from __future__ import annotations

import builtins
import socket
import threading
import urllib.request
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import jtik
from jtik.geometry import HalfSpace
from jtik.viewer import Viewer
from jtik_formulations import ObstacleAvoidance

pytest.importorskip("viser")

SINGLE = 1e-6
"""Rounding of the single precision in which a browser gets positions and quaternions."""

SOLVED = 1e-5
"""Tolerance of a solve, and the single precision of a pose."""


@pytest.fixture(scope="module")
def ur5e() -> jtik.Robot:
    return jtik.Robot.builtin("ur5e")


@pytest.fixture
def shown() -> Iterator[Any]:
    """A function that views something and closes it at the end."""
    viewers: list[Viewer] = []

    def view(*subjects: Any, **options: Any) -> Viewer:
        viewers.append(jtik.view(*subjects, **options))
        return viewers[-1]

    yield view
    for viewer in viewers:
        viewer.close()


def pose_of(node: Any) -> np.ndarray:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_quat(node.wxyz, scalar_first=True).as_matrix(), node.position
    return pose


def drag(viewer: Viewer, pose: np.ndarray, arm: int = 0) -> None:
    """What viser does when a user drags a target."""
    handle = viewer.arms[arm].handle
    handle.position = pose[:3, 3]
    handle.wxyz = Rotation.from_matrix(pose[:3, :3]).as_quat(scalar_first=True)
    for callback in handle._impl_aux.update_cb:
        callback(None)


def check_nodes(viewer: Viewer, q: np.ndarray, arm: int = 0) -> None:
    """Whether all nodes are at their frames."""
    shown_arm = viewer.arms[arm]
    robot = shown_arm.subject.robot
    np.testing.assert_allclose(shown_arm.q, q, atol=SINGLE)
    for frame, node in shown_arm.nodes.frames.items():
        np.testing.assert_allclose(pose_of(node), robot.pose(q, frame), atol=SINGLE)


def test_the_server_answers_on_the_loopback_address_and_its_port_is_free_again(ur5e: jtik.Robot) -> None:
    with jtik.view(ur5e) as viewer:
        assert viewer.url.startswith("http://127.0.0.1:")
        with urllib.request.urlopen(viewer.url, timeout=10) as answer:
            assert answer.status == 200
    port = int(viewer.url.rpartition(":")[2])
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        probe.bind(("127.0.0.1", port))
    assert "closed" in repr(viewer)
    viewer.close()  # again


def test_nodes_are_at_their_frames(shown: Any, ur5e: jtik.Robot) -> None:
    viewer = shown(ur5e)
    check_nodes(viewer, ur5e.home)
    assert viewer.arms[0].nodes.shown == "shapes"
    q = ur5e.random_configuration(1)
    viewer.arms[0].move(q)
    check_nodes(viewer, q)


def test_links_are_between_their_frames_and_grow_with_a_prismatic_joint(shown: Any) -> None:
    rows = [
        {"a": 0.3, "alpha": 1.0},
        {"a": 0.0, "alpha": 0.5, "joint": "prismatic", "upper": 1.0},
        {"a": 0.2, "alpha": 0},
    ]
    robot = jtik.Robot.from_dh(rows)
    viewer = shown(robot)
    nodes = viewer.arms[0].nodes
    assert nodes.shown == "links"
    for q in ([0.3, 0.2, 0.1], [-0.5, 0.9, 0.4]):
        viewer.arms[0].move(q)
        assert len(nodes.links) == len(robot.segments)
        for inner, outer, node in nodes.links:
            start, end = robot.position(q, inner), robot.position(q, outer)
            drawn = node.vertices @ pose_of(node)[:3, :3].T + node.position
            np.testing.assert_allclose(drawn.mean(axis=0), (start + end) / 2, atol=1e-5)
            along = (drawn - start) @ (end - start) / np.linalg.norm(end - start)
            assert np.ptp(along) - np.linalg.norm(end - start) == pytest.approx(2 * nodes._radius, abs=1e-5)


def test_sliders_move_the_arm_within_its_limits(shown: Any, ur5e: jtik.Robot) -> None:
    viewer = shown(ur5e)
    sliders = viewer.arms[0].panel.sliders
    assert list(sliders) == list(ur5e.joint_names)
    expected = ur5e.home.copy()
    for k, (name, slider) in enumerate(sliders.items()):
        assert slider.min == pytest.approx(ur5e.lower[k])
        assert slider.max == pytest.approx(ur5e.upper[k])
        slider.value = expected[k] = 0.1 * (k + 1)
        check_nodes(viewer, expected)
        assert viewer.q["ur5e"][ur5e.q_slice(name)] == pytest.approx(0.1 * (k + 1))
    target = pose_of(viewer.arms[0].handle)
    np.testing.assert_allclose(target, ur5e.pose(expected), atol=SINGLE)


def test_joints_without_limits_have_sliders_of_one_turn(shown: Any) -> None:
    viewer = shown(jtik.Robot.vehicle(2))
    ranges = {name: (slider.min, slider.max) for name, slider in viewer.arms[0].panel.sliders.items()}
    assert ranges == {name: (-1, 1) if name in "xy" else (-np.pi, np.pi) for name in ("x", "y", "joint1", "joint2")}


def test_a_configuration_beyond_a_slider_widens_it(shown: Any) -> None:
    viewer = shown(jtik.Robot.planar(2))
    viewer.arms[0].move([7.0, -8.0])
    sliders = viewer.arms[0].panel.sliders
    assert [slider.value for slider in sliders.values()] == [7.0, -8.0]
    check_nodes(viewer, np.array([7.0, -8.0]))


def test_dragging_the_target_solves(shown: Any, ur5e: jtik.Robot) -> None:
    q = ur5e.home + 0.2
    pose = ur5e.pose(q)
    viewer = shown(ur5e)
    drag(viewer, pose)
    found = viewer.q["ur5e"]
    np.testing.assert_allclose(ur5e.pose(found), pose, atol=SOLVED)
    check_nodes(viewer, found)
    for k, slider in enumerate(viewer.arms[0].panel.sliders.values()):
        assert slider.value == pytest.approx(found[k])
    assert "m away" in viewer.arms[0].panel.status.content


def test_a_target_out_of_reach_is_reported_and_does_not_end_anything(shown: Any) -> None:
    arm = jtik.Robot.planar([1.0, 0.5])
    viewer = shown(arm, [0.3, 0.4])
    far = np.eye(4)
    far[0, 3] = 3.0
    drag(viewer, far)
    assert "1.5 m away" in viewer.arms[0].panel.status.content
    np.testing.assert_allclose(arm.position(viewer.q[arm.name]), [1.5, 0.0], atol=1e-3)
    drag(viewer, arm.pose([0.5, 0.6]))
    np.testing.assert_allclose(arm.position(viewer.q[arm.name]), arm.position([0.5, 0.6]), atol=SOLVED)


@pytest.mark.slow
def test_joints_that_the_solver_does_not_move_stay(shown: Any) -> None:
    robot = jtik.Robot.builtin("vehicle_panda")
    ik = jtik.InverseKinematics(robot, jtik.FrameTask(kind="pose"), joints=robot.joint_names[-7:])
    viewer = shown(robot, robot.home)
    viewer.arms[0].target._ik = ik
    q = robot.home.copy()
    q[0] += 0.5  # the vehicle is moved by its slider; the arm then reaches its target from there
    viewer.arms[0].move(q)
    drag(viewer, robot.pose(q))
    assert viewer.q[robot.name][0] == q[0]


def test_a_solver_brings_its_obstacles_and_its_task(shown: Any) -> None:
    arm = jtik.Robot.planar(3)
    avoid = ObstacleAvoidance([jtik.Circle((1.0, 1.0), 0.2), jtik.Circle((-1.0, 1.0), 0.3)])
    ik = jtik.InverseKinematics(arm, jtik.FrameTask("link3", kind="position"), criteria=avoid)
    viewer = shown(ik)
    middles = sorted(tuple(node.vertices.mean(axis=0).round(5)[:2]) for node in viewer.obstacles)
    assert middles == [(-1.0, 1.0), (1.0, 1.0)]
    assert viewer.arms[0].target.frame == "link3"
    ik.parameters["obstacle_avoidance.centers"] = [[0.5, 0.7], [-1.0, 1.0]]
    viewer.update(ik)
    middles = sorted(tuple(node.vertices.mean(axis=0).round(5)[:2]) for node in viewer.obstacles)
    assert middles == [(-1.0, 1.0), (0.5, 0.7)]
    assert viewer.arms[0].target._ik.parameters["obstacle_avoidance.centers"][0] == pytest.approx([0.5, 0.7])


def test_every_shape_is_shown(shown: Any, ur5e: jtik.Robot) -> None:
    field = [
        jtik.Point((0.5, 0, 0.5)),
        jtik.Sphere((0.5, 0.5, 0.5), 0.1),
        jtik.Capsule((0.5, 0.5, 0.5), (0.5, 0.5, 0.8), 0.05),
        jtik.Cylinder((0.5, 0.5, 0.5), (0.5, 0.5, 0.8), 0.05),
        jtik.Box.at((0.5, -0.5, 0.1), (0.1, 0.1, 0.1)),
        HalfSpace((0, 0, -0.1), (0, 0, 1)),
    ]
    viewer = shown(ur5e, obstacles=field)
    assert len(viewer.obstacles) == len(field)
    assert viewer.obstacles[-1].vertices[:, 2].max() == pytest.approx(-0.1, abs=SINGLE)


def test_a_trajectory_follows_the_time(shown: Any) -> None:
    ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask(kind="position"))
    targets = [(2.0, 0.1 * k) for k in range(11)]
    trajectory = ik.track(targets, q0=[0.2, 0.5, -0.9], dt=0.1)
    viewer = shown(ik, trajectory)
    assert viewer.player.end == pytest.approx(trajectory.times[-1])
    check_nodes(viewer, trajectory.start)
    viewer.player.slider.value = float(trajectory.times[4])
    check_nodes(viewer, trajectory.q[4])
    viewer.player.slider.value = float(trajectory.times[4] + trajectory.times[5]) / 2
    check_nodes(viewer, (trajectory.q[4] + trajectory.q[5]) / 2)
    assert viewer.arms[0].handle is None


def test_playing_moves_and_pausing_stops(shown: Any) -> None:
    ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask(kind="position"))
    trajectory = ik.track([(2.0, 0.1 * k) for k in range(11)], q0=[0.2, 0.5, -0.9], dt=10.0)
    viewer = shown(ik, trajectory)
    moved = threading.Event()
    viewer.player.slider.on_update(lambda _: moved.set())
    viewer.player.play()
    assert moved.wait(20)
    viewer.player.pause()
    assert viewer.player.button.label == "Play"
    assert 0 < viewer.player.slider.value < viewer.player.end


def test_several_arms_are_overlaid_in_different_colours(shown: Any) -> None:
    arm = jtik.Robot.planar(3)
    ik = jtik.InverseKinematics(arm, jtik.FrameTask(kind="position"))
    solutions = [ik.solve((1.0, 1.0), q0=q0) for q0 in ([0.1, 0.2, 0.3], [1.5, -0.2, -0.3])]
    viewer = shown(ik, *solutions, jtik.Robot.vehicle(2))
    assert list(viewer.q) == ["planar3 1", "planar3 2", "vehicle4"]
    for k, solution in enumerate(solutions):
        check_nodes(viewer, solution.q, k)
    colors = {each.nodes.links[0][2].color for each in viewer.arms}
    assert len(colors) == 3
    viewer.arms[1].panel.visible.value = False
    assert [each.nodes.visible for each in viewer.arms] == [True, False, True]


def test_a_comparison_shows_its_contenders_on_a_case(shown: Any) -> None:
    arm, task = jtik.Robot.planar(3), jtik.FrameTask(kind="position")
    avoid = ObstacleAvoidance([jtik.Circle((1.0, 1.0), 0.2)])
    study = jtik.compare(
        arm, task, strategies=["newton", "hybrid"], criteria=avoid, problems="reachable", count=2, repeats=1
    )
    viewer = shown(study)
    assert list(viewer.q) == ["newton", "hybrid"]
    assert len(viewer.obstacles) == 1
    viewer.player.slider.value = viewer.player.end
    for k, name in enumerate(study.contenders):
        check_nodes(viewer, study.traces[name, "", "reachable-000"].q[-1], k)
    cases = next(each for each in viewer.gui._gui_input_handle_from_uuid.values() if each.label == "case")
    cases.value = "reachable-001"
    for k, name in enumerate(study.contenders):
        check_nodes(viewer, study.traces[name, "", "reachable-001"].q[0], k)


def test_in_a_notebook_it_is_a_frame(shown: Any, ur5e: jtik.Robot) -> None:
    viewer = shown(ur5e, height=321)
    assert f'src="{viewer.url}"' in viewer._repr_html_()
    assert 'height="321"' in viewer._repr_html_()
    viewer.close()
    assert "iframe" not in viewer._repr_html_()


def test_a_port_in_use_is_refused(shown: Any, ur5e: jtik.Robot) -> None:
    viewer = shown(ur5e)
    with pytest.raises(jtik.ArgumentError, match="in use"):
        jtik.view(ur5e, port=int(viewer.url.rpartition(":")[2]))


def test_what_cannot_be_shown_is_refused(ur5e: jtik.Robot) -> None:
    solution = jtik.InverseKinematics(ur5e, jtik.FrameTask()).solve(ur5e.position(ur5e.home + 0.1))
    for subjects, options, match in (
        ((), {}, "subjects"),
        ((solution,), {}, "robot"),
        ((ur5e, 3.0), {}, "subjects"),
        ((ur5e, [1.0, 2.0]), {}, "subjects"),
        ((ur5e,), {"labels": ["a", "b"]}, "labels"),
        ((ur5e,), {"show": "skin"}, "show"),
        ((ur5e,), {"obstacles": [3]}, "obstacles"),
        ((ur5e,), {"port": 80}, "port"),
        ((ur5e,), {"robot": "ur5e"}, "robot"),
    ):
        with pytest.raises(jtik.ArgumentError, match=match):
            jtik.view(*subjects, **options)


def test_a_missing_viser_is_named_with_its_extra(monkeypatch: pytest.MonkeyPatch, ur5e: jtik.Robot) -> None:
    real = builtins.__import__

    def fake(name: str, *arguments: Any, **options: Any) -> Any:
        if name.partition(".")[0] == "viser":
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", fake)
    with pytest.raises(jtik.MissingExtraError, match=r"viser.*pip install 'jtik\[view\]'"):
        jtik.view(ur5e)
