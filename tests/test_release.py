"""What a release says of itself: one version everywhere, extras, and a description without links that lead nowhere."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

import jtik

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
EXTRAS = PROJECT["project"]["optional-dependencies"]
NOT_IN_ALL = {"all", "robots", "pink", "peers", "others", "test", "notebooks", "docs", "dev"}
"""Extras of other libraries, and for work on jtik."""


def packages(extra: str) -> set[str]:
    """The requirements of an extra, those of the extras that it names among them."""
    found = set()
    for requirement in EXTRAS[extra]:
        named = re.fullmatch(r"jtik\[(.+)\]", requirement)
        found |= set().union(*map(packages, named[1].split(","))) if named else {requirement}
    return found


def test_the_citation_and_the_changelog_have_the_version() -> None:
    cited = re.search(r"^version: (\S+)$", (ROOT / "CITATION.cff").read_text(encoding="utf-8"), flags=re.MULTILINE)
    titles = re.findall(r"^## \[(.+?)\]", (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"), flags=re.MULTILINE)
    assert cited
    assert cited[1] == jtik.__version__
    assert next(title for title in titles if title != "Unreleased") == jtik.__version__


def test_all_has_every_feature() -> None:
    features = EXTRAS.keys() - NOT_IN_ALL
    assert packages("all") == set().union(*map(packages, features))
    assert not any(package.startswith(("pin", "placo")) for package in packages("all"))


def test_an_error_names_an_extra_that_exists() -> None:
    folders = Path(jtik.__file__).parent, ROOT / "examples"
    text = "".join(path.read_text(encoding="utf-8") for folder in folders for path in sorted(folder.rglob("*.py")))
    named = set(re.findall(r"MissingExtraError\(\"[\w-]+\", \"([\w-]+)\"", text))
    for extras in re.findall(r"pip install '(?:jtik|\.)\[([\w,-]+)\]'", text):
        named |= set(extras.split(","))
    assert named >= {"plot", "view", "planner", "xacro"}
    assert named <= EXTRAS.keys()


def test_the_description_has_no_relative_link_or_picture() -> None:
    hook = PROJECT["tool"]["hatch"]["metadata"]["hooks"]["fancy-pypi-readme"]
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert "](docs/" in text
    for substitution in hook["substitutions"]:
        text = re.sub(substitution["pattern"], substitution["replacement"], text)
    assert not re.search(r"\]\((?!https?:)", text)
    assert "A ten-link arm" in text  # of the picture, in place of it


def test_contributing_lists_every_extra() -> None:
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    table = text[text.index("| extra | for |") :].split("\n\n")[0]
    assert set(re.findall(r"`([a-z]+)`", table.replace("`jtik plan`", "").replace("`jtik view`", ""))) >= EXTRAS.keys()
