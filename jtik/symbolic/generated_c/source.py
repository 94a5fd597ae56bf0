"""Functions as C, as CasADi generates it, with what its generator leaves to be done."""

from __future__ import annotations

import re

import casadi

from jtik.symbolic.block_products import with_block_loops
from jtik.symbolic.convexified import with_fast_factorisation
from jtik.symbolic.generated_c.daqp_setup import with_own_setup
from jtik.symbolic.generated_c.dense_products import with_fast_products
from jtik.symbolic.generated_c.fused_loops import with_fused_loops
from jtik.symbolic.generated_c.gathered_runs import with_runs
from jtik.symbolic.generated_c.scalar_functions import with_scalar_functions_rewritten
from jtik.symbolic.generated_c.sums_of_eight import with_sums_of_eight
from jtik.symbolic.operations import Function
from jtik.symbolic.row_by_row import with_row_loops
from jtik.symbolic.stacked_rows import with_stacked_rows


def c_source(function: Function, *others: Function) -> str:
    """A ``function`` and ``others`` as C, names prefixed with its own. Each thread has memory for the solvers in it.

    A function in it whose name begins with `SELDOM` is not optimised.
    """
    generator = casadi.CodeGenerator(function.name())
    for each in (function, *others):
        generator.add(each)
    source = with_fast_factorisation(with_own_setup(str(generator.dump())))
    source = _IS_SELDOM.sub(r"\1JTIK_SELDOM static", source)
    source = with_stacked_rows(with_runs(source))
    source = with_row_loops(with_block_loops(with_fast_products(with_scalar_functions_rewritten(source))))
    return _OF_ALL_THREADS.sub(
        r"static JTIK_THREAD_LOCAL \1", _DEFINITIONS + with_sums_of_eight(with_fused_loops(source))
    )


SELDOM = "jtik_seldom_"
"""How the name of a function begins that few calls need: a compiler takes longest to optimise the largest functions."""

_IS_SELDOM = re.compile(rf"^(/\* {SELDOM}\w+:.*\n)static", re.MULTILINE)


_OF_ALL_THREADS = re.compile(
    r"^static ((?:int|struct \w+) casadi_f\d+_(?:mem|mem_counter|unused_stack\w*)\b)", re.MULTILINE
)
"""Variables of generated C that all threads would share."""

_DEFINITIONS = """
#if defined(__clang__)
#define JTIK_SELDOM __attribute__((optnone, noinline))
#define JTIK_INDEPENDENT _Pragma("clang loop vectorize(assume_safety)")
#define JTIK_CARRIED _Pragma("clang loop unroll_count(8)")
#elif defined(__GNUC__)
#define JTIK_SELDOM __attribute__((optimize("O0"), noinline))
#define JTIK_INDEPENDENT _Pragma("GCC ivdep")
#define JTIK_CARRIED _Pragma("GCC unroll 8")
#else
#define JTIK_SELDOM
#define JTIK_INDEPENDENT
#define JTIK_CARRIED
#endif
#if defined(_MSC_VER)
#define JTIK_PART __declspec(noinline)
#define JTIK_INLINED __forceinline
#define JTIK_RESTRICT __restrict
#define JTIK_THREAD_LOCAL __declspec(thread)
#else
#define JTIK_PART __attribute__((noinline))
#define JTIK_INLINED __attribute__((always_inline)) inline
#define JTIK_RESTRICT __restrict__
#define JTIK_THREAD_LOCAL _Thread_local
#endif
"""
