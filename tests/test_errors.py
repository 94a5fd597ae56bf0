"""Errors keep their data and say what would have been accepted."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import jtik
from jtik.errors import ImmutableError
from jtik.symbolic.compile import CompilerError

ERRORS = [
    jtik.ArgumentError("q0", "shape (3,)", "finite numbers of shape (2,)"),
    jtik.UnknownNameError("frame", "tpi", ["base", "tip"]),
    jtik.MissingExtraError("matplotlib", "plot", "a plot"),
    jtik.CriterionError("height", "returns a vector"),
    jtik.PluginError("mine", "third-party", "ImportError: x"),
    ImmutableError("Robot('arm')", "name"),
    CompilerError("cc", "no such file"),
]


@pytest.mark.parametrize("error", ERRORS, ids=lambda error: type(error).__name__)
def test_all_derive_from_one_and_survive_a_process_boundary(error):
    assert isinstance(error, jtik.JtikError)
    copied = pickle.loads(pickle.dumps(error))
    assert type(copied) is type(error)
    assert str(copied) == str(error)
    assert vars(copied) == vars(error)


def test_they_are_also_what_python_would_call_them():
    assert issubclass(jtik.ArgumentError, ValueError)
    assert issubclass(jtik.UnknownNameError, LookupError)
    assert issubclass(jtik.MissingExtraError, ImportError)
    assert issubclass(ImmutableError, AttributeError)


def test_an_unknown_name_suggests_the_closest():
    error = jtik.UnknownNameError("frame", "tpi", ["base", "tip"])
    assert error.closest == "tip"
    assert str(error) == "unknown frame 'tpi'; did you mean 'tip'? (known: base, tip)"
    assert jtik.UnknownNameError("frame", "xyz", []).closest is None


def test_a_long_array_is_one_line_that_begins_with_its_shape():
    message = str(jtik.ArgumentError("centers", np.zeros((29, 2)), "numbers of shape (30, 2)"))
    assert message.startswith("centers: given shape (29, 2), array([[0., 0.], [0., 0.],")
    assert "\n" not in message
    assert str(jtik.ArgumentError("x", np.zeros(2), "one number")) == "x: given array([0., 0.]); accepted: one number"
