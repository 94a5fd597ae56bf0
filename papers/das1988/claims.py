"""Writes the tables of README.md from claims.toml and the expected csv files.

``python papers/das1988/claims.py`` rewrites the tables between the markers of README.md. With ``--check`` it exits with
status 1 if that would change the file.
"""

from __future__ import annotations

import argparse
import math
import sys
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import beta_rule
import curvature
import figure_2_2
import five_families
import hybrid_switch
import lyapunov
import matrix_s
import near_singular
import obstacle_sign
import one_degree
import optimal_alpha
import out_of_singular
import twice_slower
from claim import HERE, Row, Script, by_key

README = HERE / "README.md"
SCRIPTS: dict[str, Script] = {
    module.SCRIPT.name: module.SCRIPT
    for module in (
        lyapunov,
        optimal_alpha,
        beta_rule,
        matrix_s,
        twice_slower,
        near_singular,
        one_degree,
        out_of_singular,
        hybrid_switch,
        curvature,
        obstacle_sign,
        figure_2_2,
        five_families,
    )
}


def expected() -> dict[str, dict[str, Row]]:
    """The expected numbers of every full run, by script, row and column."""
    return {name: by_key(script.read_expected(), script.keys) for name, script in SCRIPTS.items()}


def listed() -> dict[str, list[dict[str, Any]]]:
    """The contents of claims.toml."""
    return tomllib.loads((HERE / "claims.toml").read_text(encoding="utf-8"))


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)


def claims(numbers: Mapping[str, Mapping[str, Row]]) -> str:
    """The table of claims, with the expected numbers inserted."""
    rows = [
        [
            each["claim"],
            each["where"],
            each["condition"].format(**numbers),
            each["number"].format(**numbers),
            f"**{each['verdict']}**",
            f"[{each['script']}]({each['script']})",
        ]
        for each in listed()["claim"]
    ]
    return table(["claim", "where", "condition", "our number", "verdict", "script"], rows)


def remarks(numbers: Mapping[str, Mapping[str, Row]]) -> str:
    """The table of remarks, with the expected numbers inserted."""
    rows = [
        [each["what"], each["found"], each["number"].format(**numbers), f"[{each['script']}]({each['script']})"]
        for each in listed()["remark"]
    ]
    return table(["remark", "what was found", "our number", "script"], rows)


def beside(numbers: Mapping[str, Mapping[str, Row]]) -> str:
    """The table of the comparison with an earlier study."""
    rows = [
        [each["what"], each["study"], each["here"].format(**numbers), each["why"].format(**numbers)]
        for each in listed()["beside"]
    ]
    return table(["", "study", "here", "why"], rows)


def families(numbers: Mapping[str, Mapping[str, Row]]) -> str:
    """The table of five families: median iterations (targets reached [%]) [solves in which V rose [%]]."""
    at = numbers["five_families"]
    rows = []
    for method in five_families.METHODS:
        cells = []
        for family in five_families.FAMILIES:
            row = {column: float(value) for column, value in at[f"{family} | {method}"].items() if column in CELLS}
            count = f"{row['iterations']:g}" if math.isfinite(row["iterations"]) else "–"
            cells.append(f"{count} ({row['success']:g}) [{row['rises']:g}]")
        rows.append([method, *cells])
    return table(["", *five_families.FAMILIES], rows)


CELLS = ("iterations", "success", "rises")
TABLES = {"claims": claims, "remarks": remarks, "five families": families, "beside": beside}


def rendered(text: str) -> str:
    """The README with its tables updated."""
    numbers = expected()
    for name, write in TABLES.items():
        begin, end = f"<!-- {name} -->\n", f"<!-- end of {name} -->"
        before, rest = text.split(begin)
        _, after = rest.split(end)
        text = f"{before}{begin}\n{write(numbers)}\n\n{end}{after}"
    return text


def main(arguments: Sequence[str] | None = None, path: Path = README) -> int:
    """Write or check README.md. Returns the exit status."""
    parser = argparse.ArgumentParser(description="Write the tables of README.md from claims.toml and expected/.")
    parser.add_argument(
        "--check", action="store_true", help="write nothing; exit with status 1 if the file would change"
    )
    options = parser.parse_args(arguments)
    old = path.read_text(encoding="utf-8")
    new = rendered(old)
    if options.check:
        return int(new != old)
    path.write_text(new, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
