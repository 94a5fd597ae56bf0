"""The snippets of docs/coming_from run as they stand, and both libraries find the same.

The blocks of a page run in its order, each library in a namespace of its own. Those of jtik always run; the other
library is compared where it is installed.
"""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

import jtik
from jtik.interop.mink import to_mujoco
from jtik.interop.urdf import to_urdf

PAGES = Path(__file__).parents[1] / "docs" / "coming_from"
POSE = 1e-5
"""What the loops of the pages leave of a pose [m], [rad]."""

TIMEOUT = 1.5
"""What TRAC-IK gets instead of the pages' timeouts [s], which a machine with other work may exceed."""


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """panda.urdf and panda.xml, in the directory in which the snippets run."""
    panda = jtik.Robot.builtin("panda")
    text = to_urdf(panda)
    (tmp_path / "panda.urdf").write_text(text, encoding="utf-8")
    spec = mujoco.MjSpec.from_string(text)
    spec.compiler.fusestatic = False
    model = to_mujoco(panda)
    for i in range(model.ngeom):
        body = spec.body(model.body(model.geom_bodyid[i]).name)
        place = {"pos": model.geom_pos[i], "quat": model.geom_quat[i]}
        body.add_geom(type=model.geom_type[i], size=model.geom_size[i], mass=0.0, **place)
    spec.add_key(name="home", qpos=panda.home)
    spec.compile()
    (tmp_path / "panda.xml").write_text(spec.to_xml(), encoding="utf-8")
    monkeypatch.chdir(tmp_path)


class Page:
    """The blocks of a page, which run up to a title.

    Attributes:
        names: the names of each library after the blocks so far.
    """

    def __init__(self, name: str) -> None:
        text = (PAGES / f"{name}.md").read_text(encoding="utf-8")
        text = re.sub(r"timeout=0\.\d+", f"timeout={TIMEOUT}", text)
        self._sections = re.split(r"^## ", text, flags=re.MULTILINE)[1:]
        self.names: dict[str, dict[str, Any]] = {}

    def run(self, title: str, *libraries: str) -> list[dict[str, Any]]:
        """The names of each library after its blocks under a title."""
        section = next(one for one in self._sections if one.startswith(title + "\n"))
        blocks = dict(re.findall(r"^\*\*(.+?)\*\*\n\n```python\n(.*?)```", section, flags=re.MULTILINE | re.DOTALL))
        for library in libraries:
            exec(blocks[library], self.names.setdefault(library, {"__name__": library}))
        return [self.names[library] for library in libraries]


def pose_errors(found: np.ndarray, wanted: np.ndarray) -> float:
    return float(np.abs(found - wanted).max())


def test_every_page_has_both_sides_and_the_words() -> None:
    index = (PAGES / "index.md").read_text(encoding="utf-8")
    for path in sorted(PAGES.glob("*.md")):
        if path.stem == "index":
            continue
        text = path.read_text(encoding="utf-8")
        assert f"({path.name})" in index
        assert text.count("**jtik**\n\n```python") >= 4
        assert "\n## Words\n" in text
        assert "\n## Where " in text


@pytest.mark.slow
def test_mink() -> None:
    page, both = Page("mink"), ("mink", "jtik")
    theirs, ours = page.run("Load a robot", *both)
    panda = ours["panda"]
    assert theirs["configuration"].q == pytest.approx(ours["home"], abs=1e-12)

    page.run("Reach a pose", *both)
    assert ours["solution"].converged
    assert pose_errors(panda.pose(ours["solution"].q, "tip"), ours["goal"]) < POSE
    assert pose_errors(panda.pose(theirs["configuration"].q, "tip"), ours["goal"]) < POSE

    page.run("Stay near a posture", *both)
    assert ours["solution"].converged
    assert theirs["configuration"].q == pytest.approx(ours["solution"].q, abs=1e-4)

    page.run("A control loop within limits", *both)
    for names in (theirs, ours):
        speeds = np.diff(names["path"], axis=0) / 0.002
        assert np.abs(speeds).max() <= 1.5 + 1e-6
        assert pose_errors(panda.pose(names["path"][-1], "tip"), ours["goal"]) < POSE
    assert np.abs(np.diff(speeds, axis=0)).max() / 0.002 <= 10.0 + 1e-6

    page.run("Keep links off an obstacle", *both)
    scene, data, distances = theirs["scene"], mujoco.MjData(theirs["scene"]), []
    for q in (theirs["configuration"].q, ours["solution"].q):
        data.qpos[:] = q
        mujoco.mj_forward(scene, data)
        distances.append(
            min(mujoco.mj_geomDistance(scene, data, i, *theirs["table"], 1.0, None) for i in theirs["arm"])
        )
    print(distances)
    assert 0.005 <= distances[0] <= 0.01
    assert 0.02 - 1e-6 <= distances[1] <= 0.021
    assert ours["solution"].status is jtik.Status.BLOCKED


@pytest.mark.slow
def test_pink() -> None:
    pytest.importorskip("pink")
    page, both = Page("pink"), ("pink", "jtik")
    theirs, ours = page.run("Load a robot", *both)
    panda = ours["panda"]

    page.run("Reach a pose", *both)
    goal = theirs["goal"].homogeneous
    assert ours["solution"].converged
    assert pose_errors(goal, ours["goal"]) < 1e-12
    assert pose_errors(panda.pose(ours["solution"].q, "tip"), goal) < POSE
    assert pose_errors(panda.pose(theirs["configuration"].q, "tip"), goal) < POSE

    page.run("Stay near a posture", *both)
    assert ours["solution"].converged
    assert theirs["configuration"].q == pytest.approx(ours["solution"].q, abs=1e-4)

    page.run("A control loop within limits", *both)
    for names in (theirs, ours):
        speeds = np.diff(names["path"], axis=0) / 0.002
        assert np.abs(speeds).max() <= 1.5 + 1e-6
        assert np.abs(np.diff(speeds, axis=0)).max() / 0.002 <= 10.0 + 1e-3
        assert pose_errors(panda.pose(names["path"][-1], "tip"), goal) < POSE

    page.run("Stay above a height", *both)
    heights = [panda.position(q, "tip")[2] for q in (theirs["configuration"].q, ours["solution"].q)]
    assert heights == pytest.approx([0.2, 0.21], abs=1e-3)
    assert ours["solution"].status is jtik.Status.BLOCKED


@pytest.mark.slow
def test_robotics_toolbox() -> None:
    page, installed = Page("robotics_toolbox"), importlib.util.find_spec("roboticstoolbox") is not None
    libraries = ("jtik", "Robotics Toolbox") if installed else ("jtik",)
    ours = page.run("Load a robot", *libraries)[0]
    robot = ours["robot"]

    for title in ("A table of Denavit and Hartenberg", "Reach a pose", "Manipulability with the freedom that is left"):
        found = page.run(title, *libraries)
        if title.startswith("A table"):
            poses = [names["pose"] for names in found]
            assert poses[0] == pytest.approx(poses[-1], abs=1e-12)
        else:
            for names in found:
                assert pose_errors(robot.pose(names["q"], "tip"), ours["goal"]) < 1e-4
    assert ours["solution"].converged
    assert found[-1]["q"] == pytest.approx(ours["q"], abs=1e-4)

    for names in page.run("Follow a line", *libraries):
        wanted = np.add(robot.position(ours["home"], "tip"), [0.0, 0.2, -0.1])
        assert robot.position(names["path"][-1], "tip") == pytest.approx(wanted, abs=1e-5)
    assert ours["trajectory"].converged


@pytest.mark.slow
def test_pybullet() -> None:
    page, installed = Page("pybullet"), importlib.util.find_spec("pybullet") is not None
    libraries = ("jtik", "PyBullet") if installed else ("jtik",)
    ours, *theirs = page.run("Load a robot", *libraries)
    robot = ours["arm"]

    def errors() -> list[float]:
        return [float(np.linalg.norm(robot.position(names["q"], "tip") - ours["goal"][:3, 3])) for names in both]

    both = page.run("Reach a pose", *libraries)
    assert ours["solution"].converged
    assert max(errors()) < 1e-6
    for names in theirs:
        assert 0.008 < names["first_error"] < 0.01

    both = page.run("Stay near a posture", *libraries)
    assert ours["solution"].converged
    assert errors()[0] < 1e-6
    for _ in theirs:
        assert 5e-4 < errors()[1] < 1e-3

    for names in page.run("A control loop within limits", *libraries):
        assert robot.position(names["path"][-1], "tip") == pytest.approx(ours["goal"][:3, 3], abs=1e-3)
    assert robot.position(ours["path"][-1], "tip") == pytest.approx(ours["goal"][:3, 3], abs=1e-6)


@pytest.mark.slow
def test_moveit_and_trac_ik() -> None:
    page, installed = Page("moveit_trac_ik"), importlib.util.find_spec("trac_ik") is not None
    libraries = ("jtik", "TRAC-IK") if installed else ("jtik",)
    ours = page.run("Load a robot", *libraries)[0]
    robot, home = ours["robot"], ours["home"]

    for names in page.run("Reach a pose", *libraries):
        assert pose_errors(robot.pose(names["q"], "tip"), ours["goal"]) < POSE
    _, *theirs = page.run("Know why a pose cannot be reached", *libraries)
    assert ours["too_far"].status in (jtik.Status.LOCAL_MINIMUM, jtik.Status.LIMITS)
    assert all(names["too_far"] is None for names in theirs)

    distances = []
    for names in page.run("The solution nearest to the seed", *libraries):
        assert pose_errors(robot.pose(names["q"], "tip"), ours["goal"]) < POSE
        distances.append(np.linalg.norm(names["q"] - home))
    assert distances[0] <= distances[-1] + 1e-4
