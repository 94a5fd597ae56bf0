"""BibTeX entries of the sources of what is used."""

from __future__ import annotations

import re

import pytest

import jtik
from jtik_formulations import Hybrid, JointCentering, SecondOrder

ENTRY = re.compile(r"^@\w+\{(\w+),$", re.MULTILINE)


def keys(text: str) -> list[str]:
    return ENTRY.findall(text)


REGISTERED = [
    (kind, name)
    for kind, registry in (
        ("strategies", jtik.strategies),
        ("criteria", jtik.criteria),
        ("secondaries", jtik.secondaries),
    )
    for name in registry
]


@pytest.mark.parametrize(("kind", "name"), REGISTERED)
def test_every_registered_class_has_entries_that_belong_to_its_source(kind: str, name: str) -> None:
    plugin = getattr(jtik, kind)[name]
    text = plugin.bibtex
    assert text.count("{") == text.count("}")
    assert len(keys(text)) == len(re.findall("^@", text, re.MULTILINE)) >= 1
    for entry in re.split(r"\n(?=@)", text):
        (year,) = re.findall(r"year = \{(\d{4})\}", entry)
        author = re.search(r"author = \{(?:\{)?([^,} ]+)", entry)
        assert author
        assert "title = {" in entry
        assert year in plugin.source
        assert author.group(1) in plugin.source
    assert len(re.findall(r"\b(?:19|20)\d\d\b", plugin.source)) == len(keys(text))


def test_exactly_what_a_solver_uses_each_once() -> None:
    arm = jtik.Robot.planar(4)
    alone = jtik.InverseKinematics(arm, jtik.FrameTask(), strategy="hybrid+second_order")
    assert keys(jtik.citations(alone)) == ["das1988", "powell1970"]  # without a criterion the second term does nothing
    both = jtik.InverseKinematics(arm, jtik.FrameTask(), strategy="hybrid+second_order", criteria=JointCentering())
    assert keys(jtik.citations(both)) == ["das1988", "powell1970", "nocedal2006", "gill1981"]


@pytest.mark.parametrize(
    ("of", "expected"),
    [
        ("hybrid", ["das1988", "powell1970"]),
        ("newton+qp", ["das1988", "kanoun2011"]),
        ("second_order", ["nocedal2006", "gill1981"]),
        ("joint_centering", ["das1988"]),
        (Hybrid(secondary=SecondOrder()), ["das1988", "powell1970", "nocedal2006", "gill1981"]),
        (2.0 * JointCentering(), ["das1988"]),
    ],
)
def test_names_and_objects(of: object, expected: list[str]) -> None:
    assert keys(jtik.citations(of)) == expected


def test_a_third_party_may_have_an_entry() -> None:
    class Own(jtik.Criterion):
        bibtex = "@misc{own2026,\n  title = {Own},\n}"

        def value(self, kinematics, parameters):
            return kinematics.q[0] ** 2

    class Sourced(Own):
        bibtex, source = "", "Someone 2026"

    text = jtik.citations(Own() + Sourced() + jtik.criterion(lambda q, robot: q[0]))
    assert str(text) == f"{Own.bibtex}\n\n% sourced: Someone 2026\n\n% <lambda>: no source"
    assert repr(text) == str(text)


def test_wrong_input() -> None:
    with pytest.raises(jtik.UnknownNameError, match="hybird"):
        jtik.citations("hybird")
    with pytest.raises(jtik.ArgumentError, match="accepted: a jtik.InverseKinematics"):
        jtik.citations(3)


def test_of_a_comparison(tmp_path) -> None:
    arm = jtik.Robot.planar(4)
    study = jtik.compare(
        arm,
        jtik.FrameTask(),
        count=2,
        strategies=["newton", "damped"],
        criteria={"none": None, "centering": JointCentering()},
        progress=False,
    )
    assert keys(study.citations()) == ["das1988", "barzilai1988", "chan1988"]
    study.save(tmp_path / "study.npz")
    assert jtik.Comparison.load(tmp_path / "study.npz").citations() == study.citations()
