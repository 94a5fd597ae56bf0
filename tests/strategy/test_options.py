"""Options of strategies are read by their annotations, in jtik's classes and in those of third parties."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Literal

import numpy as np
import pytest

import jtik
from jtik.arguments import number
from jtik.strategy import (
    AdaptiveDamping,
    AngleLimit,
    Backtracking,
    NonNegative,
    Positive,
    PositiveInteger,
    SecondaryTerm,
    Share,
    StepLimit,
    read_options,
)
from jtik_formulations.strategies.newton import Newton
from jtik_formulations.strategies.projected_gradient import ProjectedGradient
from jtik_formulations.strategies.qp_secondary import QPSecondary

Rule = Literal["one", "two"]


@dataclass(frozen=True, kw_only=True)
class Options:
    positive: Positive = 1.0
    least: NonNegative = 0.0
    share: Share = 1.0
    angle: AngleLimit = 1.0
    limit: StepLimit = math.inf
    from_two: Annotated[float, partial(number, minimum=2, accepted="a number from 2")] = 2.0
    real: float = 0.0
    count: int = 0
    rounds: PositiveInteger | None = None
    on: bool = True
    rule: Rule = "one"
    label: str = ""
    term: SecondaryTerm = field(default_factory=ProjectedGradient)
    other: object = None

    def __post_init__(self) -> None:
        read_options(self)


ACCEPTED = {
    "positive": [1e-300, 2, np.float64(3), np.float32(0.5), np.array(0.5)],
    "least": [0, 1e300],
    "share": [1e-300, 0.5, 1],
    "angle": [0.1, 2],
    "limit": [0.1, math.inf],
    "from_two": [2, 3.5],
    "real": [-1.5, 0],
    "count": [0, 3, np.int32(2)],
    "rounds": [None, 1, np.int64(4)],
    "on": [True, False, np.bool_(False)],
    "rule": ["one", "two"],
    "label": ["", "a"],
    "term": [ProjectedGradient(step_limit=0.1), QPSecondary()],
    "other": [object, None, "x"],
}
REFUSED = {
    "positive": [0, -1, math.inf, math.nan, True, "1", None, [1.0], 1j],
    "least": [-1e-300, math.inf, False],
    "share": [0, np.nextafter(1.0, 2.0), "all"],
    "angle": [0, math.inf],
    "limit": [0, -1, math.nan, -math.inf],
    "from_two": [1.9, math.inf],
    "real": [math.nan, math.inf, True, None],
    "count": [-1, 1.0, True, "1"],
    "rounds": [0, 1.5, True],
    "on": [1, 0, "no", None, [], np.array([True])],
    "rule": ["three", "One", None, 1, ["one"]],
    "label": [1, None, b"a"],
    "term": [5, None, ProjectedGradient, Newton()],
}


@pytest.mark.parametrize(("option", "value"), [(option, each) for option in ACCEPTED for each in ACCEPTED[option]])
def test_each_kind_accepts(option, value):
    read = getattr(Options(**{option: value}), option)
    assert read == value
    if option in ("positive", "least", "share", "angle", "limit", "from_two", "real"):
        assert type(read) is float
    if option in ("count", "on") or (option == "rounds" and value is not None):
        assert type(read) in (int, bool)


@pytest.mark.parametrize(("option", "value"), [(option, each) for option in REFUSED for each in REFUSED[option]])
def test_each_kind_refuses_and_names_the_option(option, value):
    with pytest.raises(jtik.ArgumentError) as caught:
        Options(**{option: value})
    assert caught.value.argument == option


def test_a_registered_name_stands_for_a_secondary_term():
    """As in ``strategy="newton+qp"``."""
    assert Newton(secondary="qp") == Newton(secondary=QPSecondary())
    assert jtik.strategies["lexicographic_qp"](secondary="qp").secondary == QPSecondary()
    with pytest.raises(jtik.UnknownNameError, match="secondary term 'gradiant'; did you mean 'gradient'"):
        Newton(secondary="gradiant")
    with pytest.raises(jtik.ArgumentError, match="secondary: given .*accepted: a QPSecondary"):
        jtik.strategies["lexicographic_qp"](secondary="gradient")


def test_a_strategy_of_a_third_party_is_read_likewise():
    """A dataclass that derives from a base of jtik needs nothing but its annotations."""

    @dataclass(frozen=True, kw_only=True)
    class Own(Newton):
        speed: float = 1.0
        careful: bool = False

    assert Own(speed=2).speed == 2.0
    for wrong in ({"speed": "fast"}, {"speed": True}, {"careful": "no"}, {"backtracking": 1}):
        with pytest.raises(jtik.ArgumentError) as caught:
            Own(**wrong)
        assert [caught.value.argument] == list(wrong)


def test_an_annotation_that_cannot_be_evaluated_leaves_the_option_as_it_is():
    @dataclass(frozen=True, kw_only=True)
    class Own(Newton):
        model: OnlyForTypeCheckers | None = None  # noqa: F821

    assert Own(model="anything").model == "anything"


def test_parts_of_strategies_are_read():
    for wrong in (lambda: Backtracking(active="x"), lambda: AdaptiveDamping(increase=0, decrease=0.5)):
        with pytest.raises(jtik.ArgumentError):
            wrong()
