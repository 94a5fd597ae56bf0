"""Imports the scripts of a paper by name, as they import each other when they are run."""

import importlib
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).parents[2] / "papers" / "das1988"


@pytest.fixture(scope="session")
def script():
    """``script(name)``: the module of papers/das1988 with that name."""
    sys.path.insert(0, str(FOLDER))
    yield importlib.import_module
    sys.path.remove(str(FOLDER))
