"""Pictures of trajectories and traces show their numbers."""

from __future__ import annotations

import numpy as np
import pytest

import jtik
from jtik import plotting
from jtik.plotting.motion import resampled
from jtik_formulations import JointCentering

pytest.importorskip("matplotlib")
image = pytest.importorskip("PIL.Image")


@pytest.fixture(scope="module")
def ik() -> jtik.InverseKinematics:
    arm = jtik.Robot.planar([1.0, 0.8, 0.6])
    return jtik.InverseKinematics(arm, jtik.FrameTask(kind="position"), criteria=JointCentering())


@pytest.fixture(scope="module")
def trajectory(ik: jtik.InverseKinematics) -> jtik.Trajectory:
    angles = np.linspace(0.3, 1.5, 13)
    return ik.track([(1.5 * np.cos(a), 1.5 * np.sin(a)) for a in angles], q0=[0.2, 0.5, 0.7], dt=0.1)


def test_a_trajectory_is_plotted_with_its_start_and_its_numbers(trajectory: jtik.Trajectory) -> None:
    positions, speeds, errors = trajectory.plot().axes
    for k, (name, line) in enumerate(zip(trajectory.joint_names, positions.get_lines(), strict=True)):
        assert line.get_label() == name
        np.testing.assert_array_equal(line.get_xdata(), [0.0, *trajectory.times])
        np.testing.assert_array_equal(line.get_ydata(), [trajectory.start[k], *trajectory.q[:, k]])
        np.testing.assert_array_equal(speeds.get_lines()[k].get_ydata(), trajectory.dq[:, k])
    np.testing.assert_array_equal(errors.get_lines()[0].get_ydata(), np.maximum(trajectory.error_norm, 1e-17))
    for axes, unit in ((positions, "rad, m"), (speeds, "rad/s"), (errors, "m, rad")):
        assert unit in axes.get_ylabel()
    assert errors.get_xlabel() == "time [s]"


def test_targets_that_were_not_reached_are_marked(ik: jtik.InverseKinematics) -> None:
    far = ik.track([(2.3, 0.0), (2.5, 0.0), (2.2, 0.0)], q0=[0.2, 0.5, 0.7])
    crosses = far.plot().axes[2].get_lines()[1]
    np.testing.assert_array_equal(crosses.get_xdata(), far.times[~far.reached])
    assert len(crosses.get_xdata()) == 1


def test_a_trajectory_of_a_robot_is_drawn_as_postures_and_the_path(
    ik: jtik.InverseKinematics, trajectory: jtik.Trajectory
) -> None:
    axes = trajectory.plot(ik.robot, width=4.0).axes[0]
    path = next(line for line in axes.get_lines() if len(line.get_xdata()) == len(trajectory) + 1)
    expected = [ik.robot.position(q) for q in (trajectory.start, *trajectory.q)]
    np.testing.assert_allclose(np.column_stack(path.get_data()), expected, atol=1e-12)
    assert len(axes.collections) == 2 * min(len(trajectory) + 1, 12)


def test_frames_between_rows_are_on_straight_lines_in_joint_space(
    ik: jtik.InverseKinematics, trajectory: jtik.Trajectory
) -> None:
    frames = resampled(ik.robot, trajectory.q, trajectory.times, 2 * len(trajectory) - 1)
    np.testing.assert_allclose(frames[::2], trajectory.q, atol=1e-12)
    np.testing.assert_allclose(frames[1::2], (trajectory.q[1:] + trajectory.q[:-1]) / 2, atol=1e-12)


@pytest.mark.quick(1)
@pytest.mark.parametrize("speed", [1.0, 2.0])
def test_an_animation_takes_the_time_of_the_trajectory(
    ik: jtik.InverseKinematics, trajectory: jtik.Trajectory, tmp_path, speed: float
) -> None:
    file = tmp_path / "arm.gif"
    trajectory.animate(file, ik.robot, speed=speed, rate=10.0, width=2.0, obstacles=[jtik.Circle((0.5, 0.5), 0.1)])
    durations = []
    with image.open(file) as gif:
        for k in range(gif.n_frames):
            gif.seek(k)
            durations.append(gif.info["duration"])
    assert sum(durations[:-1]) / 1000 == pytest.approx(trajectory.times[-1] / speed, abs=0.051)


@pytest.mark.slow
def test_an_animation_in_space_moves(tmp_path) -> None:
    arm = jtik.Robot.builtin("ur5e")
    file = tmp_path / "arm.gif"
    plotting.write_motion(file, arm, [arm.home, arm.home + 0.5], width=2.0, show="links")
    with image.open(file) as gif:
        assert gif.n_frames == 2
        first = np.asarray(gif.convert("RGB")).astype(int)
        gif.seek(1)
        assert np.abs(np.asarray(gif.convert("RGB")).astype(int) - first).max() > 60


def test_another_suffix_is_refused(ik: jtik.InverseKinematics, trajectory: jtik.Trajectory, tmp_path) -> None:
    with pytest.raises(jtik.ArgumentError, match="gif"):
        trajectory.animate(tmp_path / "arm.mp4", ik.robot)


def test_a_trace_is_plotted_by_iteration(ik: jtik.InverseKinematics) -> None:
    trace = ik.solve((1.0, 1.0), q0=[0.2, 0.5, 0.7], trace=True).trace
    error, criterion, residual = trace.plot().axes
    np.testing.assert_array_equal(error.get_lines()[0].get_ydata(), np.maximum(trace.error, 1e-17))
    np.testing.assert_array_equal(criterion.get_lines()[0].get_ydata(), trace.H)
    np.testing.assert_allclose(residual.get_lines()[0].get_ydata(), np.maximum(trace.null_residual, 1e-17))
    assert residual.get_xlabel() == "iteration"


def test_attempts_of_a_trace_are_separate_lines(ik: jtik.InverseKinematics) -> None:
    trace = ik.solve((3.0, 0.0), q0=[0.2, 0.5, 0.7], restarts=2, trace=True).trace
    lines = [line for line in trace.plot().axes[0].get_lines() if line.get_linestyle() == "-"]
    assert len(lines) == len(np.unique(trace.attempt)) > 2
    assert sum(len(line.get_xdata()) for line in lines) == len(trace.error)


def test_the_rows_of_the_answer_are_those_of_its_attempt(ik: jtik.InverseKinematics) -> None:
    for seed in range(4):
        solution = ik.solve((3.0, 0.0), q0=[2.5, -2.9, 2.9], restarts=3, seed=seed, trace=True, max_iterations=7)
        trace = solution.trace
        rows = trace.answer_rows
        assert len(np.unique(trace.attempt[rows])) == 1
        assert len(rows) == (trace.attempt == trace.attempt[rows[0]]).sum()
        smallest = min(trace.error[:-1][trace.attempt == k][-1] for k in np.unique(trace.attempt))
        assert trace.error[-1] <= smallest + 1e-12
        step = np.abs(np.exp(1j * trace.q[rows[-1]]) - np.exp(1j * trace.q[-1])).max()
        assert step <= trace.step_length[rows[-1]] + 1e-9


def test_without_restarts_all_rows_lead_to_the_answer(ik: jtik.InverseKinematics) -> None:
    trace = ik.solve((1.0, 1.0), q0=[0.2, 0.5, 0.7], trace=True).trace
    np.testing.assert_array_equal(trace.answer_rows, np.arange(len(trace)))


def test_nothing_to_plot_is_refused(ik: jtik.InverseKinematics, trajectory: jtik.Trajectory) -> None:
    trace = ik.solve(ik.robot.position([0.2, 0.5, 0.7]), q0=[0.2, 0.5, 0.7], until="reached", trace=True).trace
    assert len(trace) == 0
    with pytest.raises(jtik.ArgumentError, match="at least one iteration"):
        trace.plot()


def test_a_solution_is_plotted_at_its_posture(ik: jtik.InverseKinematics) -> None:
    solution = ik.solve((1.0, 1.0), q0=[0.2, 0.5, 0.7])
    one, other = (
        figure.axes[0].collections[-1].get_segments() for figure in (solution.plot(ik.robot), ik.robot.plot(solution.q))
    )
    np.testing.assert_array_equal(one, other)
