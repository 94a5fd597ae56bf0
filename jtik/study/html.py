"""Report of a study as one self-contained HTML page with tables, figures and settings."""

from __future__ import annotations

import html
from base64 import b64encode
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import TYPE_CHECKING, Any

from jtik.errors import ArgumentError
from jtik.plotting import Figure
from jtik.study import tables

if TYPE_CHECKING:
    from jtik.study.comparison import Comparison

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; color: #2b2f36; background: #fdfdfb; max-width: 1180px; margin: 2em auto;
       padding: 0 1.5em; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; font-size: 13px; }
th { border-bottom: 2px solid #c3c7cc; vertical-align: bottom; } td { border-bottom: 1px solid #eceeef; }
th, td { padding: 0.3em 0.6em; } .wide { overflow-x: auto; } img { max-width: 100%; }
.muted { color: #6b7078; }
"""

SURFACE = 200
"""Number of polygons above which they are a picture of dots: a body in space has thousands."""

RESOLUTION = 200
"""Dots per inch of these."""


def page(comparison: Comparison) -> str:
    """The report as HTML.

    Raises:
        MissingExtraError: without matplotlib.
    """
    title = f"{len(comparison.contenders)} strategies on {comparison.robot.name}"
    kinds = ", ".join(f"{len(comparison.problems.of(kind))} {kind}" for kind in comparison.problems.kinds)
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        f"<p>{len(comparison.problems)} problems: {html.escape(kinds)}. Times are medians over interleaved rounds."
        " Success is decided by one independent check of all answers.</p>",
    ]
    if not comparison.complete:
        parts.append("<p><strong>The study was interrupted. The report shows the completed rows.</strong></p>")
    parts += [_table(comparison.summary()), _notes(comparison)]
    if len(comparison.problems.kinds) > 1:
        parts += ["<h2>By kind of problem</h2>", _table(comparison.summary(("kind", "contender")))]
    for heading, figure in _figures(comparison):
        parts.append(f"<h2>{heading}</h2>\n<p>{_picture(figure, heading)}</p>")
    parts += ["<h2>Settings</h2>", _pairs({**comparison.settings, **comparison.machine})]
    body = "\n".join(parts)
    return (
        f'<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{html.escape(title)}</title>\n'
        f"<style>{_STYLE}</style>\n</head>\n<body>\n{body}\n</body>\n</html>\n"
    )


def _table(table: dict[str, list[Any]]) -> str:
    return f'<div class="wide">{tables.markup(table)}</div>'


def _notes(comparison: Comparison) -> str:
    notes = [f"<li>{html.escape(note)} ({count})</li>" for note, count in comparison.notes.items()]
    return f'<ul class="muted">{"".join(notes)}</ul>' if notes else ""


def _pairs(values: dict[str, Any]) -> str:
    rows = "".join(
        f"<tr><td>{html.escape(str(name))}</td><td>{html.escape(str(value))}</td></tr>"
        for name, value in values.items()
    )
    return f"<table>{rows}</table>"


def _figures(comparison: Comparison) -> Iterator[tuple[str, Figure]]:
    """The figures for which this study has data."""
    wanted: list[tuple[str, Callable[[], Figure]]] = [
        ("Performance profile", comparison.plot_profile),
        ("Task error by iteration", comparison.plot_convergence),
        ("Lyapunov function of one case", comparison.plot_lyapunov),
        ("Criterion", comparison.plot_criteria),
        ("Postures of one case", comparison.plot_postures),
        ("Joint positions of one case", comparison.plot_joints),
    ]
    for heading, draw in wanted:
        try:
            figure = draw()
        except ArgumentError:  # the study has no data for this figure
            continue
        yield heading, figure


def _picture(figure: Figure, heading: str) -> str:
    file = BytesIO()
    for collection in (each for axes in figure.axes for each in axes.collections):
        collection.set_rasterized(len(collection.get_paths()) > SURFACE)
    figure.savefig(file, format="svg", dpi=RESOLUTION)
    data = b64encode(file.getvalue()).decode("ascii")
    return f'<img alt="{html.escape(heading)}" src="data:image/svg+xml;base64,{data}">'
