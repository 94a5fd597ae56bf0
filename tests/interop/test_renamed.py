"""Deprecated names of `jtik.interop`."""

from __future__ import annotations

from importlib import import_module

import pytest


@pytest.mark.parametrize(
    ("package", "module", "old", "new"),
    [
        ("mujoco", "mujoco_model", "Correspondence", "MujocoCorrespondence"),
        ("mink", "mink", "Correspondence", "MujocoCorrespondence"),
        ("mink", "mink", "CriterionTask", "MinkCriterionTask"),
        ("mink", "mink", "TaskCriterion", "MinkTaskCriterion"),
        ("pinocchio", "pinocchio_model", "Correspondence", "PinocchioCorrespondence"),
        ("pinocchio", "pink", "Correspondence", "PinocchioCorrespondence"),
        ("pinocchio", "pink", "CriterionTask", "PinkCriterionTask"),
        ("pinocchio", "pink", "TaskCriterion", "PinkTaskCriterion"),
    ],
)
def test_an_old_name_warns_and_is_the_new_class(package, module, old, new):
    pytest.importorskip(package)
    found = import_module(f"jtik.interop.{module}")
    with pytest.warns(DeprecationWarning, match=f"jtik.interop.{module}.{old} is deprecated: use {new}$"):
        assert getattr(found, old) is getattr(found, new)


def test_an_unknown_name():
    found = import_module("jtik.interop.pink")
    with pytest.raises(AttributeError, match="'jtik.interop.pink' has no attribute 'Other'"):
        _ = found.Other
