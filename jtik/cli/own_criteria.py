"""Criteria of the user's own, which an option or a document names as ``module.py:name``."""

from __future__ import annotations

import importlib.util
import sys
import zlib
from collections.abc import Iterable
from pathlib import Path
from types import ModuleType
from typing import Any

from jtik.cli.checks import InputError
from jtik.criterion import Criterion
from jtik.errors import UnknownNameError

ACCEPTED = "a function with the decorator @jtik.criterion, a jtik.Criterion, or a class of criteria"


def is_own(name: str) -> bool:
    """Whether a name is that of a criterion in a file."""
    return ".py:" in name


def own_criterion(name: str) -> Any:
    """The criterion, or the class of criteria, that is called ``module.py:name``. The file is run once.

    Raises:
        InputError: when there is no such file, it cannot be run, or what has the name is no criterion.
        UnknownNameError: when the file defines no such name.
    """
    file, _, attribute = name.rpartition(":")
    module = load_module(file)
    if attribute not in vars(module):
        found = [key for key, value in vars(module).items() if isinstance(value, Criterion)]
        raise UnknownNameError(f"criterion of {file}", attribute, found)
    criterion = vars(module)[attribute]
    if isinstance(criterion, Criterion) or (isinstance(criterion, type) and issubclass(criterion, Criterion)):
        return criterion
    raise InputError(f"criterion {name!r}: given a {type(criterion).__name__}; accepted: {ACCEPTED}")


def load_module(file: str) -> ModuleType:
    """The module of a file, which is run when it is first asked for. Other files of its folder can be imported.

    Raises:
        InputError: when there is no such file, or running it raises an error.
    """
    path = Path(file).absolute()
    name = f"{path.stem}_{zlib.crc32(str(path).encode()):08x}"  # the same in every process, for pickled criteria
    if name in sys.modules:
        return sys.modules[name]
    if not path.is_file():
        raise InputError(f"{file}: no such file")
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = sys.modules[name] = importlib.util.module_from_spec(spec)
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:  # what a user's file may raise
        del sys.modules[name]
        raise InputError(f"{file}: {type(error).__name__}: {error}") from error
    return module


def load_modules(files: Iterable[str]) -> None:
    """Run each of the files, in a process that is to unpickle criteria of theirs."""
    for file in files:
        load_module(file)
