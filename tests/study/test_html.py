"""The HTML report of a study."""

from __future__ import annotations

import re

import pytest

from jtik.study import Comparison

pytest.importorskip("matplotlib")


@pytest.fixture
def study(figure_study):
    return figure_study


@pytest.fixture
def bare(bare_study):
    return bare_study


def test_the_report_is_self_contained(study: Comparison, bare: Comparison, tmp_path) -> None:
    for each, figures in ((study, 6), (bare, 1)):
        each.to_html(tmp_path / "report.html")
        page = (tmp_path / "report.html").read_text(encoding="utf-8")
        assert all(name in page for name in each.contenders)
        sources = re.findall(r'(?:src|href)="([^"]*)"', page)
        assert len(sources) == figures
        assert all(source.startswith("data:image/svg+xml;base64,") for source in sources)
    assert "nobody" in page or "unknown strategy" not in page
