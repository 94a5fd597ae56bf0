"""Hostile problems on random trees for every strategy, judged by kinematics of their own.

A hundred thousand of them, with a progress bar and a table of what was found:

    python -m tests.cross.test_hostile [--problems 100000] [--seed 0] [--strategies hybrid sns+qp]

In the slow tests each strategy has one of its secondary terms, in turn: ``--full`` runs all pairs.
"""

from __future__ import annotations

import argparse
import functools
import sys
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

import jtik
from jtik.progress import watched

from .hostile import LEAKAGE, Setup, answers, leaking, off_target, problem, setup, solved, stepped, strategies, too_near

PROBLEMS = 12
"""Problems of each slow test, on one random robot: building a solver takes longer than dozens of its solves."""

QUICK = ("hybrid", "sns_qp", "newton+second_order", "weighted_qp")
"""Strategies with a quick test."""

NAMES = strategies()


def sweep(strategy: str, number: int, count: int, seed: int = 0):
    """The setup ``number`` of a strategy, and its answers: (status, kind and sentence of all that is wrong)."""
    rng = np.random.default_rng([seed, NAMES.index(strategy), number])
    case = setup(strategy, rng)
    return case, ((status, wrong) for _, status, wrong in answers(case, rng, count))


def findings(strategy: str, number: int, count: int, seed: int = 0) -> list[str]:
    """What is wrong, one sentence each, with what reproduces it."""
    case, all_answers = sweep(strategy, number, count, seed)
    return [
        f"sweep({strategy!r}, {number}, {count}, {seed}), problem {k}, {case.name}: {kind}: {text}"
        for k, (_, wrong) in enumerate(all_answers)
        for kind, text in wrong
    ]


@pytest.mark.quick(1)
@pytest.mark.parametrize("strategy", QUICK)
def test_a_few_hostile_problems(strategy):
    found = findings(strategy, 0, 4)
    assert not found, "\n".join(found)


@pytest.mark.slow
@pytest.mark.thinned
@pytest.mark.parametrize(("primary", "secondary"), [name.partition("+")[::2] for name in NAMES])
def test_hostile_problems(primary, secondary):
    found = findings(f"{primary}+{secondary}".rstrip("+"), 1, PROBLEMS)
    assert not found, "\n".join(found)


def test_every_strategy_and_every_secondary_is_among_them():
    assert set(NAMES) >= set(jtik.strategies)
    assert {"hybrid+qp", "damped+second_order"} <= set(NAMES)


@functools.cache
def usual_case() -> Setup:
    """A setup with limits and a criterion."""
    cases = (setup("hybrid", np.random.default_rng(seed)) for seed in range(100))
    return next(case for case in cases if case.limited and case.ik._engine.problem.has_criterion)


class TestJudgement:
    """What is wrong is detected."""

    @pytest.fixture
    def case(self) -> Setup:
        return usual_case()

    @pytest.fixture
    def given(self, case):
        return problem(case, np.random.default_rng(0))

    def test_a_success_off_target(self, case, given):
        assert off_target(case, replace(given, tolerance=0.0), given.q0)
        targets = tuple(
            case.tree.poses(given.q0)[tip] if kind == "pose" else case.tree.poses(given.q0)[tip][: len(target), 3]
            for tip, kind, target in zip(case.tree.tips, case.kinds, given.targets, strict=False)
        )
        assert not off_target(case, replace(given, targets=targets), given.q0)

    def test_a_configuration_outside_the_limits(self, case):
        beyond = np.where(np.isfinite(case.tree.robot.upper), case.tree.robot.upper + 1e-6, case.tree.robot.neutral)
        assert case.tree.outside(beyond) > 1e-9 or not np.isfinite(case.tree.robot.upper).any()

    def test_a_link_that_passes_through_an_obstacle_between_two_configurations(self):
        case = setup("hybrid", np.random.default_rng(0))
        robot = jtik.Robot.planar(2)
        tree = replace(case.tree, robot=robot, joints=robot.joints, scale=1.0)
        arm = replace(case, tree=tree, clear=True, safe=0.05)
        given = replace(problem(case, np.random.default_rng(0)), centers=np.array([[0.0, 1.5], [50.0, 50.0]]))
        assert too_near(arm, given, np.array([[0.0, 0.0], [3.0, 0.0]]))
        assert not too_near(arm, given, np.array([[0.0, 0.0], [0.5, 0.0]]))

    def test_a_null_space_displacement_that_moves_the_end_effector(self, case, given):
        solved(case, given)
        del case.log[1:]
        (q, record), layout = case.log[0], case.ik._engine.runners.traced_solve.fused.record.slices
        assert not leaking(case)
        J = case.tree.jacobian(q, case.tree.tips[0])[0]
        record[layout["null_space"]] += 1e6 * LEAKAGE * J / np.linalg.norm(J)
        assert leaking(case)

    @pytest.mark.slow
    def test_a_step_that_is_too_fast(self, case, given):
        assert any(kind == "velocity" for kind, _ in stepped(replace(case, speed=(1e-9, None)), given))
        assert any(kind == "acceleration" for kind, _ in stepped(replace(case, speed=(9.0, 1e-9)), given))


def main() -> None:
    """Run as many problems as wanted, and print a table of what was found."""
    parser = argparse.ArgumentParser(description="Hostile problems on random trees, judged by their own kinematics.")
    parser.add_argument("--problems", type=int, default=100_000, help="problems over all strategies (%(default)s)")
    parser.add_argument("--each", type=int, default=50, help="problems of each random robot (%(default)s)")
    parser.add_argument("--seed", type=int, default=0, help="seed (%(default)s)")
    parser.add_argument("--strategies", nargs="+", default=NAMES, help="only these")
    options = parser.parse_args()
    rounds = -(-options.problems // (len(options.strategies) * options.each))
    statuses, kinds = Counter[tuple[str, str]](), Counter[tuple[str, str]]()
    work = [(strategy, number) for number in range(rounds) for strategy in options.strategies]
    for strategy, number in watched(work, True, "hostile problems"):
        try:
            case, all_answers = sweep(strategy, number, options.each, options.seed)
        except Exception as error:
            kinds[strategy, "build"] += 1
            print(f"setup of sweep({strategy!r}, {number}, {options.each}, {options.seed}): {error!r}", file=sys.stderr)
            continue
        for k, (status, wrong) in enumerate(all_answers):
            statuses[strategy, status] += 1
            kinds.update({(strategy, kind) for kind, _ in wrong})
            for kind, text in wrong:
                where = f"sweep({strategy!r}, {number}, {options.each}, {options.seed}), problem {k}"
                print(f"{where}, {case.name}: {kind}: {text}", file=sys.stderr)
    names, columns = sorted({name for name, _ in statuses}), [sorted({key for _, key in c}) for c in (statuses, kinds)]
    print(" " * 30 + "  ".join([*columns[0], "|", *columns[1]]))
    for name in names:
        counts = [str(statuses[name, key]).rjust(len(key)) for key in columns[0]]
        wrong = [str(kinds[name, key]).rjust(len(key)) for key in columns[1]]
        print(name.ljust(30) + "  ".join([*counts, "|", *wrong]))
    print(f"{sum(statuses.values())} problems, {sum(kinds.values())} of them with something wrong")


if __name__ == "__main__":
    main()
