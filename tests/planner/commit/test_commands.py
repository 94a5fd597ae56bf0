"""Files of joint commands: read back to the last bit, by pandas and PyYAML too, and verified by forward kinematics."""

from __future__ import annotations

import csv
import json

import numpy as np
import pytest

import jtik
from jtik.errors import ArgumentError
from jtik.planner.commit.commands import FORMATS, JointCommands, export, file_name, load
from jtik.planner.commit.committing import as_recorded, timed

from ...conftest import ball_arm
from ..conftest import make_attempt

NAMES = ("shoulder", 'x: [1, 2] # "é"', "lift")


def commands(k=7) -> JointCommands:
    """Numbers of every size, and names that a table or YAML might take for something else."""
    rng = np.random.default_rng(0)
    arrays = [rng.normal(size=(k, 3)) * 10.0 ** rng.integers(-12, 12, (k, 3)) for _ in range(3)]
    arrays[0][0] = [0.0, -0.0, 1e22]
    arrays[1][0] = [1e-05, 3.0, -2e-300]
    rows = dict(zip(("positions", "velocities", "accelerations"), arrays, strict=True))
    times = np.arange(k) * 0.1
    return JointCommands(
        name="attempt 1.2", times=times, joint_names=NAMES, units=("rad", "rad", "m"), method="toppra", note="n", **rows
    )


def same(a: JointCommands, b: JointCommands) -> bool:
    arrays = ("times", "positions", "velocities", "accelerations")
    return (a.joint_names, a.units) == (b.joint_names, b.units) and all(
        getattr(a, name).tobytes() == getattr(b, name).tobytes() for name in arrays
    )


@pytest.mark.parametrize("format", ["csv", "json", "npz"])
def test_reading_back_gives_every_bit(tmp_path, format):
    given = commands()
    found = load(export(given, tmp_path / f"a.{format}"))
    assert same(given, found)
    if format != "csv":
        assert (found.name, found.method, found.note) == ("attempt 1.2", "toppra", "n")


def test_pandas_reads_the_table(tmp_path):
    pandas = pytest.importorskip("pandas")
    given = commands()
    frame = pandas.read_csv(export(given, tmp_path / "a.csv"))
    assert frame.columns[0] == "time [s]"
    assert list(frame.columns[1:4]) == [f"{name} [{unit}]" for name, unit in zip(NAMES, given.units, strict=True)]
    assert frame.columns[-1] == "acceleration.lift [m/s^2]"
    assert frame.columns[5] == f"velocity.{NAMES[1]} [rad/s]"
    assert np.allclose(frame.to_numpy()[:, 1:4], given.positions, rtol=1e-15, atol=0)


@pytest.mark.parametrize("format", ["ros2_json", "ros2_yaml"])
def test_a_ros_2_message_has_the_fields_of_joint_trajectory(tmp_path, format):
    given = commands()
    path = export(given, tmp_path / file_name(given, format), format)
    assert path.name.startswith("attempt-1.2.ros2")
    text = path.read_text(encoding="utf-8")
    message = json.loads(text) if format == "ros2_json" else pytest.importorskip("yaml").safe_load(text)
    assert list(message) == ["header", "joint_names", "points"]
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    assert tuple(message["joint_names"]) == NAMES
    assert len(message["points"]) == len(given)
    for i, point in enumerate(message["points"]):
        assert list(point) == ["positions", "velocities", "accelerations", "effort", "time_from_start"]
        for key in ("positions", "velocities", "accelerations"):
            assert all(type(value) is float for value in point[key])
            assert np.array(point[key]).tobytes() == getattr(given, key)[i].tobytes()
        time = point["time_from_start"]
        assert time["sec"] + time["nanosec"] * 1e-9 == pytest.approx(given.times[i], abs=1e-9)
        assert 0 <= time["nanosec"] < 10**9


@pytest.mark.slow
def test_a_file_read_back_leads_the_end_effector_along_the_path(tmp_path):
    """A circle of the end effector, timed, written, read by the csv module alone, checked by forward kinematics."""
    arm = jtik.Robot.planar(3)
    ik = jtik.InverseKinematics(arm, jtik.FrameTask("tip", kind="position"))
    angle = np.linspace(0, 2 * np.pi, 120)
    targets = np.stack([1.6 + 0.5 * np.cos(angle), 0.4 + 0.5 * np.sin(angle)], axis=1)
    q0 = ik.solve(targets[0], q0=[0.3, 0.5, 0.5]).q
    q = np.concatenate([[q0], ik.track(targets[1:], q0=q0, dt=0.05).q])
    attempt = make_attempt(k=120, configurations=q, targets=targets, times=np.arange(120) * 0.05)
    path = export(timed(attempt, arm, period=0.02), tmp_path / "circle.csv")
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    columns = [f"{name} [rad]" for name in arm.joint_names]
    positions = np.array([[float(row[name]) for name in columns] for row in rows])
    tips = np.array([arm.position(each) for each in positions])
    radius = np.linalg.norm(tips - [1.6, 0.4], axis=1)
    assert np.abs(radius - 0.5).max() < 2e-3
    turned = np.unwrap(np.arctan2(tips[:, 1] - 0.4, tips[:, 0] - 1.6))
    assert turned[-1] - turned[0] == pytest.approx(2 * np.pi, abs=1e-6)
    assert (np.diff(turned) >= -1e-9).all()


def test_a_recorded_attempt_keeps_its_times(tmp_path):
    arm, attempt = jtik.Robot.planar(3), make_attempt(k=9)
    found = load(export(as_recorded(attempt, arm), tmp_path / "a.json"))
    assert (found.times == attempt.times).all()
    assert (found.positions == attempt.configurations).all()
    with pytest.raises(ArgumentError, match="revolute and prismatic"):
        as_recorded(make_attempt(nq=10), ball_arm())


def test_wrong_formats_and_paths_are_refused(tmp_path):
    with pytest.raises(ArgumentError, match="csv"):
        export(commands(), tmp_path / "a.txt")
    with pytest.raises(ArgumentError, match="format"):
        export(commands(), tmp_path / "a.csv", "bag")
    with pytest.raises(OSError, match="No such file"):
        export(commands(), tmp_path / "none" / "a.csv")
    assert list(tmp_path.iterdir()) == []
    assert {file_name(commands(), format).count("/") for format in FORMATS} == {0}
    assert file_name(JointCommands(**(vars(commands()) | {"name": "../../π"})), "csv") == "attempt.csv"


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("a.csv", b""),
        ("a.csv", b"time,a\n1,2\n"),
        ("a.csv", b"time [s],a [rad],velocity.a [rad/s],acceleration.a [rad/s^2]\n1,2,x,3\n"),
        ("a.csv", b"time [s],a [rad],velocity.a [rad/s],acceleration.a [rad/s^2]\n1,2\n"),
        ("a.csv", b"time [s],a [rad],velocity.a [rad/s],acceleration.a [rad/s^2]\n"),
        ("a.csv", b"\xff\xfe"),
        ("a.json", b"[1]"),
        ("a.json", b"{}"),
        ("a.json", b"[" * 200_000),
        ("a.npz", b"PK"),
        ("a.txt", b""),
    ],
)
def test_a_strangers_file_is_refused_by_its_name(tmp_path, name, content):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ArgumentError, match=name):
        load(tmp_path / name)


@pytest.mark.parametrize("key", ["joint_names", "units", "times", "positions"])
def test_a_file_whose_parts_do_not_fit_is_refused(tmp_path, key):
    path = export(commands(), tmp_path / "a.json")
    data = json.loads(path.read_text())
    for value in (None, [], [1], "x"):
        path.write_text(json.dumps(data | {key: value}))
        with pytest.raises(ArgumentError, match="a.json"):
            load(path)
