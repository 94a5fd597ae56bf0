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
NOT_PUBLIC = {"arguments", "cli", "demo", "factorization", "solver", "svd"}
"""What is at the top of jtik and not for programs: the command line, readers of arguments, and former places."""


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
