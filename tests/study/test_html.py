"""The HTML report of a study."""

from __future__ import annotations

import base64
import re

import pytest

import jtik
from jtik.study import Comparison, html

pytest.importorskip("matplotlib")


@pytest.fixture
def study(figure_study):
    return figure_study


@pytest.fixture
def bare(bare_study):
    return bare_study


@pytest.mark.slow
def test_the_report_is_self_contained(study: Comparison, bare: Comparison, tmp_path) -> None:
    for each, figures in ((study, 6), (bare, 1)):
        each.to_html(tmp_path / "report.html")
        page = (tmp_path / "report.html").read_text(encoding="utf-8")
        assert all(name in page for name in each.contenders)
        sources = re.findall(r'(?:src|href)="([^"]*)"', page)
        assert len(sources) == figures
        assert all(source.startswith("data:image/svg+xml;base64,") for source in sources)
    assert "nobody" in page or "unknown strategy" not in page


@pytest.mark.slow
def test_bodies_in_space_do_not_make_it_large() -> None:
    """Their thousands of polygons are a picture of dots within the figure; lines and text stay lines and text."""
    robot = jtik.Robot.builtin("panda")
    q = [robot.keyframes["home"], robot.neutral, robot.random_configuration(0)]
    figure = robot.plot(q)
    assert sum(len(each.get_paths()) for axes in figure.axes for each in axes.collections) > 1000
    picture = html._picture(figure, "postures")
    assert len(picture) < 1e6
    drawing = base64.b64decode(picture.partition("base64,")[2].partition('"')[0])
    assert drawing.count(b"data:image/png") >= 1
    assert drawing.count(b"<path") < 500
