"""The Python of the README and of every page of docs/start and docs/guides runs as it stands there."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
import pytest

import jtik

ROOT = Path(__file__).parents[1]
ELSEWHERE = {"statuses.md", "view.md", "write_a_criterion.md", "command_line.md"}
"""Pages with tests of their own."""

SLOW = {"clearances.md", "studies.md"}
"""Pages that build self-collision or run a study."""

SHORTER = [
    ("range(1000)", "range(20)"),
    ('"reachable": 20', '"reachable": 2'),
    ('"near_singular": 20', '"near_singular": 2'),
    ("check_strategy(NearSingular())", "check_strategy(NearSingular(), samples=1)"),
]
"""What the tests change: fewer problems and starts."""

PYTHON = re.compile(r"^```python\n(.*?)^```", flags=re.DOTALL | re.MULTILINE)
PAGES = [
    pytest.param(path.relative_to(ROOT).as_posix(), marks=[pytest.mark.slow] if path.name in SLOW else [], id=path.stem)
    for folder in ("start", "guides")
    for path in sorted((ROOT / "docs" / folder).glob("*.md"))
    if path.name not in ELSEWHERE and PYTHON.search(path.read_text(encoding="utf-8"))
]


def run(page: str) -> dict[str, Any]:
    """The names after all Python blocks of a page, run in its order."""
    text = (ROOT / page).read_text(encoding="utf-8")
    names: dict[str, Any] = {}
    for code in PYTHON.findall(text):
        for old, new in SHORTER:
            code = code.replace(old, new)
        exec(compile(code, page, "exec", dont_inherit=True), names)
    return names


def test_the_readme(capsys: pytest.CaptureFixture[str]) -> None:
    names = run("README.md")
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    printed = capsys.readouterr().out.splitlines()
    shown = re.findall(r"```text\n(.*?)```", text, flags=re.DOTALL)[0].splitlines()
    assert printed[0] == shown[0]
    assert printed[1] == shown[1]
    assert names["ik"].parameters["elbow_height.height"] == -1.0


def test_guides_have_code() -> None:
    assert len(PAGES) >= 12


@pytest.mark.quick(5)
@pytest.mark.parametrize("page", PAGES)
def test_a_page_runs(page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    matplotlib.use("agg")
    names = run(page)
    if check := CHECKS.get(Path(page).stem):
        assert check(names)


def test_what_first_program_prints_is_what_it_shows(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    matplotlib.use("agg")
    run("docs/start/first_program.md")
    text = (ROOT / "docs" / "start" / "first_program.md").read_text(encoding="utf-8")
    shown = re.findall(r"```text\n(.*?)```", text, flags=re.DOTALL)[0].splitlines()
    assert capsys.readouterr().out.splitlines()[:2] == shown[:2]


CHECKS = {
    "first_program": lambda n: n["solution"].converged and n["moved"].converged,
    "reading_a_solution": lambda n: n["quick"].iterations <= n["solution"].iterations,
    "choose_a_strategy": lambda n: n["solution"].converged,
    "choose_a_criterion": lambda n: (
        n["further"].criteria["obstacle_avoidance"] / 3 < n["solution"].criteria["obstacle_avoidance"]
    ),
    "robots": lambda n: n["solution"].converged and not n["far"].converged and n["floating"].nq == n["floating"].n + 1,
    "control_loops": lambda n: (
        n["trajectory"].converged
        and n["step"].position_error < 1e-3
        and np.linalg.norm(n["panda"].position(n["q"]) - n["hand"]) < 2e-3
        and Path("path.csv").is_file()
    ),
    "clearances": lambda n: (
        n["solution"].converged
        and n["above"].converged
        and n["too_low"].status is jtik.Status.BLOCKED
        and "panda_hand" in n["too_low"].active_clearances[0]
    ),
    "weights_and_priorities": lambda n: n["solution"].converged,
    "batches": lambda n: n["batch"].converged.all() and len(n["postures"]) == 4,
    "studies": lambda n: (
        isinstance(n["comparison"], jtik.Comparison)
        and Path("profile.png").is_file()
        and len(n["own"].summary()["contender"]) == 6
    ),
    "compiled_code": lambda n: isinstance(n["ik"], jtik.InverseKinematics),
    "write_a_strategy": lambda n: n["ik"].solve([3.0, 1.5], q0=[0.3, 0.2, -0.1, 0.2]).converged,
}
"""What holds after a page has run, by its name: what the text says."""
