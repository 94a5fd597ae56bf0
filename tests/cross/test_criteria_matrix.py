"""A sample of benchmarks/criteria_matrix.py: every criterion with every strategy; and the page that it writes."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import pytest

from ..conftest import slow

SCRIPT = Path(__file__).parents[2] / "benchmarks" / "criteria_matrix.py"


@pytest.fixture(scope="module")
def matrix():
    if not SCRIPT.is_file():
        pytest.skip("the benchmarks are not part of this copy")
    spec = importlib.util.spec_from_file_location("criteria_matrix", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


SAMPLE = [
    ("ten", "joint_centering", "hybrid"),
    ("ten", "gravity_torque", "hybrid+qp"),
    ("ten", "frame_proximity", "hybrid"),
    ("ten", "effective_mass", "hybrid"),
    *slow(
        ("ten", "effective_mass", "hybrid+qp"),
        ("vehicle", "limit_norm", "hybrid"),
        ("vehicle", "limit_norm", "hybrid+qp"),
        ("panda", "gravity_torque", "hybrid+second_order"),
        ("panda", "manipulability", "hybrid"),
        ("vehicle", "support_polygon", "hybrid+second_order"),
        ("vehicle", "kinetic_energy", "hybrid"),
        ("ten", "look_at", "newton"),
    ),
]


@pytest.mark.quick(2, slow=5)
@pytest.mark.parametrize("cell", SAMPLE)
def test_a_solve_from_a_feasible_start_ends_as_it_should(matrix, cell):
    found = matrix.outcome(*cell, starts=1)
    assert found["outcome"] == "as it should", found
    assert found["error"] <= matrix.TOLERANCE
    before, after = found["H"]
    assert after <= before + 1e-6 * max(1.0, abs(before))


def test_too_few_iterations_are_no_success(matrix):
    found = matrix.outcome("ten", "joint_centering", "hybrid", starts=1, iterations=1)
    assert found["outcome"] in ("slow", "off the task")
    assert "iteration limit" in found["sentence"] or "could still fall" in found["sentence"]


def test_the_page_lists_every_pair_and_the_reasons(matrix):
    cells = {
        "ten joint_centering hybrid": {"outcome": "as it should"},
        "panda look_at newton": {
            "outcome": "slow",
            "sentence": "why",
            "H": [2, 1],
            "residual": 0.5,
            "error": 0.0,
            "iterations": 9,
        },
        "vehicle look_at mink": {"outcome": "refused", "sentence": "no such thing"},
    }
    text = matrix.page(cells)
    for name in (*matrix.criteria(), *matrix.strategies()):
        assert f"`{name}`" in text
    assert text.count("| ✓ |") == 1
    assert "- Panda, `look_at`, `newton`: why; 9 iterations, H 2 to 1, null-space residual 5.0e-01" in text
    assert "- Panda on a vehicle, `look_at`, `mink`: no such thing" in text
    assert "**Saddle**" not in text


def test_only_what_is_missing_is_computed(matrix, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(matrix, "PAGE", tmp_path / "page.md")
    monkeypatch.setattr(matrix, "outcome", lambda *cell, starts: {"outcome": "refused", "sentence": "not now"})
    given = ["--file", str(tmp_path / "cells.json"), "--robots", "ten", "--criteria", "look_at", "--strategies"]
    matrix.main([*given, "hybrid"])
    assert capsys.readouterr().out == "ten look_at hybrid: refused; not now\n"
    matrix.main([*given, "hybrid", "newton"])
    assert capsys.readouterr().out == "ten look_at newton: refused; not now\n"
    assert "`look_at`" in (tmp_path / "page.md").read_text(encoding="utf-8")
