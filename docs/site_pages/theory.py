"""Theory: one table from every law to its module, its derivation and its source, made from the registry."""

from __future__ import annotations

import inspect
import posixpath
import re
from pathlib import Path

import jtik
from site_pages.pages import Pages

KINDS = {
    "Strategies": ("strategies", "`strategy=`"),
    "Null-space steps": ("secondaries", "after a `+`"),
    "Criteria": ("criteria", "`criteria=`"),
}
"""Titles of the tables, and the registry and the use of the names of each."""

HEAD = """# Theory

From each law to its derivation, the module that computes it, and where it is from. A derivation has a table of symbols
with units, labelled equations, constants with their reasons, what is guaranteed and what is not.

- For an introduction read [transpose](transpose.md), [newton](newton.md), [hybrid](hybrid.md) and [merit](merit.md) in
  this order.
- [All formulations](formulations.md): the equation of each and when to prefer it, and what the engine does for all.
- [The paper's claims](das1988.md): what Das, Slotine and Sheridan (1988) say, and what was measured.
"""


def theory_pages(pages: Pages) -> None:
    """The table, and below it every derivation."""
    derivations = derivation_of(pages.root)
    lines = [HEAD]
    for title, (registry, use) in KINDS.items():
        lines += [f"## {title}", "", f"| {use} | law | derivation, module | source |", "| --- | --- | --- | --- |"]
        for name, plugin in getattr(jtik, registry).loaded().items():
            if not plugin.__module__.startswith("jtik_formulations"):
                continue  # of another package
            path = Path(inspect.getfile(plugin)).resolve().relative_to(pages.root.resolve()).as_posix()
            module = posixpath.relpath(pages.source(path), "theory")
            derived = derivations[path]
            links = f"[{derived.removesuffix('.md')}]({derived}), [{Path(path).name}]({module})"
            lines.append(f"| `{name}` | {plugin.summary} | {links} | {plugin.source} |")
        lines.append("")
    lines += ["```{toctree}", ":hidden:", "", "formulations", "das1988"]
    lines += [path.stem for path in sorted((pages.root / "formulations").glob("*.md")) if path.stem != "README"]
    pages.add("theory/index.md", "\n".join([*lines, "```", ""]))


def derivation_of(root: Path) -> dict[str, str]:
    """For each module that a derivation names at its head, the file of that derivation.

    A module that several name belongs to the one that names it first.
    """
    found: dict[str, tuple[int, str]] = {}
    for path in sorted((root / "formulations").glob("*.md")):
        head = re.search(r"^Modules?:.*?(?=\n\n)", path.read_text(encoding="utf-8"), flags=re.DOTALL | re.MULTILINE)
        for rank, link in enumerate(re.findall(r"\]\(([^)]+\.py)\)", head[0] if head else "")):
            module = posixpath.normpath(f"formulations/{link}")
            found[module] = min(found.get(module, (rank, path.name)), (rank, path.name))
    return {module: name for module, (_, name) in found.items()}
