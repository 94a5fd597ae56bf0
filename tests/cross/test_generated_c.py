"""Generated C and the virtual machine: the same status of every solve, and the same step up to rounding.

Five thousand solves of every strategy, with a table of what was found:

    python -m tests.cross.test_generated_c [--solves 5000] [--seed 0] [--robot spatial] [--strategies hybrid sns+qp]
"""

from __future__ import annotations

import argparse
import itertools
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import jtik
from jtik.symbolic.compile import CompilerError, compiler
from jtik_formulations import JointCentering

from ..conftest import dh_arm, planar
from .hostile import strategies

ROUNDED = 1e-10
"""Largest difference of a step [rad]: both round the same operations, perhaps in another order."""

SOLVES = 100
"""Solves of the slow test, for each strategy."""

ITERATIONS = 200
"""Most iterations of a solve: enough for all but the slowest strategies."""

KINDS = ("near", "anywhere", "limits", "out of reach", "stretched", "restarts")
"""Kinds of problems: the target near the start, anywhere, at limits of joints, beyond reach, from a singular start, and
anywhere with restarts."""

LIMIT = 2.0
"""Limit of every joint [rad]."""

ROBOTS = {
    "spatial": dh_arm(7, limit=LIMIT),
    "six": dh_arm(6, seed=1, limit=LIMIT),
    "planar": planar(5, lower=-LIMIT, upper=LIMIT),
}
"""Arms: in space with a redundant joint and with none, and in the plane with three."""


@dataclass
class Found:
    """What a comparison found.

    Attributes:
        statuses: one sentence for each solve that ends with another status.
        steps: one sentence for each step that differs by more than rounding.
        largest: largest difference of a step [rad].
        counts: number of solves of each status.
        longer: solves that took another number of iterations.
    """

    statuses: list[str] = field(default_factory=list)
    steps: list[str] = field(default_factory=list)
    largest: float = 0.0
    counts: dict[str, int] = field(default_factory=dict)
    longer: int = 0


def solver(strategy: str, robot: str = "spatial", *, compiled: bool) -> jtik.InverseKinematics:
    """A solver of the problems."""
    given = {"criteria": JointCentering(), "strategy": strategy, "compiled": compiled}
    return jtik.InverseKinematics(ROBOTS[robot], jtik.FrameTask("tip"), **given)


def pair(strategy: str, robot: str = "spatial") -> tuple[jtik.InverseKinematics, jtik.InverseKinematics]:
    """A solver in generated C, and the same one on the virtual machine."""
    c, vm = (solver(strategy, robot, compiled=compiled) for compiled in (True, False))
    assert [in_c(each) for each in (c, vm)] == [True, False]
    return c, vm


def in_c(ik: jtik.InverseKinematics) -> bool:
    """Whether the steps of a solver run in generated C, also of one that calls Python between several functions."""
    fused = ik._engine.runners.solve.fused
    parts = fused.parts
    return fused.library is not None or (parts is not None and parts.local.class_name() == "External")


def problems(arm: jtik.Robot, seed: int) -> Iterator[tuple[str, np.ndarray, np.ndarray]]:
    """The kind of a problem, its start and its target; without end."""
    rng, most = np.random.default_rng(seed), LIMIT - 0.1
    for kind in itertools.cycle(KINDS):
        q0, goal = rng.uniform(-most, most, arm.n), rng.uniform(-most, most, arm.n)
        if kind == "near":
            goal = np.clip(q0 + rng.normal(0, 0.1, arm.n), -most, most)
        elif kind == "limits":
            goal[rng.random(arm.n) < 0.4] = LIMIT
        elif kind == "stretched":
            q0 = np.zeros(arm.n)
        target = arm.pose(goal) if arm.dimension == 3 else arm.position(goal)
        if kind == "out of reach":
            position = target[:3, 3] if arm.dimension == 3 else target
            position *= rng.uniform(1.5, 4.0)
        yield kind, q0, target


def compare(c: Any, vm: Any, count: int, seed: int = 0) -> Found:
    """Solve the same problems with both, and make the first step of each."""
    found = Found()
    for k, (kind, q0, target) in enumerate(itertools.islice(problems(vm.robot, seed), count)):
        options = {"q0": q0, "max_iterations": ITERATIONS, "restarts": 3 if kind == "restarts" else 0}
        one, two = (ik.solve(target, **options) for ik in (c, vm))
        found.counts[two.status.name] = found.counts.get(two.status.name, 0) + 1
        found.longer += one.iterations != two.iterations
        where = f"problem {k} of seed {seed}, {kind}"
        if one.status is not two.status:
            found.statuses.append(f"{where}: {one.status.name} in C, {two.status.name} on the virtual machine")
        for ik in (c, vm):
            ik.reset()
        one, two = (ik.step(q0, target) for ik in (c, vm))
        difference = float(np.abs(one.q - two.q).max())
        found.largest = max(found.largest, difference)
        if not difference <= ROUNDED or one[3:] != two[3:]:
            found.steps.append(f"{where}: the step differs by {difference:.1e}, {one[3:]} and {two[3:]}")
    return found


@pytest.mark.slow
@pytest.mark.parametrize("strategy", ["hybrid", "weighted_qp", "newton+qp"])
def test_solves_end_the_same_and_steps_are_the_same(strategy):
    try:
        compiler()
    except CompilerError:
        pytest.skip("needs a C compiler")
    found = compare(*pair(strategy), SOLVES)
    assert not found.statuses + found.steps
    assert len(found.counts) > 1


def test_another_step_and_another_status_are_found():
    vm, other = (solver(strategy, compiled=False) for strategy in ("newton", "damped"))

    def solve(target, **given):
        return vm.solve(target, **given | {"max_iterations": 1})

    hasty = SimpleNamespace(reset=other.reset, step=other.step, solve=solve)
    found = compare(hasty, vm, 6)
    assert len(found.steps) == 6
    assert found.largest > 1e-3
    assert "ITERATION_LIMIT in C, CONVERGED on the virtual machine" in found.statuses[0]


def main() -> None:
    """Compare as many solves as wanted, and print a table of what was found."""
    parser = argparse.ArgumentParser(description="Generated C beside the virtual machine.")
    parser.add_argument("--solves", type=int, default=5000, help="solves of each strategy (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed (%(default)s)")
    parser.add_argument("--robot", choices=ROBOTS, default="spatial", help="the arm (%(default)s)")
    parser.add_argument("--strategies", nargs="+", default=strategies(), help="only these")
    options = parser.parse_args()
    headings = f"{'status':>8}{'longer':>8}{'steps':>7}{'largest':>10}{'seconds':>9}"
    print(f"{'strategy':32}{'solves':>7}{headings}", flush=True)
    for strategy in options.strategies:
        begin = time.perf_counter()
        try:
            found = compare(*pair(strategy, options.robot), options.solves, options.seed)
        except jtik.JtikError as error:
            print(f"{strategy}: {error}", file=sys.stderr, flush=True)
            continue
        numbers = f"{len(found.statuses):8}{found.longer:8}{len(found.steps):7}{found.largest:10.1e}"
        seconds = time.perf_counter() - begin
        print(f"{strategy:32}{options.solves:7}{numbers}{seconds:9.0f}  {found.counts}", flush=True)
        for text in [*found.statuses, *found.steps][:20]:
            print(f"{strategy}: {text}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    main()
