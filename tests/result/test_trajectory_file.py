"""Files of trajectories: back to the last bit, read by others, and those of earlier versions."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import jtik

from ..conftest import planar

CIRCLE = [(1.5 + 0.4 * np.cos(angle), 0.5 + 0.4 * np.sin(angle)) for angle in np.linspace(0, 6, 20)]


@pytest.fixture(scope="module")
def path():
    return jtik.InverseKinematics(planar(3), jtik.FrameTask()).track(CIRCLE, q0=[0.3, 0.4, 0.5], dt=0.1)


@pytest.mark.parametrize("suffix", [".npz", ".csv"])
def test_files_bring_it_back_to_the_last_bit(path, suffix, tmp_path):
    path.save(tmp_path / f"circle{suffix}")
    again = jtik.Trajectory.load(str(tmp_path / f"circle{suffix}"))
    for field in dataclasses.fields(path):
        before, after = getattr(path, field.name), getattr(again, field.name)
        assert np.array_equal(before, after)
        assert type(before) is type(after)
    assert again.dq.dtype == np.float64
    assert repr(again) == repr(path)


def test_a_csv_is_a_table_that_others_read(path, tmp_path):
    path.save(tmp_path / "circle.csv")
    lines = (tmp_path / "circle.csv").read_text().splitlines()
    assert lines[0] == "# joints: joint1,joint2,joint3"
    assert lines[1].startswith("times,q[0],q[1],q[2],dq[0]")
    table = np.genfromtxt(tmp_path / "circle.csv", delimiter=",", skip_header=1, names=True, dtype=None, encoding=None)
    assert table["q1"] == pytest.approx(path.q[:, 1])


@pytest.mark.parametrize("name", ["path.txt", "path"])
def test_other_suffixes_are_refused(path, name, tmp_path):
    with pytest.raises(jtik.ArgumentError, match=r"\.npz or \.csv"):
        path.save(tmp_path / name)
    with pytest.raises(jtik.ArgumentError, match=r"\.npz or \.csv"):
        jtik.Trajectory.load(tmp_path / name)


def test_other_files_are_refused(path, tmp_path):
    (tmp_path / "a.csv").write_text("x,y\n1,2\n")
    (tmp_path / "b.csv").write_text("# joints: a\ntimes,q[0]\n0.1,0.2\n")
    (tmp_path / "c.npz").write_bytes(b"not an archive")
    np.savez(tmp_path / "d.npz", times=np.zeros(2))
    path.save(tmp_path / "e.csv")
    (tmp_path / "e.csv").write_text((tmp_path / "e.csv").read_text().replace("CONVERGED", "HAPPY", 1))
    (tmp_path / "f.csv").write_text("# joints: a\ntimes,q[0]\n0.1\n")
    for name in "abcdef":
        suffix = ".npz" if name in "cd" else ".csv"
        with pytest.raises(jtik.ArgumentError, match=f"{name}{suffix}"):
            jtik.Trajectory.load(tmp_path / f"{name}{suffix}")
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
    path.save(tmp_path / f"new{suffix}")
    again = jtik.Trajectory.load(tmp_path / f"new{suffix}")
    assert np.array_equal(again.position_error, path.position_error, equal_nan=True)
    assert again.status == path.status
