"""``jtik view`` prints an address, serves until it is closed, and refuses wrong input."""

from __future__ import annotations

import urllib.request
from pathlib import Path

import numpy as np
import pytest

import jtik
from jtik.cli import main
from jtik.viewer import Viewer

from .conftest import Capture

pytest.importorskip("viser")


@pytest.fixture
def seen(monkeypatch: pytest.MonkeyPatch) -> list[tuple[int, dict[str, np.ndarray], int]]:
    """What a viewer shows while the command waits: the status of its page, q, and its number of obstacles."""
    found = []

    def wait(viewer: Viewer) -> None:
        with urllib.request.urlopen(viewer.url, timeout=10) as answer:
            found.append((answer.status, viewer.q, len(viewer.obstacles)))

    monkeypatch.setattr(Viewer, "wait", wait)
    return found


def test_a_robot_is_shown(seen, capsys: Capture) -> None:
    assert main(["view", "ur5e", "--q0", "0.1", "-0.2", "0.3", "-0.4", "0.5", "-0.6"]) == 0
    ((status, q, obstacles),) = seen
    assert (status, obstacles) == (200, 0)
    np.testing.assert_array_equal(q["ur5e"], [0.1, -0.2, 0.3, -0.4, 0.5, -0.6])
    assert "http://127.0.0.1:" in capsys.readouterr().out


def test_a_trajectory_and_a_scene_are_shown(seen, tmp_path: Path) -> None:
    ik = jtik.InverseKinematics(jtik.Robot.planar(3), jtik.FrameTask(kind="position"))
    trajectory = ik.track([(2.0, 0.5), (2.0, 0.6)], q0=[0.2, 0.5, -0.9])
    trajectory.save(tmp_path / "motion.csv")
    scene = jtik.Scene({"one": jtik.Circle((1.0, 1.0), 0.2), "off": jtik.Circle((2.0, 1.0), 0.2)}, {"off": 0.0})
    scene.save(tmp_path / "scene.toml")
    given = ["--trajectory", str(tmp_path / "motion.csv"), "--scene", str(tmp_path / "scene.toml")]
    assert main(["view", "planar:3", *given]) == 0
    ((_, q, obstacles),) = seen
    np.testing.assert_allclose(q["planar3"], [0.2, 0.5, -0.9])
    assert obstacles == 1


def test_a_study_is_shown(seen, tmp_path: Path) -> None:
    arm = jtik.Robot.planar(3)
    study = jtik.compare(arm, jtik.FrameTask(kind="position"), strategies=["newton", "hybrid"], count=1, repeats=1)
    study.save(tmp_path / "study.npz")
    assert main(["view", str(tmp_path / "study.npz")]) == 0
    assert list(seen[0][1]) == ["newton", "hybrid"]


@pytest.mark.parametrize(
    "words",
    [
        ["nobody"],
        ["planar:3", "--q0", "1"],
        ["planar:3", "--port", "80"],
        ["planar:3", "--scene", "none.toml"],
        ["planar:3", "--trajectory", "none.csv"],
        ["none.npz"],
        ["none.npz", "--q0", "1"],
    ],
)
def test_wrong_input_is_one_line(words: list[str], capsys: Capture) -> None:
    assert main(["view", *words]) == 2
    assert capsys.readouterr().err.count("\n") == 1
