"""The reference: one page for each public module, with an entry for every public name of it."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
import sys
from dataclasses import dataclass
from enum import Enum
from functools import cache, lru_cache
from itertools import pairwise
from types import ModuleType
from typing import Any, TypeVar

from site_pages.pages import Pages

MODULES = {
    "jtik": "everything a program begins with",
    "jtik_formulations": "the built-in strategies, null-space terms and criteria",
    "jtik.robot": "robots and their kinematics",
    "jtik.robot.gallery": "the robots that come with jtik",
    "jtik.task": "what must be",
    "jtik.criterion": "what you would like",
    "jtik.constraints": "what must hold",
    "jtik.strategy": "what a strategy is made of",
    "jtik.qp": "quadratic programs and their solvers",
    "jtik.result": "what a solver returns",
    "jtik.geometry": "obstacles and distances",
    "jtik.study": "comparisons",
    "jtik.study.peers": "other libraries in a comparison",
    "jtik.problems": "problems to compare on",
    "jtik.plotting": "pictures",
    "jtik.viewer": "robots in the browser",
    "jtik.planner": "the planner",
    "jtik.planner.edits.messages": "what a session of the planner can be asked for",
    "jtik.planner.edits.of_attempts": "the same of recorded attempts",
    "jtik.planner.session.frames": "what a session publishes",
    "jtik.interop": "mink, pink, MuJoCo, Pinocchio, URDF",
    "jtik.symbolic": "the mathematics of criteria and strategies",
    "jtik.testing": "the contract of criteria and strategies",
    "jtik.registry": "names and the classes behind them",
    "jtik.errors": "errors",
    "jtik.types": "array types",
    "jtik.progress": "progress of long calls",
}
"""The public modules, and what each is for."""

NO_INDEX = {"jtik.criterion": ["   :no-index:"]}
"""For a module with the name of a function, which has the entry."""


@dataclass(frozen=True)
class Entry:
    """A public name on the site.

    Attributes:
        name: where it is found by users, such as ``jtik.Robot``.
        value: the class, the function or another value.
        doc: its docstring; of a value that is neither class nor function, that below its assignment.
        page: the module on whose page it is.
    """

    name: str
    value: Any
    doc: str
    page: str

    @property
    def kind(self) -> str:
        """The directive that describes it: one of autodoc for what is jtik's own, else "data"."""
        if (getattr(self.value, "__module__", None) or "").partition(".")[0] not in ("jtik", "jtik_formulations"):
            return "data"
        if inspect.isclass(self.value):
            return "autoexception" if issubclass(self.value, Exception) else "autoclass"
        return "autofunction" if inspect.isroutine(self.value) else "data"

    @property
    def summary(self) -> str:
        """The first line of its docstring."""
        return self.doc.strip().split("\n\n")[0].replace("\n", " ")


def public_names(module: ModuleType) -> list[str]:
    """The names that a module has for others: ``__all__``, or what is defined in it without an underscore."""
    if hasattr(module, "__all__"):
        return [name for name in module.__all__ if not inspect.ismodule(getattr(module, name))]
    own = [name for name, value in vars(module).items() if getattr(value, "__module__", None) == module.__name__]
    named = dict.fromkeys(name for name in [*own, *_documented(module)] if not name.startswith("_"))
    return [name for name in named if not isinstance(getattr(module, name), TypeVar)]


def parts(module: ModuleType) -> list[ModuleType]:
    """The public modules of a package, for one whose own name stands for none of them."""
    if hasattr(module, "__all__") and module.__name__ != "jtik.symbolic":
        return []
    found = pkgutil.iter_modules(getattr(module, "__path__", []), f"{module.__name__}.")
    return [importlib.import_module(info.name) for info in found if not is_internal(info.name)]


def is_internal(module: str) -> bool:
    """Whether a module is private, or only has the former names of others."""
    last = module.rpartition(".")[2]
    return last.startswith("_") or last == "renamed"


@lru_cache
def entries() -> tuple[Entry, ...]:
    """Every public name once: as ``jtik.Name`` where it has that name, on the page of the module that it belongs to."""
    top = importlib.import_module("jtik")
    at_the_top = {id(getattr(top, name)): name for name in public_names(top)}
    found: dict[int | str, Entry] = {}
    for page in [*(name for name in MODULES if name != "jtik"), "jtik"]:
        package = importlib.import_module(page)
        for module in [package, *parts(package)]:
            for short in dict.fromkeys(public_names(module)):
                value = getattr(module, short)
                own = inspect.isclass(value) or inspect.isroutine(value) or id(value) in at_the_top
                key = id(value) if own else f"{page}.{short}"
                name = f"jtik.{at_the_top[id(value)]}" if id(value) in at_the_top else f"{module.__name__}.{short}"
                found.setdefault(key, Entry(name, value, _doc(module, short, value), page))
    return tuple(sorted(found.values(), key=lambda entry: (entry.name.count("."), entry.kind, entry.name.lower())))


def _doc(module: ModuleType, name: str, value: Any) -> str:
    if inspect.isclass(value) or inspect.isroutine(value):
        home = (value.__module__ or "").partition(".")[0]
        if home not in ("jtik", "jtik_formulations"):
            return f"``{home}.{value.__name__}``."
        return inspect.getdoc(value) or ""
    package = module.__name__.partition(".")[0]
    for source in [module, *_modules_below(package)]:
        if doc := _documented(source).get(name):
            return doc
    return ""


def _modules_below(package: str) -> list[ModuleType]:
    return [module for name, module in sorted(sys.modules.items()) if name.startswith(f"{package}.")]


@cache
def _documented(module: ModuleType) -> dict[str, str]:
    """The values that a module assigns with a docstring below, and the docstrings."""
    try:
        body = ast.parse(inspect.getsource(module)).body
    except (OSError, TypeError):
        return {}
    found = {}
    for statement, after in pairwise(body):
        target = statement.targets[0] if isinstance(statement, ast.Assign) else getattr(statement, "target", None)
        below = after.value if isinstance(after, ast.Expr) else None
        if isinstance(target, ast.Name) and isinstance(below, ast.Constant) and isinstance(below.value, str):
            found[target.id] = inspect.cleandoc(below.value)
    return found


def place(module: str) -> str:
    """Where the page of a module is on the site."""
    return f"reference/{module}.rst"


def reference_pages(pages: Pages) -> None:
    """The page of each public module, and the list of them."""
    for name in MODULES:
        pages.add(place(name), _page(importlib.import_module(name)))
    lines = ["# Reference", "", "Every public module, with every public class and function.", ""]
    lines += ["| module | for |", "| --- | --- |"]
    lines += [f"| [`{name}`]({name}.rst) | {what} |" for name, what in MODULES.items()]
    lines += ["", "```{toctree}", ":hidden:", ":maxdepth: 1", "", *MODULES, "```", ""]
    pages.add("reference/index.md", "\n".join(lines))
    pages.of["jtik/__init__.py"] = "reference/index.md"  # which says what is public


def _page(module: ModuleType) -> str:
    """A table of the names, what the module says of itself, and the entries."""
    title = module.__name__
    own = [entry for entry in entries() if entry.page == title]
    listed = own if title != "jtik" else [entry for entry in entries() if re.fullmatch(r"jtik\.\w+", entry.name)]
    lines = [title, "=" * len(title), ""]
    for part in [each.__name__ for each in parts(module)]:
        lines += [] if part in MODULES else [f".. py:module:: {part}", ""]
    lines += [f".. py:module:: {title}", *NO_INDEX.get(title, []), ""]
    if listed:
        lines += [".. list-table::", "   :widths: 30 70", ""]
    for entry in listed:
        lines += [f"   * - :py:obj:`~{entry.name}`", f"     - {in_rst(entry.summary)}"]
    lines += ["", *in_rst(inspect.getdoc(module) or "").splitlines(), ""]
    for entry in own:
        lines += [*_entry(entry), ""]
    return "\n".join(lines) + "\n"


def _entry(entry: Entry) -> list[str]:
    if entry.kind == "data":
        body = [f"   {line}" for line in in_rst(entry.doc).splitlines()]
        module, _, name = entry.name.rpartition(".")
        return [f".. py:data:: {name}", f"   :module: {module}", "", *body]
    lines = [f".. {entry.kind}:: {entry.name}"]
    if inspect.isclass(entry.value):
        known = {each.__name__ for each in entry.value.__mro__[1:] if not _is_mixin(each)}
        lines += ["   :members:", f"   :inherited-members: {', '.join(sorted(known))}"]
        lines += ["   :show-inheritance:"] if set(entry.value.__bases__) <= PUBLIC_CLASSES else []
        lines += ["   :undoc-members:"] if issubclass(entry.value, Enum) else []
    return lines


def _is_mixin(base: type) -> bool:
    """Whether a base is only a part of the classes that have it: one of jtik's that no public module names."""
    return base.__module__.partition(".")[0] in ("jtik", "jtik_formulations") and base not in PUBLIC_CLASSES


def in_rst(text: str) -> str:
    """A docstring as reStructuredText."""
    from site_pages.docstrings import escaped

    return "\n".join(escaped(text.splitlines()))


PUBLIC_CLASSES = {
    value
    for name in MODULES
    for module in [importlib.import_module(name)]
    for value in (getattr(module, each) for each in public_names(module))
    if inspect.isclass(value)
}
