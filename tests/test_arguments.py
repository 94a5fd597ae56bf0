"""The readers of arguments: what each kind accepts, in which form, and what its error says."""

from __future__ import annotations

import math
import sys
from fractions import Fraction
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import jtik
from jtik import arguments
from jtik.symbolic import symbol

NO_NUMBERS = [None, "1", "", b"1", True, np.True_, math.nan, 1j, [], [1.0], {}, {1.0}, object(), int, 10**400]
NO_NUMBERS += [np.array([1.0]), np.array("1"), np.array(True), symbol("x", 1)]
NO_NUMBERS += [np.ma.masked, np.ma.array(1.0, mask=True)]

READERS = {
    arguments.number: ([-1.5, 0, 2], [math.inf, -math.inf], "one finite number"),
    arguments.positive_number: ([1e-300, 2], [0, -1, math.inf], "a positive number"),
    arguments.non_negative_number: ([0, 2], [-1e-300, math.inf], "a non-negative number"),
    arguments.positive_or_infinite: ([1, math.inf], [0, -1], "a positive number, or math.inf for none"),
    arguments.share: ([1e-300, 1], [0, 1.1, math.inf], "a number in (0, 1]"),
    arguments.limit: ([-1, math.inf, -math.inf], [], "a number, infinity for none"),
}


@pytest.mark.parametrize("reader", READERS, ids=lambda reader: reader.__name__)
def test_numbers(reader):
    accepted, refused, words = READERS[reader]
    for value in accepted:
        forms = [value, float(value), np.float64(value), np.array(value, dtype=float)]
        forms += [Fraction(value)] if math.isfinite(value) else []
        for each in forms:
            read = reader("option", each)
            assert type(read) is float
            assert read == value
    for value in [*NO_NUMBERS, *refused]:
        with pytest.raises(jtik.ArgumentError) as caught:
            reader("option", value)
        assert (caught.value.argument, caught.value.accepted) == ("option", words)
        assert str(caught.value).endswith(f"accepted: {words}")


def test_integers():
    for value in (0, 3, np.int8(3), np.uint64(3), 2**63 - 1):
        read = arguments.integer("count", value)
        assert type(read) is int
        assert read == value
    for value in (-1, 1.0, True, np.True_, np.float64(1), "1", None, 2**63, 10**400, np.array([1])):
        with pytest.raises(jtik.ArgumentError, match="count: given .*accepted: a non-negative integer"):
            arguments.integer("count", value)
    with pytest.raises(jtik.ArgumentError, match="count: given 0; accepted: a positive integer"):
        arguments.positive_integer("count", 0)


def test_flags():
    for value in (True, False, np.True_, np.False_):
        assert arguments.flag("on", value) is bool(value)
    for value in (1, 0, None, "", "no", [], np.array([True]), np.array(True), object()):
        with pytest.raises(jtik.ArgumentError, match="on: given .*accepted: True or False: whether it is on"):
            arguments.flag("on", value, "whether it is on")


def test_words_and_names():
    assert arguments.text("label", "") == ""
    assert type(arguments.text("label", np.str_("a"))) is str
    assert arguments.name("name", "a") == "a"
    assert arguments.choice("rule", "two", ("one", "two", "three")) == "two"
    for reader, value in (
        (arguments.text, 5),
        (arguments.text, b"a"),
        (arguments.name, ""),
        (arguments.name, None),
        (lambda name, value: arguments.choice(name, value, ("one", "two")), "One"),
        (lambda name, value: arguments.choice(name, value, ("one", "two")), np.array(["one", "two"])),
    ):
        with pytest.raises(jtik.ArgumentError, match="option: given"):
            reader("option", value)
    with pytest.raises(jtik.ArgumentError, match="rule: given four; accepted: 'one', 'two' or 'three'"):
        arguments.choice("rule", "four", ("one", "two", "three"))


def test_names():
    for value in ("a", ["a"], ("a",), {"a"}, (each for each in "a"), np.array(["a"])):
        assert arguments.names("joints", value) == ("a",)
    for value in (5, None, [5], ["a", None], {"a": 1}, b"a", str, ["a", "b", "a"]):
        with pytest.raises(jtik.ArgumentError, match="joints: given .*accepted: a name, or several"):
            arguments.names("joints", value)
    with pytest.raises(jtik.ArgumentError, match="joints: given 'a' more than once; .*each name once"):
        arguments.names("joints", ["a", "b", "a"])


def test_several():
    for value in ([1, 2], (1, 2), iter([1, 2]), (each for each in (1, 2)), np.array([1, 2]), range(1, 3)):
        assert arguments.several("targets", value, "a list") == (1, 2)
    assert arguments.several("joints", {1}, "a list", ordered=False) == (1,)
    for value in (None, 5, "ab", b"ab", {"a": 1}, {1, 2}, list, jtik.JointType, np.array(1.0)):
        with pytest.raises(jtik.ArgumentError, match="targets: given .*accepted: a list"):
            arguments.several("targets", value, "a list")


def test_an_error_of_a_generator_is_its_own():
    def broken():
        yield 1
        raise TypeError("of the generator")

    with pytest.raises(TypeError, match="of the generator"):
        arguments.several("targets", broken(), "a list")


def test_objects():
    circle = jtik.Circle((0.0, 0.0), 1.0)
    for given in (circle, [circle], iter([circle])):
        assert arguments.instances("obstacles", given, jtik.Circle, "a jtik.Circle") == (circle,)
    for given in (None, 5, [circle, 5], jtik.Circle, {"a": circle}):
        with pytest.raises(jtik.ArgumentError, match=r"obstacles: given .*accepted: a jtik\.Circle"):
            arguments.instances("obstacles", given, jtik.Circle, "a jtik.Circle")
    assert arguments.mapping("shapes", {"a": 1}, "a dict") == {"a": 1}
    with pytest.raises(jtik.ArgumentError, match="shapes: given .*accepted: a dict"):
        arguments.mapping("shapes", [("a", 1)], "a dict")


def test_paths():
    assert arguments.path("save", "a/b") == arguments.path("save", Path("a/b")) == Path("a/b")
    for value in (None, 5, "", b"a", "a\0b", Path):
        with pytest.raises(jtik.ArgumentError, match="save: given .*accepted: the path of a file"):
            arguments.path("save", value)


def test_random_generators():
    generator = np.random.default_rng(3)
    assert arguments.random_generator("rng", generator) is generator
    assert arguments.random_generator("rng", 3).random() == np.random.default_rng(3).random()
    for value in (None, -1, 1.5, True, "x", np.random):
        with pytest.raises(jtik.ArgumentError, match="rng: given"):
            arguments.random_generator("rng", value)


@pytest.mark.parametrize(
    ("value", "given"),
    [
        ([True, 1.0], "non-numeric list"),
        ([1.0, np.True_], "non-numeric list"),
        (np.array([True, False]), "non-numeric ndarray"),
        (["1", "2"], "non-numeric list"),
        (np.array(["1", "2"]), "non-numeric ndarray"),
        (np.array([1.0, 2.0], dtype=object), "non-numeric ndarray"),
        (np.array([1 + 0j, 2]), "non-numeric ndarray"),
        (np.ma.array([1.0, 2.0], mask=[True, False]), "non-numeric MaskedArray"),
        ({1.0, 2.0}, "non-numeric set"),
        ((each for each in (1.0, 2.0)), "non-numeric generator"),
        ([10**400, 1], "non-numeric list"),
        ([[1.0], [1.0, 2.0]], "a ragged list"),
        ([1.0, -math.inf], "-inf at index 1"),
    ],
)
def test_arrays_that_are_refused(value, given):
    with pytest.raises(jtik.ArgumentError) as caught:
        arguments.finite_array("q", value, (2,))
    assert caught.value.given == given
    with pytest.raises(jtik.ArgumentError, match="q: given .*accepted: two numbers"):
        arguments.array_of("q", value, [(2,)], "two numbers")


def test_arrays_that_are_read():
    for value in ([1, 2.0], (1, 2), np.array([1, 2], dtype=np.uint8), np.ma.array([1.0, 2.0]), np.float32([1, 2])):
        read = arguments.finite_array("q", value, (2,))
        assert type(read) is np.ndarray
        assert read.dtype == np.float64
        assert read.tolist() == [1.0, 2.0]
    assert arguments.array_of("q", 2, [(), (2,)], "one or two").tolist() == 2.0
    with pytest.raises(jtik.ArgumentError, match="one or two"):
        arguments.array_of("q", [], [(), (None,)], "one or two")


def test_limits():
    assert arguments.limits("limits", -math.inf, 1) == (-math.inf, 1.0)
    for lower, upper in ((1, 0), (math.nan, 1), (0, math.nan), (math.inf, math.inf), (-math.inf, -math.inf)):
        with pytest.raises(jtik.ArgumentError, match="limits: given .*accepted: lower <= upper, no NaN"):
            arguments.limits("limits", lower, upper)


def test_a_value_that_cannot_be_shown_is_refused_all_the_same():
    class Broken:
        def __repr__(self):
            raise RuntimeError("no text")

    for value, shown in ((Broken(), "<Broken>"), (10**5000, "<int>"), ("a" * 3 + "b", "aaab"), (["x"] * 9999, "[")):
        with pytest.raises(jtik.ArgumentError) as caught:
            arguments.positive_number("dt", value)
        assert str(caught.value).startswith(f"dt: given {shown}")
        assert len(str(caught.value)) < 1200


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
        arguments.finite_array("q", value, shape)
    assert caught.value.argument == "q"
    assert caught.value.given == given
    assert "finite number" in caught.value.accepted


def test_an_array_is_copied():
    value = np.ones(3)
    arguments.finite_array("q", value, (3,))[0] = 5.0
    assert value.tolist() == [1, 1, 1]


def test_an_axis_of_any_length():
    assert arguments.finite_array("x", [[1, 2]] * 5, (None, 2)).shape == (5, 2)


def test_numbers_are_read_while_another_thread_imports_masked_arrays(monkeypatch):
    monkeypatch.setitem(sys.modules, "numpy.ma", ModuleType("numpy.ma"))
    robot = jtik.Robot.planar(2)
    assert robot.position(np.array([0.0, 0.0]))[0] == pytest.approx(2.0)
