"""The site: every page has its links, and every public name, formulation, notebook and example has its page."""

from __future__ import annotations

import importlib
import importlib.util
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

import jtik

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
NOT_PUBLIC = {"arguments", "cli", "constructors", "demo", "factorization", "solver", "svd"}
"""What is at the top of jtik and not for programs: the command line, readers of arguments, former places."""


@pytest.fixture(scope="module")
def staged(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The sources of the site, without running notebooks and examples. A link to nothing is an error here."""
    pytest.importorskip("jupytext")
    sys.path.insert(0, str(DOCS))
    try:
        yield importlib.import_module("site_pages").stage(ROOT, tmp_path_factory.mktemp("site"), run=False)
    finally:
        sys.path.remove(str(DOCS))


@pytest.fixture(scope="module")
def reference(staged: Any) -> ModuleType:
    return importlib.import_module("site_pages.reference")


def text(staged: Any, place: str) -> str:
    return str((staged.target / place).read_text(encoding="utf-8"))


def test_every_public_module_has_a_page(reference: ModuleType) -> None:
    there = {path.name.removesuffix(".py") for path in (ROOT / "jtik").iterdir() if path.suffix in ("", ".py")}
    public = {f"jtik.{name}" for name in there if not name.startswith("_")} - {f"jtik.{name}" for name in NOT_PUBLIC}
    named = set(re.findall(r"`(jtik\.\w+)`", (jtik.__doc__ or "").partition("are these modules")[2]))
    assert public | named <= reference.MODULES.keys()


def test_every_public_name_has_an_entry(reference: ModuleType, staged: Any) -> None:
    entries = {entry.name: entry for entry in reference.entries()}
    names = [name for name in jtik.__all__ if not isinstance(getattr(jtik, name), ModuleType)]
    assert [name for name in names if f"jtik.{name}" not in entries] == []
    for name in reference.MODULES:
        values = {id(entry.value) for entry in entries.values()}
        module = importlib.import_module(name)
        assert [each for each in reference.public_names(module) if id(getattr(module, each)) not in values] == []
    for entry in entries.values():
        page = text(staged, reference.place(entry.page))
        assert re.search(
            rf"^\.\. [\w:]+:: ({re.escape(entry.name)}|{entry.name.rpartition('.')[2]})$", page, re.MULTILINE
        )


def test_built_in_strategies_and_criteria_have_their_methods(reference: ModuleType, staged: Any) -> None:
    page = text(staged, reference.place("jtik_formulations"))
    assert page.count(".. autoclass::") == page.count("   :members:\n") > 40


def test_nothing_private_has_an_entry(reference: ModuleType) -> None:
    assert [entry.name for entry in reference.entries() if "._" in entry.name] == []


def test_every_registered_name_has_its_derivation_and_its_module(staged: Any) -> None:
    page = text(staged, "theory/index.md")
    rows = dict(re.findall(r"^\| `(\w+)` \| (.*) \|$", page, flags=re.MULTILINE))
    for registry in (jtik.strategies, jtik.criteria, jtik.secondaries):
        for name, plugin in registry.loaded().items():
            if plugin.__module__.startswith("jtik_formulations"):
                assert f"{plugin.__module__.rpartition('.')[2]}.py](" in rows[name]
                derivation = re.search(r"\[\w+\]\((\w+\.md)\)", rows[name])
                assert derivation is not None
                assert f'"{name}"' in (ROOT / "formulations" / derivation[1]).read_text(encoding="utf-8") or (
                    registry is jtik.secondaries
                )


def test_every_notebook_and_example_is_in_the_gallery(staged: Any) -> None:
    page = text(staged, "gallery/index.md")
    for folder, ending in (("notebooks", "_notebook.ipynb"), ("examples", ".md")):
        for path in (ROOT / folder).glob("*.py"):
            assert f"]({path.stem}{ending}):" in page, path
            assert (staged.target / "gallery" / f"{path.stem}{ending}").is_file()


def test_links_lead_to_pages(staged: Any) -> None:
    page = text(staged, "guides/control_loops.md")
    assert "](../theory/motion.md)" in page
    assert "](../source/jtik/_step/active_set.py.md)" in text(staged, "theory/formulations.md")
    assert "](../../" not in page


def test_mathematics_keeps_its_tags(staged: Any) -> None:
    page = text(staged, "theory/joint_centering.md")
    assert "```{math}\n:nowrap:\n\n\\[\n" in page
    assert "\\tag{J1}" in page


def test_a_page_begins_with_something_to_look_at() -> None:
    """No wall of text: a table, a picture, code or a list is among the first 25 lines of every guide."""
    for path in sorted([*(DOCS / "start").glob("*.md"), *(DOCS / "guides").glob("*.md")]):
        first = path.read_text(encoding="utf-8").splitlines()[:25]
        assert any(line.startswith(("|", "!", "```", "- ")) for line in first), path


def test_without_the_extra_one_line_says_what_to_install(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    spec = importlib.util.spec_from_file_location("build_the_site", DOCS / "build.py")
    assert spec is not None
    assert spec.loader is not None
    build = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(build)
    monkeypatch.setattr(build, "NEEDED", ("sphinx", "no_such_package"))
    monkeypatch.setattr(sys, "argv", ["build.py"])
    assert build.main() == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "no_such_package" in error
    assert 'pip install ".[docs]"' in error


def test_a_notebook_that_is_executed_beside_its_script_is_used(staged: Any, tmp_path: Path) -> None:
    jupytext = importlib.import_module("jupytext")
    runs = importlib.import_module("site_pages.runs")
    script = tmp_path / "notebooks" / "two.py"
    script.parent.mkdir()
    script.write_text("# %% [markdown]\n# # Two\n#\n# lines\n\n# %%\n1 + 1\n\n# %%\nx = 3\nx\n", encoding="utf-8")
    notebook = jupytext.read(script)
    output = importlib.import_module("nbformat.v4").new_output("stream", name="stdout", text="2, from before")
    notebook["cells"][1]["outputs"] = [output]
    script.with_suffix(".ipynb").write_text(jupytext.writes(notebook, fmt="ipynb"), encoding="utf-8")
    used = runs.executed(script, tmp_path / "kept")
    assert "".join(used["cells"][1]["outputs"][0]["text"]) == "2, from before"
    assert used["cells"][0]["source"] == "# Two\n\nlines"
    assert not (tmp_path / "kept").exists()
    used["cells"][1]["outputs"] = [{"data": {"image/png": "QUJD"}}]
    picture = runs.picture_in(used, tmp_path / "kept" / "two.png")
    assert picture.read_bytes() == b"ABC"


def test_an_example_is_run_once_and_says_why_it_could_not(staged: Any, tmp_path: Path) -> None:
    runs = importlib.import_module("site_pages.runs")
    script = tmp_path / "examples" / "one.py"
    script.parent.mkdir()
    script.write_text("import os\nprint(len(os.listdir()))\nopen('seen', 'w').close()\n", encoding="utf-8")
    assert [runs.ran(script, tmp_path / "kept").printed for _ in range(2)] == ["0\n", "0\n"]
    script.write_text("raise SystemExit('install no_such_package')\n", encoding="utf-8")
    assert runs.ran(script, tmp_path / "kept").printed == "not run here: install no_such_package\n"


def test_a_link_to_nothing_is_an_error(staged: Any, tmp_path: Path) -> None:
    page = importlib.import_module("site_pages.pages").Pages(ROOT, tmp_path)
    page.of["docs/guides/robots.md"] = "guides/robots.md"
    page.add("guides/x.md", "[there](robots.md), [gone](no_such_page.md)", origin="docs/guides/x.md")
    with pytest.raises(FileNotFoundError, match=r"docs/guides/x\.md: the link to docs/guides/no_such_page\.md"):
        page.write()
