"""Which file of the repository is which page of the site, and the files that are written for them."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

from site_pages.links import rewrite
from site_pages.mathematics import displayed

DOCUMENTS = {
    "formulations/README.md": "theory/formulations.md",
    "papers/das1988/README.md": "theory/das1988.md",
    "benchmarks/README.md": "benchmarks.md",
    "CONTRIBUTING.md": "contributing.md",
    "CHANGELOG.md": "changelog.md",
}
"""Pages outside docs/, by their place in the repository, beside the derivations."""

LANGUAGES = {".py": "python", ".toml": "toml", ".csv": "text", ".cff": "yaml", ".xml": "xml", ".urdf": "xml"}
"""Languages of files that are shown as they are."""

PICTURES = (".png", ".svg", ".gif")


class Pages:
    """The pages of the site, as text by their place below the folder of sources.

    Attributes:
        root: the repository.
        target: the folder of sources.
        of: for each file of the repository that is a page, its place on the site.
    """

    def __init__(self, root: Path, target: Path) -> None:
        self.root, self.target = root, target
        self.of: dict[str, str] = {}
        self._texts: dict[str, str] = {}
        self._copies: dict[str, Path] = {}
        self._origin: dict[str, str] = {}
        self._later: list[Callable[[], object]] = []

    def add_documents(self) -> None:
        """Every Markdown file that is a page: those in docs/, the derivations, and `DOCUMENTS`."""
        for path in sorted((self.root / "docs").rglob("*.md")):
            self._document(path, path.relative_to(self.root / "docs").as_posix())
        for path in sorted((self.root / "formulations").glob("*.md")):
            self._document(path, f"theory/{path.name}")
        for name, place in DOCUMENTS.items():
            self._document(self.root / name, place)
        self.of |= {"README.md": "index.md", "formulations": "theory/formulations.md"}
        self.of |= {"benchmarks": "benchmarks.md", "docs": "index.md"}

    def _document(self, path: Path, place: str) -> None:
        name = path.relative_to(self.root).as_posix()
        self.of[name] = DOCUMENTS.get(name, place)
        self.add(self.of[name], path.read_text(encoding="utf-8"), origin=name)

    def add(self, place: str, text: str, *, origin: str | None = None) -> None:
        """A page. With ``origin``, links in it are relative to that file of the repository."""
        self._texts[place] = text
        if origin is not None:
            self._origin[place] = origin

    def later(self, action: Callable[[], object]) -> None:
        """Something that is done when the place of every page is known."""
        self._later.append(action)

    def copy(self, path: Path, place: str) -> None:
        """A file that a page shows, as it is."""
        self._copies[place] = path

    def source(self, name: str) -> str:
        """The page that shows a file of the repository as it is, which is made when it is first asked for."""
        if name not in self.of:
            path = self.root / name
            self.of[name] = f"source/{name}.md"
            language = LANGUAGES.get(path.suffix, "text")
            fence = "````"
            text = f"---\norphan: true\n---\n\n# {name}\n\n{fence}{{code-block}} {language}\n:linenos:\n\n"
            self.add(self.of[name], f"{text}{path.read_text(encoding='utf-8')}\n{fence}\n")
        return self.of[name]

    def write(self) -> None:
        """Rewrite all links, and write what has changed."""
        for action in self._later:
            action()
        done: dict[str, str] = {}
        while todo := [place for place in self._texts if place not in done]:  # a link may ask for another page
            for place in todo:
                text, origin = self._texts[place], self._origin.get(place)
                if origin is not None:
                    text = displayed(rewrite(self, text, origin, place))
                done[place] = text
        wanted = {*done, *self._copies}
        for path in [path for path in self.target.rglob("*") if path.is_file()]:
            if path.relative_to(self.target).as_posix() not in wanted:
                path.unlink()
        for place, text in done.items():
            self._save(place, text.encode("utf-8"))
        for place, path in self._copies.items():
            self._save(place, path.read_bytes())
        for folder in sorted((path for path in self.target.rglob("*") if path.is_dir()), reverse=True):
            if not any(folder.iterdir()):
                shutil.rmtree(folder)

    def _save(self, place: str, content: bytes) -> None:
        path = self.target / place
        if not path.is_file() or path.read_bytes() != content:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
