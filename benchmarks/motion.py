"""Motion of every strategy in a control loop: what an arm would feel, and what is left of the task at the limits.

Accelerations come from second differences of q, errors and counts are exact: nothing here depends on the time that a
step takes. Every registered strategy runs through the public ``step`` and ``track``.

    python benchmarks/motion.py [--only paths limits] [--strategies hybrid weighted_qp] [--quick] [--json FILE]

The slow six-joint arm is compared with pink as well, if it is installed:

    python -m pip install pin-pink scipy
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

for variable in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")  # threads do not speed up matrices of seven rows

sys.path.insert(0, str(Path(__file__).parent))

from motion_limits import limits  # noqa: E402
from motion_paths import paths, self_motion  # noqa: E402
from motion_reach import out_and_back, out_of_reach, zero_pose  # noqa: E402
from motion_runs import Table, verdict  # noqa: E402
from packages import versions  # noqa: E402

import jtik  # noqa: E402

PAIRED = ("hybrid+qp", "newton+qp")
"""Strategies beside the registered ones."""
PACKAGES = ("numpy", "casadi", "daqp", "scipy", "mink", "pin-pink", "pin")

Scene = Callable[[Sequence[str], bool], list[Table]]
SCENES: dict[str, Scene] = {
    "paths": paths,
    "out_of_reach": out_of_reach,
    "out_and_back": out_and_back,
    "self_motion": self_motion,
    "limits": limits,
    "zero_pose": zero_pose,
}


def parsed() -> argparse.Namespace:
    """Parsed command line."""
    parser = argparse.ArgumentParser(description="Motion of every strategy in a control loop.")
    parser.add_argument("--only", nargs="+", choices=list(SCENES), default=list(SCENES), metavar="NAME", help="scenes")
    parser.add_argument(
        "--strategies",
        nargs="+",
        default=[*jtik.strategies, *PAIRED],
        metavar="NAME",
        help=f"strategies, by default every registered one, {' and '.join(PAIRED)}",
    )
    parser.add_argument("--quick", action="store_true", help="fewer cases, under a minute")
    parser.add_argument("--json", metavar="FILE", help="also write the figures to FILE, '-' for standard output")
    return parser.parse_args()


def main() -> None:
    """Measure, print, and optionally write the figures."""
    arguments = parsed()
    out = sys.stderr if arguments.json == "-" else sys.stdout
    tables: list[Table] = []
    for name in arguments.only:
        begin, spent = time.perf_counter(), time.process_time()
        found = SCENES[name](arguments.strategies, arguments.quick)
        for table in found:
            print(f"\n{table.text()}", file=out, flush=True)
        wall, cpu = time.perf_counter() - begin, time.process_time() - spent
        print(f"\n{name} took {wall:.0f} s, {cpu:.0f} s of the processor", file=sys.stderr)
        tables += found
    if any(table.bounds for table in tables):
        tables.append(verdict(tables, arguments.strategies))
        print(f"\n{tables[-1].text()}", file=out)
    if arguments.json:
        record = {
            "machine": f"{platform.machine()}, {platform.system()}, {os.cpu_count()} cores",
            "python": platform.python_version(),
            "versions": versions(PACKAGES),
            "quick": arguments.quick,
            "tables": [table.record() for table in tables],
        }
        text = json.dumps(record, indent=2)
        if arguments.json == "-":
            print(text)
        else:
            Path(arguments.json).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
