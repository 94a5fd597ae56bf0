"""jtik.factorization and jtik.svd still import, with a warning that names the new module."""

from __future__ import annotations

import importlib
import sys

import pytest


@pytest.mark.parametrize(
    ("former", "present", "name"),
    [
        ("jtik.factorization", "jtik.symbolic.factorization", "RowSpace"),
        ("jtik.svd", "jtik.symbolic.svd", "SingularValues"),
    ],
)
def test_a_former_module_warns_and_has_the_same_objects(former, present, name):
    sys.modules.pop(former, None)
    with pytest.warns(DeprecationWarning, match=f"^{former} is now {present}$") as caught:
        module = importlib.import_module(former)
    assert getattr(module, name) is getattr(importlib.import_module(present), name)
    assert len(caught) == 1
    sys.modules.pop(former)


def test_nothing_else_imports_them():
    """Importing the library and its formulations loads neither."""
    import jtik

    assert jtik.strategies
    assert jtik.criteria
    for former in ("jtik.factorization", "jtik.svd"):
        assert former not in sys.modules
