"""Compiled functions: bound memory, and shared libraries of generated C."""

from __future__ import annotations

import platform

import casadi
import numpy as np
import pytest

import jtik
from jtik.symbolic import compile, function, symbol
from jtik.symbolic.compilation import c_compiler
from jtik.symbolic.compile import CompiledFunction, CompilerError, bind, library, to_c


def example():
    x, A = symbol("x", 2), symbol("A", 2, 3)
    return function("example", [x, A], [A.T @ x, casadi.sumsqr(x)])


def test_bind_reads_and_writes_the_given_memory():
    x, A, product, squared = np.array([1.0, 2.0]), np.arange(6.0), np.zeros(3), np.zeros(1)
    call = bind(example(), [x, A], [product, squared])
    call()
    assert product.tolist() == [2, 8, 14]  # the columns of A are (0, 1), (2, 3) and (4, 5)
    assert squared.tolist() == [5]
    x[:] = [0.0, 1.0]
    call()
    assert product.tolist() == [1, 3, 5]


def test_a_compiled_function_returns_new_arrays():
    call = CompiledFunction(example())
    A = np.array([[0.0, 2.0, 4.0], [1.0, 3.0, 5.0]])
    product, squared = call([1.0, 2.0], A)
    assert product[:, 0].tolist() == [2, 8, 14]
    call([0.0, 0.0], A)
    assert squared.tolist() == [[5]]


def test_generated_c_gives_the_same_numbers(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    compiled = to_c(example())
    arguments = ([0.3, -0.7], np.arange(6.0).reshape(2, 3))
    for ours, theirs in zip(compiled(*arguments), example()(*arguments), strict=True):
        assert ours.full() == pytest.approx(theirs.full(), rel=1e-15)
    made = library(example())
    assert [str(each) for each in (tmp_path / "jtik").iterdir()] == [made.path]  # compiled once


def test_a_compiler_that_fails_is_named_with_its_output(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(CompilerError, match="^no-such-compiler -O2 -fno-math-errno.*: .*No such file") as caught:
        to_c(example())
    assert caught.value.command.startswith("no-such-compiler")
    monkeypatch.setenv("CC", "false")
    with pytest.raises(CompilerError, match="^false -O2"):
        to_c(example())


@pytest.mark.skipif(platform.machine() not in ("x86_64", "AMD64"), reason="elsewhere products and sums may be one")
def test_a_product_and_a_sum_are_rounded_twice(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    A, B = casadi.MX.sym("A", 4, 4), casadi.MX.sym("B", 4, 4)
    product = casadi.Function("product", [A, B], [casadi.mtimes(A, B)])
    compiled, rng = to_c(product), np.random.default_rng(0)
    for _ in range(20):
        given = rng.normal(size=(2, 4, 4))
        assert compiled(*given).full().tolist() == product(*given).full().tolist()


FLAGS = "processor\t: {}\nflags\t\t: fpu sse2 avx {}\nbugs\t\t: avx2 is a word here\n\n"

PROCESSORS = {
    "all have it": (FLAGS.format(0, "avx2") + FLAGS.format(1, "avx2 bmi2"), c_compiler.AVX2),
    "one has not": (FLAGS.format(0, "avx2") + FLAGS.format(1, "bmi2"), ()),
    "its name is longer": (FLAGS.format(0, "avx2_vnni"), ()),
    "an ARM": ("processor\t: 0\nFeatures\t: fp asimd avx2\n", ()),
    "nothing is said": ("", ()),
}


@pytest.mark.parametrize("case", PROCESSORS)
def test_avx2_is_used_where_every_processor_has_it(case, tmp_path, monkeypatch):
    said, expected = PROCESSORS[case]
    (tmp_path / "cpuinfo").write_text(said)
    monkeypatch.setattr(c_compiler, "PROCESSORS", tmp_path / "cpuinfo")
    assert c_compiler.instructions() == expected


def test_a_system_that_does_not_name_its_processors(tmp_path, monkeypatch):
    monkeypatch.setattr(c_compiler, "PROCESSORS", tmp_path / "none")
    assert c_compiler.instructions() == ()


@pytest.mark.skipif(not c_compiler.instructions(), reason="a machine without AVX2")
def test_with_and_without_avx2_are_two_libraries_with_the_same_bits(tmp_path, monkeypatch):
    """A folder may be shared by machines, some of which do not have it."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    robot = jtik.Robot.planar([0.4, 0.3, 0.2, 0.1], lower=-2.0, upper=2.0)
    rng = np.random.default_rng(0)
    problems = [(robot.random_configuration(rng), robot.position(robot.random_configuration(rng))) for _ in range(30)]
    found, libraries = [], []
    for own in (c_compiler.instructions(), ()):
        monkeypatch.setattr(compile, "instructions", lambda own=own: own)
        ik = jtik.InverseKinematics(robot, jtik.FrameTask(kind="position"), strategy="hybrid+qp", compiled=True)
        found.append([(ik.step(q, target, dt=0.01).q, ik.solve(target, q0=q)) for q, target in problems])
        libraries.append(len([*(tmp_path / "jtik").glob("*.so")]))
    assert libraries[1] == 2 * libraries[0] > 0
    for (step, solution), (other_step, other) in zip(*found, strict=True):
        assert np.array_equal(step, other_step)
        assert np.array_equal(solution.q, other.q)
        assert (solution.status, solution.iterations) == (other.status, other.iterations)
