"""Files of trajectories: back to the last bit, read by others, and those of earlier versions."""

from __future__ import annotations

import csv
import dataclasses
import json
import re

import numpy as np
import pytest

import jtik

from ..conftest import floating_arm, planar, shared_solver

SUFFIXES = [".npz", ".csv", ".json"]

CIRCLE = [(1.5 + 0.4 * np.cos(angle), 0.5 + 0.4 * np.sin(angle)) for angle in np.linspace(0, 6, 20)]


@pytest.fixture(scope="module")
def path():
    return shared_solver(planar(3), jtik.FrameTask()).track(CIRCLE, q0=[0.3, 0.4, 0.5], dt=0.1)


@pytest.fixture(scope="module")
def floating():
    """A path of a robot with a free joint, whose joint sizes differ."""
    robot = floating_arm()
    return shared_solver(robot, jtik.FrameTask(), joints="all").track(
        [robot.position(robot.neutral) + np.array([0.05, 0.02, 0.01])], q0=robot.neutral, dt=0.5
    )


def assert_same(path, again):
    for field in dataclasses.fields(path):
        before, after = getattr(path, field.name), getattr(again, field.name)
        if field.name in ("status", "joint_names", "joint_sizes", "complete"):
            assert before == after
        else:
            assert np.array_equal(before, after, equal_nan=True), field.name
            assert before.dtype == after.dtype
    assert repr(again) == repr(path)


@pytest.mark.thinned
@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("name", ["path", "floating"])
def test_files_bring_it_back_to_the_last_bit(name, suffix, tmp_path, request):
    path = request.getfixturevalue(name)
    path.save(tmp_path / f"circle{suffix}")
    again = jtik.Trajectory.load(str(tmp_path / f"circle{suffix}"))
    assert_same(path, again)
    assert again.start.tolist() == ([0.3, 0.4, 0.5] if name == "path" else floating_arm().neutral.tolist())


def test_pandas_reads_a_csv_as_it_is(path, tmp_path):
    pandas = pytest.importorskip("pandas")
    path.save(tmp_path / "circle.csv")
    table = pandas.read_csv(tmp_path / "circle.csv")
    joints = ["joint1", "joint2", "joint3"]
    assert table.columns[:4].tolist() == ["time", *joints]
    assert table.columns[4:7].tolist() == [f"velocity.{joint}" for joint in joints]
    assert len(table) == len(path) + 1
    assert table.loc[0, ["time", *joints]].tolist() == pytest.approx([0, 0.3, 0.4, 0.5])
    assert table.loc[0, "status"] == "START"
    assert table[joints].to_numpy()[1:] == pytest.approx(path.q, abs=1e-15)
    assert table["time"].to_numpy() == pytest.approx([0, *path.times])
    assert np.diff(table["joint2"]) / 0.1 == pytest.approx(table["velocity.joint2"][1:], abs=1e-12)
    assert table["iterations"].dtype == np.int64
    assert table["error_norm"].isna().tolist() == [True] + [False] * len(path)


def test_numpy_reads_a_csv_too(path, tmp_path):
    path.save(tmp_path / "circle.csv")
    table = np.genfromtxt(tmp_path / "circle.csv", delimiter=",", names=True, dtype=None, encoding=None)
    assert table["joint2"][1:] == pytest.approx(path.q[:, 1])


def test_entries_of_a_free_joint_have_numbers(floating, tmp_path):
    floating.save(tmp_path / "path.csv")
    titles = next(csv.reader((tmp_path / "path.csv").read_text().splitlines()))
    free = floating.joint_names[floating.joint_sizes.index(7)]
    assert [title for title in titles if title.startswith(free)] == [f"{free}[{i}]" for i in range(7)]
    assert [title for title in titles if title.startswith(f"velocity.{free}")] == [
        f"velocity.{free}[{i}]" for i in range(6)
    ]


ODD = ("time", "status", "velocity.a", "b[0]", "c (joint)", 'd, "e"\nf', "ü")


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_joints_may_have_any_name(suffix, tmp_path):
    k = len(ODD)
    rng = np.random.default_rng(0)
    path = jtik.Trajectory(
        times=np.array([0.1, 0.2]),
        start=rng.normal(size=k),
        q=rng.normal(size=(2, k)),
        dq=rng.normal(size=(2, k)),
        error_norm=rng.normal(size=2),
        position_error=rng.normal(size=2),
        orientation_error=np.array([np.nan, 1.0]),
        status=(jtik.Status.CONVERGED, jtik.Status.LIMITS),
        iterations=np.array([1, 2]),
        seconds=np.array([0.1, 0.2]),
        joint_names=ODD,
        joint_sizes=(1,) * k,
    )
    path.save(tmp_path / f"path{suffix}")
    assert_same(path, jtik.Trajectory.load(tmp_path / f"path{suffix}"))
    if suffix == ".csv":
        with (tmp_path / "path.csv").open(newline="", encoding="utf-8") as file:
            titles = next(csv.reader(file))
        assert len(set(titles)) == len(titles)


def test_a_json_is_plain(path, tmp_path):
    path.save(tmp_path / "circle.json")
    document = json.loads((tmp_path / "circle.json").read_text(), parse_constant=pytest.fail)
    assert document["q"] == path.q.tolist()
    assert document["start"] == [0.3, 0.4, 0.5]
    assert document["joint_names"] == ["joint1", "joint2", "joint3"]
    assert document["status"][0] == path.status[0].name


@pytest.mark.parametrize("name", ["path.txt", "path"])
def test_other_suffixes_are_refused(path, name, tmp_path):
    with pytest.raises(jtik.ArgumentError, match=r"\.csv, \.json, \.npz"):
        path.save(tmp_path / name)
    with pytest.raises(jtik.ArgumentError, match=r"\.csv, \.json, \.npz"):
        jtik.Trajectory.load(tmp_path / name)


def test_other_files_are_refused(path, tmp_path):
    path.save(tmp_path / "e.csv")
    saved = (tmp_path / "e.csv").read_text()
    lines = saved.splitlines(keepends=True)
    path.save(tmp_path / "p.json")
    document = json.loads((tmp_path / "p.json").read_text())
    wrong = {
        "a.csv": "x,y\n1,2\n",
        "b.csv": "# joints: a\ntimes,q[0]\n0.1,0.2\n",
        "e.csv": saved.replace("CONVERGED", "HAPPY", 1),
        "f.csv": "# joints: a\ntimes,q[0]\n0.1\n",
        "g.csv": "",
        "h.csv": saved.replace("0.1,", "much,", 1),
        "i.csv": lines[0] + lines[1][:-9],
        "j.csv": "\x00",
        "k.json": "[" * 100_000,
        "l.json": "[1, 2]",
        "m.json": json.dumps({**document, "q": [1.0]}),
        "n.json": json.dumps({**document, "q": document["q"][1:]}),
        "o.json": json.dumps({**document, "times": ["now"] * len(path)}),
    }
    for name, text in wrong.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "c.npz").write_bytes(b"not an archive")
    np.savez(tmp_path / "d.npz", times=np.zeros(2))
    for name in [*wrong, "c.npz", "d.npz"]:
        with pytest.raises(jtik.ArgumentError, match=re.escape(name)):
            jtik.Trajectory.load(tmp_path / name)
    with pytest.raises(jtik.ArgumentError, match="missing.csv; accepted: the path of a file that exists"):
        jtik.Trajectory.load(tmp_path / "missing.csv")


OLD_CSV = """# joints: joint1,joint2
times,q[0],q[1],dq[0],dq[1],errors,statuses,iterations,seconds
0.5,0.25,0.5,0.1,0.2,1e-09,CONVERGED,4,0.001
1.0,0.5,0.75,0.5,0.5,0.125,LIMITS,7,0.002
"""


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_files_of_earlier_versions_are_read(suffix, tmp_path):
    """They have only the norm of all rows of the error, and other names for two columns."""
    file = tmp_path / f"old{suffix}"
    if suffix == ".csv":
        file.write_text(OLD_CSV)
    else:
        np.savez(
            file,
            times=np.array([0.5, 1.0]),
            q=np.array([[0.25, 0.5], [0.5, 0.75]]),
            dq=np.array([[0.1, 0.2], [0.5, 0.5]]),
            errors=np.array([1e-9, 0.125]),
            statuses=np.array(["CONVERGED", "LIMITS"]),
            iterations=np.array([4, 7]),
            seconds=np.array([0.001, 0.002]),
            joint_names=np.array(["joint1", "joint2"]),
        )
    path = jtik.Trajectory.load(file)
    assert path.times.tolist() == [0.5, 1.0]
    assert path.q.tolist() == [[0.25, 0.5], [0.5, 0.75]]
    assert path.dq.tolist() == [[0.1, 0.2], [0.5, 0.5]]
    assert path.error_norm.tolist() == [1e-9, 0.125]
    assert path.status == (jtik.Status.CONVERGED, jtik.Status.LIMITS)
    assert path.iterations.tolist() == [4, 7]
    assert path.joint_names == ("joint1", "joint2")
    assert np.isnan(path.position_error).all()
    assert np.isnan(path.orientation_error).all()
    assert np.isnan(path.start).all()
    assert path.joint_sizes == (1, 1)
    path.save(tmp_path / f"new{suffix}")
    again = jtik.Trajectory.load(tmp_path / f"new{suffix}")
    assert np.array_equal(again.position_error, path.position_error, equal_nan=True)
    assert np.array_equal(again.q, path.q)
    assert np.isnan(again.start).all()
    assert again.status == path.status


def test_an_earlier_file_of_a_ball_joint_does_not_say_which_joint_it_is(floating, tmp_path):
    floating.save(tmp_path / "new.npz")
    with np.load(tmp_path / "new.npz") as archive:
        old = {name: archive[name] for name in archive if name not in ("start", "joint_sizes")}
    np.savez(tmp_path / "old.npz", **old)
    path = jtik.Trajectory.load(tmp_path / "old.npz")
    assert path.joint_sizes == ()
    with pytest.raises(jtik.ArgumentError, match=r"joint_sizes"):
        path.save(tmp_path / "old.csv")
    path.save(tmp_path / "old.json")
    assert_same(path, jtik.Trajectory.load(tmp_path / "old.json"))
