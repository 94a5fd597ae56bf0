"""Summary tables and their text."""

from __future__ import annotations

import math

import numpy as np
import pytest

import jtik
from jtik.study import tables
from jtik.study.rows import COLUMNS, TEXTS
from jtik.study.summary import SUMMARY_COLUMNS, summary


@pytest.fixture
def columns():
    """Three cases of one contender, the last of which failed, and one of another."""
    table = {name: np.full(4, np.nan) for name in COLUMNS}
    table |= {name: np.array(["x"] * 4) for name in TEXTS}
    table["contender"] = np.array(["a", "a", "a", "b"])
    table["success"] = np.array([True, True, False, True])
    table["seconds"] = np.array([0.001, 0.003, 1.0, 0.5])
    table["position_error"] = np.array([0.1, 0.2, 0.6, np.nan])
    table["clearance"] = np.array([3.0, 2.0, 1.0, np.nan])
    return table


def test_success_and_errors_include_all_cases_and_times_solved_ones_only(columns):
    table = summary(columns, ("contender",))
    assert table["contender"] == ["a", "b"]
    assert table["cases"] == [3, 1]
    assert table["success [%]"] == pytest.approx([200 / 3, 100])
    assert table["time [ms]"] == pytest.approx([2.0, 500.0])
    assert table["position error [m]"] == pytest.approx([0.2, math.nan], nan_ok=True)
    assert table["clearance [m]"] == pytest.approx([2.0, math.nan], nan_ok=True)


def test_columns_without_values_are_left_out(columns):
    assert "H" not in summary(columns, ("contender",))
    assert "compromise [%]" not in summary(columns, ("contender",))
    assert {each.of for each in SUMMARY_COLUMNS} - {"compromise"} <= set(COLUMNS)


def test_a_compromise_is_no_success_and_has_a_column_of_its_own(columns):
    columns["status"] = np.array(["CONVERGED", "COMPROMISE", "COMPROMISE", "CONVERGED"])  # the second on target
    table = summary(columns, ("contender",))
    assert table["success [%]"] == pytest.approx([200 / 3, 100])
    assert table["compromise [%]"] == pytest.approx([100 / 3, 0])


@pytest.mark.parametrize("by", [(), ("colour",), ("contender", "seconds")])
def test_other_groups_are_refused(columns, by):
    with pytest.raises(jtik.ArgumentError, match="by"):
        summary(columns, by)


TABLE = {"name": ["one", "a|b"], "time [ms]": [1.23456, math.nan], "iterations left [1]": [12345.6, 2.0]}


class TestDisplay:
    def test_cells_have_three_digits(self):
        cells = [tables.cell(value) for value in (1.23456, 12345.6, 1.5e7, math.nan, 3, "x")]
        assert cells == ["1.23", "12346", "1.5e+07", "", "3", "x"]

    def test_text_aligns_numbers_right_and_breaks_long_titles(self):
        assert tables.text(TABLE).splitlines() == [
            "            iterations",
            "      time        left",
            "name  [ms]         [1]",
            "one   1.23       12346",
            "a|b                  2",
        ]

    def test_markdown_has_one_line_for_each_row(self):
        lines = tables.markdown(TABLE).splitlines()
        assert lines[1] == "| --- | ---: | ---: |"
        assert lines[2] == "| one | 1.23 | 12346 |"

    def test_html_escapes_text(self):
        assert '<td style="text-align:left">&lt;b&gt;</td>' in tables.markup({"name": ["<b>"]})
