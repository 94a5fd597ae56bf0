"""Progress: the items come through unchanged, and after each it is reported."""

from __future__ import annotations

import builtins
from typing import Any

import pytest

import jtik
from jtik.progress import counted, watched


def test_without_progress_the_items_come_as_they_are() -> None:
    assert list(watched(range(3), False, "numbers")) == [0, 1, 2]


def test_a_function_is_called_with_done_and_total_after_each_item() -> None:
    events: list[Any] = []
    for item in watched("ab", lambda done, total: events.append((done, total)), "letters"):
        events.append(item)
    assert events == ["a", (1, 2), "b", (2, 2)]


def test_a_bar_shows_its_label(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rich")
    assert list(watched(range(3), True, "numbers")) == [0, 1, 2]
    out, err = capsys.readouterr()
    assert "numbers" in err
    assert out == ""


def test_a_bar_of_a_total_that_grows(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("rich")
    with counted(True, "numbers") as report:
        assert report is not None
        for done, total in ((0, 1), (1, 3), (5, 5)):
            report(done, total)
    out, err = capsys.readouterr()
    assert "numbers" in err
    assert "5/5" in err
    assert out == ""


def test_nobody_is_informed_or_a_function() -> None:
    with counted(False, "numbers") as report:
        assert report is None
    with counted(print, "numbers") as report:
        assert report is print


def test_a_bar_without_rich_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without_rich(name: str, *arguments: Any, **options: Any) -> Any:
        if name.partition(".")[0] == "rich":
            raise ImportError(name)
        return real(name, *arguments, **options)

    monkeypatch.setattr(builtins, "__import__", without_rich)
    with pytest.raises(jtik.MissingExtraError, match=r"a progress bar needs rich; .*pip install 'jtik\[cli\]'"):
        watched(range(3), True, "numbers")
    with pytest.raises(jtik.MissingExtraError, match="a progress bar needs rich"), counted(True, "numbers"):
        pass
