"""Values that are needed only where a condition holds: generated C evaluates them only there, with the same bits."""

from __future__ import annotations

import casadi
import numpy as np
import pytest

import jtik
from jtik.symbolic import function, if_else, looped, symbol
from jtik.symbolic.compile import CompiledFunction, CompilerError, compiler, to_c
from jtik.symbolic.generated_c import c_source
from jtik.symbolic.generated_c.branches import FEWEST
from jtik_formulations import JointCentering

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)

SIZE = 6


def chain(x, count):
    """A value of so many operations, each of which needs the one before."""
    value = x[0]
    for i in range(count // 3):
        value = value * x[i % SIZE] - casadi.sin(value)
    return value


def product(A, b):
    """What a call returns."""
    return (A @ b,)


def of_one_condition(x, y):
    return [if_else(x[1] > y[0], chain(x, 2 * FEWEST), casadi.inf)]


def of_both_sides(x, y):
    return [if_else(x[1] > y[0], chain(x, 2 * FEWEST), chain(x * y, 3 * FEWEST))]


def of_one_in_another(x, y):
    inner = if_else(x[2] > y[1], chain(x - y, 2 * FEWEST), x[3])
    return [if_else(x[1] > y[0], chain(x, 2 * FEWEST) * inner, y[5]), inner]


def of_nested(x, y):
    inner = if_else(x[2] > y[1], chain(x - y, 2 * FEWEST), 0)
    return [if_else(x[1] > y[0], chain(x, 2 * FEWEST) * inner, y[5])]


def of_the_condition(x, y):
    value = chain(x, 2 * FEWEST)
    return [if_else(value > y[0], value, 0), if_else(x[0] > 0, casadi.sqrt(value), 0)]


def of_a_call(x, y):
    found = looped(product, casadi.repmat(x, 1, SIZE), chain(x, 2 * FEWEST) * y)[0]
    again = looped(product, casadi.repmat(y, 1, SIZE), found)[0]
    return [if_else(x[1] > y[0], chain(found + again, 2 * FEWEST), 1), again]


BRANCHES = {
    of_one_condition: 1,
    of_both_sides: 2,
    of_one_in_another: 2,
    of_nested: 1,
    of_the_condition: 0,
    of_a_call: 1,
}
"""Functions, and how many branches each has."""


@pytest.mark.parametrize("build", BRANCHES)
def test_the_same_bits(build, rng, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    x, y = symbol("x", SIZE), symbol("y", SIZE)
    made = function("made", [x, y], build(x, y))
    assert c_source(made).count("  if (v") == BRANCHES[build]
    machine, in_c = CompiledFunction(made), CompiledFunction(to_c(made))
    for trial in range(40):
        given = [rng.uniform(-1.5, 1.5, SIZE), rng.uniform(-1, 1, SIZE)]
        if trial % 10 == 9:
            given[trial // 10 % 2][trial % SIZE] = (np.nan, np.inf)[trial // 20]
        for one, other in zip(machine(*given), in_c(*given), strict=True):
            np.testing.assert_array_equal(one, other)


def test_few_operations_have_no_branch():
    x, y = symbol("x", SIZE), symbol("y", SIZE)
    made = function("made", [x, y], [if_else(x[1] > y[0], chain(x, FEWEST // 2), 0)])
    assert "  if (v" not in c_source(made)


def test_the_test_of_stationarity_runs_only_on_the_target():
    arm = jtik.Robot.builtin("panda")
    ik = jtik.InverseKinematics(
        arm, jtik.FrameTask(), criteria=JointCentering(), strategy="weighted_qp", compiled=False
    )
    runner, _ = ik._engine.runners.timed_step
    stage = runner.fused.parts.stages[0]
    source = c_source(stage)
    lines = source[source.index("  if (v") :].split("\n")
    assert lines.index("  }") > 100
