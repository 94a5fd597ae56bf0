"""The result of a study: regret, and notes, also of files from earlier versions."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from jtik.study.comparison import regret


def test_regret_is_relative_to_the_best_solved_row_of_the_same_case_and_criteria():
    columns = {
        "criteria": np.array(["a", "a", "a", "b", "a"]),
        "case": np.array(["1", "1", "1", "1", "2"]),
        "success": np.array([True, True, False, True, False]),
        "H": np.array([3.0, 2.0, 1.0, 7.0, 5.0]),
    }
    assert regret(columns).tolist() == pytest.approx([1.0, 0.0, np.nan, 0.0, np.nan], nan_ok=True)


@pytest.mark.quick(1)
@pytest.mark.parametrize(
    "note", ["reports success, but the error is 1 m and 0 rad", "says it is on target, but is 1 m off"]
)
def test_false_reports_of_success_are_counted_in_new_and_old_files(figure_study, note):
    notes = figure_study.columns["note"].astype(object)
    rows = figure_study.rows(contender="newton")
    notes[rows] = note
    study = replace(figure_study, columns={**figure_study.columns, "note": notes.astype(str)})
    assert study.notes["newton: reports success, but is off target by the independent check"] == len(rows)


def test_rows_select_by_column(figure_study):
    rows = figure_study.rows(contender="hybrid", kind="circle")
    assert figure_study.columns["case"][rows].tolist() == ["circle-000"]
    assert len(figure_study.rows()) == len(figure_study)
