"""The gallery: every notebook and every example, with its picture and what it prints."""

from __future__ import annotations

import json
import posixpath
import re
from pathlib import Path

from site_pages.links import rewrite
from site_pages.mathematics import displayed
from site_pages.pages import Pages
from site_pages.runs import Run, as_written, executed, picture_in, ran

SECTION = re.compile(r"^\| ([^|\[]+) \| \|$", flags=re.MULTILINE)
EXAMPLE = re.compile(r"^\| \[(\w+)\.py\]\([^)]*\) \| (.*) \|$")
NOTEBOOK = re.compile(r"^\| \[(\w+)\]\([^)]*\) \| (.*) \|$", flags=re.MULTILINE)

TABLE = ("| | |", "| --- | --- |")

WORDS = {"urdf": "URDF", "mujoco": "MuJoCo", "dask": "Dask"}
"""Words of file names that are written in another way."""

LEADING_HERE = ("examples", "examples/README.md", "notebooks", "notebooks/README.md")
"""What a link of the repository names that is the gallery on the site."""


def gallery_pages(pages: Pages, *, run: bool = True) -> None:
    """A page for each notebook and each example, and the tables that lead to them.

    Without ``run`` nothing is executed, and the pages have no output.
    """
    pages.of |= dict.fromkeys(LEADING_HERE, "gallery/index.md")
    notebooks = {path.stem: path for path in sorted((pages.root / "notebooks").glob("*.py"))}
    examples = {path.stem: path for path in sorted((pages.root / "examples").glob("*.py"))}
    pages.of |= {f"notebooks/{name}.py": f"gallery/{name}_notebook.ipynb" for name in notebooks}
    pages.of |= {f"examples/{name}.py": f"gallery/{name}.md" for name in examples}
    kept = pages.target.parent / "runs" if run else None
    lines = ["# Gallery", "", "## Notebooks", "", *TABLE]
    for name, what in NOTEBOOK.findall((pages.root / "notebooks" / "README.md").read_text(encoding="utf-8")):
        picture = _notebook(pages, name, notebooks[name], kept)
        lines.append(f"| {picture} | [{_title(name)}]({name}_notebook.ipynb): {what} |")
    lines += ["", "To run one: `jupytext --to ipynb notebooks/*.py`, then `jupyter lab notebooks`.", ""]
    lines += ["## Examples", "", "Scripts to copy, each shorter than 65 lines.", ""]
    for line in (pages.root / "examples" / "README.md").read_text(encoding="utf-8").splitlines():
        if section := SECTION.match(line):
            lines += ["", f"### {section[1].capitalize()}", "", *TABLE]
        elif example := EXAMPLE.match(line):
            name, what = example.groups()
            lines.append(f"| {_example(pages, name, examples[name], kept)} | [{_title(name)}]({name}.md): {what} |")
    lines += ["", "```{toctree}", ":hidden:", ":maxdepth: 1", ""]
    lines += [*(f"{name}_notebook" for name in notebooks), *examples]
    pages.add("gallery/index.md", "\n".join([*lines, "```", ""]))


def _title(name: str) -> str:
    return " ".join(WORDS.get(word, word) for word in name.capitalize().split("_"))


def _notebook(pages: Pages, name: str, path: Path, kept: Path | None) -> str:
    """Add the page of a notebook. Returns its picture in the table."""
    notebook, origin = executed(path, kept) if kept else as_written(path), f"notebooks/{name}.py"
    place = pages.of[origin]

    def write() -> None:
        for cell in notebook["cells"]:
            if cell["cell_type"] == "markdown":
                cell["source"] = displayed(rewrite(pages, cell["source"], origin, place))
        pages.add(place, json.dumps(notebook, indent=1, sort_keys=True))

    pages.later(write)
    return _picture(pages, name, picture_in(notebook, kept / f"{name}.png") if kept else None)


def _picture(pages: Pages, name: str, path: Path | None) -> str:
    if path is None:
        return ""
    pages.copy(path, f"gallery/pictures/{name}{path.suffix}")
    return f"![{_title(name)}](pictures/{name}{path.suffix})"


def _example(pages: Pages, name: str, path: Path, kept: Path | None) -> str:
    """Add the page of an example. Returns its picture in the table, or the first line that it prints."""
    run, code = ran(path, kept) if kept else Run("", None), path.read_text(encoding="utf-8")
    doc, _, rest = code.removeprefix('"""').partition('"""')
    drawn = path.parent / "pictures" / f"{name}.png"
    picture = _picture(pages, name, drawn if drawn.is_file() else run.picture)
    lines = [f"# {_title(name)}", "", doc.strip().split("\n\n")[0], ""]
    if picture:
        lines += [picture, ""]
    lines += ["```python", rest.strip(), "```", ""]
    if run.printed:
        lines += ["It prints:", "", "```text", run.printed.rstrip(), "```", ""]
    lines += [f"From a checkout: `python {posixpath.join('examples', path.name)}`.", ""]
    pages.add(f"gallery/{name}.md", "\n".join(lines))
    first = next((line for line in run.printed.splitlines() if line.strip()), "")
    return picture or (f"`{first[:70].replace('|', '/').replace('`', '')}`" if first else "")
