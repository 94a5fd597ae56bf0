"""``jtik list``: tables and JSON of what can be named."""

from __future__ import annotations

import json

import pytest

import jtik
from jtik.cli import catalogue, main
from jtik.registry import Registry
from jtik.robot import gallery
from jtik.study import peers
from jtik.study.selection import KINDS as KINDS_OF_PROBLEMS

from .conftest import Capture, refusal, without


def test_list_shows_everything_registered(capsys: Capture) -> None:
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    for name in (*jtik.strategies, *jtik.secondaries, *jtik.criteria, *gallery.names()):
        assert name in out
    titles = [line for line in out.splitlines() if line.startswith(("Strategies", "Secondary", "Criteria", "Robots"))]
    assert [title.split()[0] for title in titles] == ["Strategies", "Secondary", "Criteria", "Robots"]


def test_list_shows_brackets_as_they_are(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    class Boxed(jtik.Strategy):
        summary = "keeps dq in [m] within a box"

    registry: Registry[jtik.Strategy] = Registry("strategy", jtik.Strategy, "none.strategies")
    registry.add("boxed", Boxed)
    monkeypatch.setattr(catalogue, "strategies", registry)
    assert main(["list"]) == 0
    assert "[m]" in capsys.readouterr().out


def test_list_needs_no_rich(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    without(monkeypatch, "rich")
    assert main(["list"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for row in (*jtik.strategies.rows(), *jtik.secondaries.rows(), *jtik.criteria.rows()):
        (line,) = [line for line in lines if line.startswith(f"{row.name} ")]
        assert row.summary in line
        assert line.endswith(row.source)


KINDS = {
    "robots": gallery.names(),
    "criteria": tuple(jtik.criteria),
    "strategies": tuple(jtik.strategies),
    "secondaries": tuple(jtik.secondaries),
    "solvers": tuple(jtik.qp.available()),
    "problems": (*KINDS_OF_PROBLEMS, *(f"named:{name}" for name in jtik.problems.names())),
    "peers": tuple(f"peer:{name}" for name in peers.names()),
}


@pytest.mark.parametrize("kind", KINDS)
def test_json_has_every_name_of_a_kind(capsys: Capture, kind: str) -> None:
    assert main(["list", kind, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document) == (["strategies", "secondaries"] if kind == "strategies" else [kind])
    for name, rows in document.items():
        assert sorted(row["name"] for row in rows) == sorted(KINDS[name])
        assert all(row["summary"] and list(row) == ["name", "summary", "source"] for row in rows)


@pytest.mark.quick(3)
@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_is_a_table_that_fits_80_columns(capsys: Capture, monkeypatch: pytest.MonkeyPatch, kind: str) -> None:
    pytest.importorskip("rich")
    monkeypatch.setenv("COLUMNS", "80")
    assert main(["list", kind]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert max(map(len, lines)) <= 80
    first = [line.split()[0] for line in lines if line.strip()]
    assert set(KINDS[kind]) <= set(first)


def test_a_peer_that_is_not_installed_says_so(capsys: Capture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers.PlacoPeer, "package", "no-such-package")
    assert main(["list", "peers", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["peers"]}
    assert rows["peer:placo"]["source"] == "not installed: python -m pip install no-such-package"


def test_another_kind_is_refused_in_one_line(capsys: Capture) -> None:
    assert "'robots'" in refusal(capsys, "list", "robot")
