"""solve_batch: the Solutions of many targets, as arrays."""

from __future__ import annotations

import sys

import numpy as np
import pytest

import jtik

from ...conftest import dh_arm, planar, shared_solver

ARM = dh_arm(7, 3, limit=1.5)


@pytest.fixture(scope="module")
def targets():
    rng = np.random.default_rng(2)
    return np.array([ARM.pose(ARM.random_configuration(rng)) for _ in range(12)])


def solver(**options):
    return shared_solver(ARM, jtik.FrameTask("tip", "pose"), strategy="damped", **options)


def test_is_each_solved_by_itself(targets):
    ik = solver()
    batch = ik.solve_batch(targets, restarts=30)
    assert len(batch) == 12
    for i, target in enumerate(targets):
        alone, seen = ik.solve(target, restarts=30), batch[i]
        assert np.array_equal(batch.q[i], alone.q)
        for name in ("status", "converged", "iterations", "escapes", "restarts", "position_error", "orientation_error"):
            assert getattr(seen, name) == getattr(alone, name)
        assert np.array_equal(seen.jacobian, alone.jacobian)
        assert batch.position_error[i] == pytest.approx(alone.position_error, abs=1e-15)
        assert batch.orientation_error[i] == pytest.approx(alone.orientation_error, abs=1e-15)
    assert [s.iterations for s in batch] == batch.iterations.tolist()
    assert batch[-1].iterations == batch.iterations[-1]
    assert "12 of 12 solved" in repr(batch)


def test_failures_stay_in_their_rows():
    ik = shared_solver(planar(3), jtik.FrameTask())
    batch = ik.solve_batch([(1.0, 1.0), (9.0, 0.0), (2.0, 1.0)], q0=[0.3, 0.4, 0.5])
    assert batch.converged.tolist() == [True, False, True]
    assert batch.status[1] is jtik.Status.LOCAL_MINIMUM
    assert batch.position_error[1] == pytest.approx(6.0, abs=1e-6)
    assert jtik.Status.LOCAL_MINIMUM.value in repr(batch)


def test_a_start_each():
    ik = shared_solver(planar(3), jtik.FrameTask())
    starts = np.array([[0.3, 0.4, 0.5], [-0.3, -0.4, -0.5]])
    batch = ik.solve_batch([(2.0, 1.0), (2.0, 1.0)], q0=starts)
    assert np.array_equal(batch.q, [ik.solve((2.0, 1.0), q0=q0).q for q0 in starts])
    assert not np.array_equal(batch.q[0], batch.q[1])


def test_several_tasks_and_none():
    tasks = [jtik.FrameTask("tip", name="hand"), jtik.FrameTask("link3", axes="y", name="elbow")]
    ik = shared_solver(planar(5), tasks)
    batch = ik.solve_batch([{"hand": (3.0, 1.0), "elbow": (0.0, 0.5)}] * 2, q0=[0.3] * 5)
    assert batch.converged.all()
    nothing = ik.solve_batch([])
    assert (len(nothing), nothing.q.shape) == (0, (0, 5))
    assert "0 of 0" in repr(nothing)


def test_progress_is_reported():
    reported = []
    ik = shared_solver(planar(3), jtik.FrameTask())
    ik.solve_batch([(1.0, 1.0), (2.0, 1.0)], progress=lambda done, total: reported.append((done, total)))
    assert reported == [(1, 2), (2, 2)]


def test_a_progress_bar_is_shown_only_on_request(capsys, monkeypatch):
    ik = shared_solver(planar(3), jtik.FrameTask())
    ik.solve_batch([(1.0, 1.0)])
    assert capsys.readouterr() == ("", "")
    ik.solve_batch([(1.0, 1.0)], progress=True)
    assert "targets" in capsys.readouterr().err
    monkeypatch.setitem(sys.modules, "rich.progress", None)
    with pytest.raises(jtik.MissingExtraError, match="rich"):
        ik.solve_batch([(1.0, 1.0)], progress=True)


def test_what_is_wrong_is_named():
    ik = shared_solver(planar(3), jtik.FrameTask())
    with pytest.raises(jtik.ArgumentError, match=r"targets\[1\]"):
        ik.solve_batch([(1.0, 1.0), (np.nan, 1.0)])
    with pytest.raises(jtik.ArgumentError, match="q0"):
        ik.solve_batch([(1.0, 1.0)], q0=np.zeros((2, 3)))
    two = shared_solver(planar(3), [jtik.FrameTask(), jtik.FrameTask("link2", name="elbow")])
    with pytest.raises(jtik.ArgumentError, match=r"targets\[0\]\['elbow'\]"):
        two.solve_batch([{"tip": (1.0, 1.0), "elbow": (1.0,)}])
