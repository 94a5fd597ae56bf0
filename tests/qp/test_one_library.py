"""A step with quadratic programs as one library of generated C, with DAQP linked into it."""

from __future__ import annotations

import copy
import threading

import numpy as np
import pytest

import jtik
from jtik.qp import Conic
from jtik.symbolic.compile import CompilerError, compiler
from jtik_formulations import JointCentering

from ..conftest import EXACT, dh_arm, shared_solver, slow

try:
    compiler()
except CompilerError:
    pytest.skip("needs a C compiler", allow_module_level=True)
if Conic().archive is None:
    pytest.skip("needs the static library of DAQP that CasADi comes with", allow_module_level=True)

LIMITS = jtik.Limits(velocity=1.0)


def solver(*, strategy="weighted_qp", compiled=True, backend=None, limit=2.0):
    build = shared_solver if backend is None else jtik.InverseKinematics
    return build(
        dh_arm(limit=limit),
        jtik.FrameTask("tip", kind="pose"),
        criteria=0.01 * JointCentering(),
        strategy=strategy,
        limits=LIMITS,
        solver=backend,
        compiled=compiled,
    )


def targets(count, seed=0, limit=2.0):
    arm, rng = dh_arm(limit=limit), np.random.default_rng(seed)
    return [arm.pose(rng.uniform(-limit, limit, arm.n), "tip") for _ in range(count)]


def same(one, other):
    """Whether two solutions are the same but for rounding."""
    return (
        one.status is other.status
        and one.iterations == other.iterations
        and np.abs(one.q - other.q).max() < 1e-9
        and one.restarts == other.restarts
    )


STRATEGIES = ["weighted_qp", *slow("lexicographic_qp", "sns_qp")]


@pytest.mark.quick(0, slow=1)
@pytest.mark.parametrize("strategy", STRATEGIES)
def test_steps_and_solves_are_those_of_the_virtual_machine(strategy):
    fast, other = solver(strategy=strategy), solver(strategy=strategy, compiled=False)
    assert fast._engine.search.native is not None
    q, rng = fast.robot.neutral, np.random.default_rng(4)
    for T in targets(20):
        start = q + rng.uniform(-1, 1, q.size)
        for dt in (None, 0.02):
            assert np.abs(fast.step(start, T, dt=dt).q - other.step(start, T, dt=dt).q).max() < EXACT
        for options in ({"max_iterations": 60}, {"max_iterations": 60, "restarts": 3, "seed": 2}):
            assert same(fast.solve(T, q0=start, **options), other.solve(T, q0=start, **options))


def weak(*, fallback):
    """A back end that gives up after one iteration, on the virtual machine and in C."""
    backend = Conic("daqp", daqp={"iter_limit": 1, "primal_tol": 1e-8})
    assert backend.fallback is None
    if fallback:
        backend.fallback = Conic("daqp").fallback
    return backend


@pytest.mark.quick(1)
@pytest.mark.parametrize("fallback", [False, True])
def test_a_program_that_the_solver_gives_up_is_left_to_python(fallback):
    fast = solver(backend=weak(fallback=fallback))
    other = solver(backend=weak(fallback=fallback), compiled=False)
    good, found = solver(compiled=False), []
    for T in targets(12, seed=1):
        one = fast.solve(T, q0=fast.robot.neutral, max_iterations=60)
        assert same(one, other.solve(T, q0=fast.robot.neutral, max_iterations=60))
        expected = good.solve(T, q0=fast.robot.neutral, max_iterations=60)
        found.append((one, expected))
    if fallback:
        assert all(one.converged == expected.converged for one, expected in found)
    else:  # there is something to give up
        assert any(one.status is jtik.Status.UNSOLVED and expected.converged for one, expected in found)


@pytest.mark.slow
def test_a_batch_leaves_such_programs_to_python_too():
    fast, good = solver(backend=weak(fallback=True)), solver(compiled=False)
    goals = targets(12, seed=1)
    ours, theirs = (ik.solve_batch(goals, q0=ik.robot.neutral, max_iterations=60) for ik in (fast, good))
    assert ours.converged.tolist() == theirs.converged.tolist()
    assert np.abs(ours.q - theirs.q).max() < 1e-6


@pytest.mark.slow
def test_threads_do_not_share_the_solver_s_memory():
    ik, goals = solver(), targets(150, seed=2)
    expected = ik.solve_batch(goals, q0=ik.robot.neutral, restarts=2, max_iterations=60)
    copies = [copy.copy(ik) for _ in range(4)]
    found: list[object] = [None] * len(copies)

    def solve(i):
        found[i] = copies[i].solve_batch(goals, q0=ik.robot.neutral, restarts=2, max_iterations=60)

    threads = [threading.Thread(target=solve, args=(i,)) for i in range(len(copies))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for batch in found:
        assert batch.q.tolist() == expected.q.tolist()
        assert batch.status == expected.status


@pytest.mark.slow
def test_a_solver_without_a_static_library_is_called_between_functions_in_c():
    without = Conic("daqp")
    without.archive = None
    ours, linked = solver(backend=without), solver()
    assert ours._engine.search.native is None
    for T in targets(5, seed=3):
        assert same(ours.solve(T, q0=ours.robot.neutral), linked.solve(T, q0=ours.robot.neutral))


def test_the_library_depends_on_the_static_one(tmp_path):
    from jtik.symbolic import function, symbol
    from jtik.symbolic.compile import library

    x = symbol("x", 1)
    plain, archive = function("plain", [x], [2 * x]), Conic().archive
    other = replace_file(archive, tmp_path)
    assert len({library(plain).name, library(plain, archive=archive).name, library(plain, archive=other).name}) == 3


def replace_file(archive, folder):
    """The same archive with an empty member more."""
    file, member = folder / archive.file.name, f"{'more/':16}{0:<12}{0:<6}{0:<6}{644:<8}{0:<10}`\n"
    file.write_bytes(archive.file.read_bytes() + member.encode())
    return archive._replace(file=file)
