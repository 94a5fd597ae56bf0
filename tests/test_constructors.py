"""A call that does not fit a constructor is told what the constructor accepts; one that fits is left alone."""

from __future__ import annotations

import abc
import dataclasses
import inspect
import pickle
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import pytest

import jtik
from jtik.constructors import Constructed, lists_arguments
from jtik.errors import CallError
from jtik_formulations import Hybrid, JointCentering, ObstacleAvoidance

ARM = jtik.Robot.planar(2)


def test_the_other_ways_to_make_it_are_named():
    with pytest.raises(CallError) as caught:
        jtik.Box(center=(0, 0, 0), size=(1, 1, 1))
    assert caught.value.argument == "center, size"
    assert str(caught.value) == (
        "center, size: given to Box, which has no argument of this name; accepted: Box(pose, half) or "
        "Box.at(center, half, rotation=...)"
    )


def test_a_similar_name_is_suggested():
    with pytest.raises(CallError, match=r"accepted: Circle\(center, radius=...\); did you mean center\?"):
        jtik.Circle(centre=(0.0, 0.0), radius=1.0)
    with pytest.raises(CallError, match="did you mean criteria"):
        jtik.InverseKinematics(ARM, jtik.FrameTask(), criterion=JointCentering())


def test_a_missing_argument_and_one_too_many():
    with pytest.raises(CallError, match=r"^Box: given no 'pose'; accepted: Box\(pose, half\) or Box.at\(center, "):
        jtik.Box(half=(1, 1, 1))
    with pytest.raises(CallError, match="Circle: given too many positional arguments"):
        jtik.Circle((0, 0), 1.0, 2.0)


@pytest.mark.parametrize(
    "call",
    [
        lambda **wrong: jtik.Robot.planar(2, **wrong),
        lambda **wrong: jtik.Robot.from_urdf("arm.urdf", **wrong),
        lambda **wrong: jtik.Robot.builtin("ur5e", **wrong),
        lambda **wrong: jtik.Box.at((0, 0), (1, 1), **wrong),
        lambda **wrong: jtik.compare(ARM, jtik.FrameTask(), **wrong),
        lambda **wrong: jtik.view(ARM, **wrong),
    ],
)
def test_functions_that_build_something_do_the_same(call):
    with pytest.raises(CallError, match="lnegth: given to .*, which has no argument of this name; accepted: "):
        call(lnegth=1)


def test_it_is_what_python_would_call_it_and_survives_a_process_boundary():
    with pytest.raises(TypeError) as caught:
        Hybrid(dampin=1.0)
    assert isinstance(caught.value, jtik.ArgumentError)
    copied = pickle.loads(pickle.dumps(caught.value))
    assert (type(copied), str(copied)) == (CallError, str(caught.value))


def test_classes_of_users_do_the_same():
    class Height(jtik.Criterion):
        def __init__(self, height: float = 1.0) -> None:
            self.height = height

        def value(self, kinematics, parameters):
            return (kinematics.position("tip")[1] - self.height) ** 2

    @dataclass(frozen=True, kw_only=True)
    class Mine(Hybrid):
        share: float = 0.5

    assert Height(2.0).height == 2.0
    with pytest.raises(CallError, match=r"accepted: Height\(height=...\); did you mean height"):
        Height(hight=2.0)
    assert dataclasses.replace(Mine(), share=0.25).share == 0.25
    with pytest.raises(CallError, match="shares: given to Mine"):
        dataclasses.replace(Mine(), shares=0.25)


def test_a_type_error_from_within_stays_as_it_is():
    class Broken(metaclass=Constructed):
        def __init__(self, text: str) -> None:
            len(3)

    with pytest.raises(TypeError, match="has no len") as caught:
        Broken("x")
    assert not isinstance(caught.value, CallError)

    @lists_arguments
    def broken(text: str) -> int:
        return len(3)

    with pytest.raises(TypeError, match="has no len") as caught:
        broken("x")
    assert not isinstance(caught.value, CallError)
    with pytest.raises(TypeError, match="abstract"):
        jtik.Criterion()


def test_signatures_and_copies_are_those_of_the_constructor():
    assert list(inspect.signature(jtik.Circle).parameters) == ["center", "radius"]
    assert next(iter(inspect.signature(ObstacleAvoidance).parameters)) == "obstacles"
    assert next(iter(inspect.signature(jtik.Robot.planar).parameters)) == "links"
    box = pickle.loads(pickle.dumps(jtik.Box.at((0, 0), (1, 2), 0.3)))
    assert np.array_equal(box.half, (1, 2))


class Drawable(Protocol):
    """What a user's own code asks of a class."""

    def draw(self) -> str: ...


@pytest.mark.parametrize("kind", [jtik.Circle, jtik.Limits, jtik.Robot, jtik.InverseKinematics, jtik.FrameTask])
@pytest.mark.parametrize("other", [abc.ABC, Drawable])
def test_other_bases_are_possible(kind, other):
    made = type(kind)("Mine", (kind, other), {"draw": lambda self: "drawn"})
    assert issubclass(made, kind)
    assert other in made.__mro__
    circle = jtik.Circle((0, 0), 1)
    assert not isinstance(circle, made)
    assert isinstance(circle, kind) is (kind is jtik.Circle)
    if kind is jtik.Limits:
        assert isinstance(made(velocity=1.0), kind)
        with pytest.raises(CallError, match=r"speed: given to Mine.*accepted: Mine\(.*velocity=..."):
            made(speed=1.0)


def test_constructors_of_any_form_are_listed():
    class New(metaclass=Constructed):
        def __new__(cls, size: float) -> New:
            return super().__new__(cls)

    class Wrapped(metaclass=Constructed):
        parse = classmethod(int)

        def __init__(self, size: float) -> None: ...

    for each in (New, Wrapped):
        assert list(inspect.signature(each).parameters) == ["size"]
        with pytest.raises(CallError, match=r"accepted: \w+\(size\)"):
            each(length=1.0)
