"""Errors keep their data and say what would have been accepted."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import jtik
from jtik.arguments import finite_array
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


@pytest.mark.parametrize(
    ("value", "shape", "given"),
    [
        ([1.0, 2.0], (3,), "shape (2,)"),
        (1.0, (3,), "shape ()"),
        ([1.0, np.nan, 3.0], (3,), "nan at index 1"),
        ([[1.0, np.inf]], (1, 2), "inf at index (0, 1)"),
        (["a", "b"], (2,), "non-numeric list"),
        ([[1.0], [1.0, 2.0]], (2, 1), "a ragged list"),
        (None, (2,), "non-numeric NoneType"),
        ([1 + 2j], (1,), "non-numeric list"),
    ],
)
def test_an_array_is_checked_and_the_fault_is_located(value, shape, given):
    with pytest.raises(jtik.ArgumentError) as caught:
        finite_array("q", value, shape)
    assert caught.value.argument == "q"
    assert caught.value.given == given
    assert "finite number" in caught.value.accepted


def test_an_array_is_copied():
    value = np.ones(3)
    finite_array("q", value, (3,))[0] = 5.0
    assert value.tolist() == [1, 1, 1]


def test_an_axis_of_any_length():
    assert finite_array("x", [[1, 2]] * 5, (None, 2)).shape == (5, 2)
