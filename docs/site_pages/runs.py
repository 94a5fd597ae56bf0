"""Notebooks and examples, run once; what they show is kept until their text changes."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

LONGEST = 600
"""Time after which a notebook's cell, or an example, is stopped [s]."""


@dataclass(frozen=True)
class Run:
    """What an example has left.

    Attributes:
        printed: what it printed; where it could not run, the line that says why.
        picture: the picture that it wrote, if any.
    """

    printed: str
    picture: Path | None


def environment(root: Path) -> dict[str, str]:
    """The variables under which a script finds this checkout and uses one core."""
    roots = [str(root), str(root / "formulations"), os.environ.get("PYTHONPATH", "")]
    return {**os.environ, "PYTHONPATH": os.pathsep.join(roots), "OMP_NUM_THREADS": "1"}


def ran(path: Path, kept: Path) -> Run:
    """Run an example in a folder of its own, unless it was run before with the same text."""
    folder = kept / f"{path.stem}-{_digest(path)}"
    if not (folder / "printed.txt").is_file():
        folder.mkdir(parents=True, exist_ok=True)
        command = [sys.executable, str(path)]
        ended = subprocess.run(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            env={**environment(path.parents[1]), "MPLBACKEND": "agg"},
            capture_output=True,
            text=True,
            timeout=LONGEST,
            check=False,
        )
        printed = ended.stdout
        if ended.returncode:
            printed = f"not run here: {ended.stderr.strip().splitlines()[-1]}\n"
        (folder / "printed.txt").write_text(printed, encoding="utf-8")
    pictures = sorted(each for each in folder.iterdir() if each.suffix in (".png", ".gif"))
    return Run((folder / "printed.txt").read_text(encoding="utf-8"), pictures[0] if pictures else None)


def executed(path: Path, kept: Path) -> dict[str, Any]:
    """A notebook with its outputs: the ``.ipynb`` beside it where that has been executed, else one executed here."""
    import jupytext

    source = jupytext.read(path)
    beside = path.with_suffix(".ipynb")
    if beside.is_file():
        there = json.loads(beside.read_text(encoding="utf-8"))
        if _same(source, there) and any(cell.get("outputs") for cell in there["cells"]):
            return _joined(there)
    stored = kept / f"{path.stem}-{_digest(path)}.ipynb"
    if not stored.is_file():
        import nbformat
        from nbclient import NotebookClient

        kept.mkdir(parents=True, exist_ok=True)
        client = NotebookClient(source, timeout=LONGEST, resources={"metadata": {"path": str(kept)}})
        client.execute(env=environment(path.parents[1]), stderr=subprocess.DEVNULL)
        nbformat.write(source, stored)
    return _joined(json.loads(stored.read_text(encoding="utf-8")))


def picture_in(notebook: dict[str, Any], path: Path) -> Path | None:
    """The last picture of an executed notebook, written to a file."""
    pictures = [
        output["data"]["image/png"]
        for cell in notebook["cells"]
        for output in cell.get("outputs", [])
        if "image/png" in output.get("data", {})
    ]
    if not pictures:
        return None
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(base64.b64decode("".join(pictures[-1])))
    return path


def as_written(path: Path) -> dict[str, Any]:
    """A notebook without outputs."""
    import jupytext

    notebook: dict[str, Any] = jupytext.read(path)
    return notebook


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16]


def _same(source: Any, there: dict[str, Any]) -> bool:
    """Whether two notebooks have the same cells."""
    return [cell.source for cell in source.cells] == ["".join(cell["source"]) for cell in there["cells"]]


def _joined(notebook: dict[str, Any]) -> dict[str, Any]:
    """The notebook with the text of each cell in one piece."""
    for cell in notebook["cells"]:
        cell["source"] = "".join(cell["source"])
    return notebook
