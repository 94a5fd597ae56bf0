"""Every command in the README, the guides and docs/guides/command_line.md runs, with the files that the page shows."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path

import pytest

import jtik
from jtik import demo
from jtik.cli import main
from jtik.study import html

from .conftest import Capture

pytest.importorskip("matplotlib")
pytest.importorskip("rich")

ROOT = Path(__file__).parents[2]
PAGES = (
    "README.md",
    "CONTRIBUTING.md",
    "formulations/README.md",
    *(
        path.relative_to(ROOT).as_posix()
        for folder in ("start", "guides")
        for path in sorted((ROOT / "docs" / folder).glob("*.md"))
    ),
)
PAGE = (ROOT / "docs" / "guides" / "command_line.md").read_text(encoding="utf-8")
FILES = dict(re.findall(r"<!-- file: (\S+) -->\n```\w+\n(.*?)```", PAGE, flags=re.DOTALL))

SHORTER = [(r"reachable:\d+", "reachable:1"), (r"(boundary|line):\d+", r"\1:1"), (r" --jobs \d+", " --repeats 1")]
"""What the tests change, as the commands of a study are long: fewer problems and rounds, in this process."""


def commands(page: str) -> list[str]:
    """The lines of a page's shell blocks that call jtik."""
    blocks = re.findall(r"```bash\n(.*?)```", (ROOT / page).read_text(encoding="utf-8"), flags=re.DOTALL)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    return [line.rpartition("&& ")[2].strip() for line in lines if re.match(r"(.*&& )?jtik ", line)]


def is_slow(command: str) -> bool:
    """Whether it takes several seconds: pictures of the demo, and studies of many strategies or with clearances."""
    return command.startswith("jtik demo") or "weighted_qp" in command or "compare --file" in command


COMMANDS = [
    pytest.param(command, marks=[pytest.mark.slow] if is_slow(command) else [])
    for page in PAGES
    for command in commands(page)
]


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    (tmp_path / "robot.urdf").write_text(FILES["arm.urdf"], encoding="utf-8")
    return tmp_path


@pytest.mark.quick(6)
@pytest.mark.parametrize("command", COMMANDS)
def test_a_command_runs(command: str, folder: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    for old, new in SHORTER:
        command = re.sub(old, new, command)
    words = shlex.split(command, comments=True)[1:]
    if words[0] == "demo":
        monkeypatch.setattr(demo, "strategies", ("hybrid", "newton"))
        words = [*words, "--quick"]
    if words[0] == "compare":  # one picture in the report; tests/study/test_html.py has all of them
        monkeypatch.setattr(html, "_figures", lambda comparison: [("Profile", comparison.plot_profile())])
    assert main(words) == 0
    out, err = capsys.readouterr()
    assert out
    assert err == "" or "--json" in words
    for option in ("--out", "--plot", "--csv", "--trace"):
        if option in words:
            assert Path(words[words.index(option) + 1]).exists()
    if "--json" in words:
        json.loads(out, parse_constant=pytest.fail)


def test_every_command_has_an_example() -> None:
    assert {command.split()[1] for command in commands("docs/guides/command_line.md")} >= {
        "list",
        "robot",
        "solve",
        "compare",
        "demo",
    }
    assert len(commands("README.md")) >= 6


@pytest.mark.slow
def test_the_problem_file_is_the_first_example_of_the_readme(folder: Path, capsys: Capture) -> None:
    """The same arm, field and criteria by hand give the same configuration."""
    from jtik_formulations import JointCentering, ObstacleAvoidance

    assert main(["solve", "--file", "problem.toml", "--json"]) == 0
    q = json.loads(capsys.readouterr().out)["q"]
    arm = jtik.Robot.planar(10, lower=-2.5, upper=2.5)
    field = [jtik.Circle(center=(4.0, 2.0), radius=0.6), jtik.Circle(center=(6.5, -1.0), radius=0.8)]
    ik = jtik.InverseKinematics(
        arm,
        jtik.FrameTask("tip"),
        criteria=1.0 * JointCentering() + 0.3 * ObstacleAvoidance(field, bodies="both"),
        strategy="hybrid+qp",
    )
    assert q == pytest.approx(ik.solve([6.0, 3.0], q0=[0.1] * 10, restarts=5).q)
