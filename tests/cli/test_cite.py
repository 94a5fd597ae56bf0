"""``jtik cite`` prints BibTeX entries."""

from __future__ import annotations

import pytest

import jtik
from jtik.cli import main


def test_it_prints_each_entry_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cite", "hybrid"]) == 0
    assert capsys.readouterr().out.strip() == str(jtik.citations("hybrid"))
    assert main(["cite", "hybrid+qp", "newton", "joint_centering"]) == 0
    assert capsys.readouterr().out.strip() == str(jtik.citations("hybrid+qp"))


def test_an_unknown_name(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["cite", "hybird"]) == 2
    assert "hybird" in capsys.readouterr().err
