"""Arithmetic on several numbers at once, as C for compilers with vector types (GCC and clang).

A *lane* is one of the numbers of a vector register. Every operation is that of one number, lane by lane: a result does
not depend on the number of lanes or on what the others hold. Numbers have double or single precision; of single ones a
register holds twice as many. Sine, cosine and arc tangent are in `jtik.symbolic.lanes.angles`.
"""

from __future__ import annotations

from typing import NamedTuple

from jtik.symbolic.lanes import angles as lane_angles


class Level(NamedTuple):
    """Instructions of processors.

    Attributes:
        instructions: as compilers name them; empty for those that every processor of its kind has.
        lanes: numbers of double precision in a vector.
    """

    instructions: str
    lanes: int

    def lanes_of(self, *, single: bool) -> int:
        """How many numbers a vector has.

        Args:
            single: whether they have single precision.
        """
        return 2 * self.lanes if single else self.lanes


LEVELS = (Level("", 4), Level("avx2,fma", 4), Level("avx512f,avx512dq,avx512vl", 8))
"""From those that every processor has to the fastest; all give the same numbers. With the first one a fused product and
sum may be a call of the C library."""

EXACT = ("-ffp-contract=off", "-fno-math-errno")
"""Options with which it is compiled: only where the code says so are a product and a sum rounded once, at every level;
a root sets no errno."""

PROBE = r"""
#if defined(__x86_64__)
#include <cpuid.h>
#endif

/* The highest level that this processor has, and whose registers the system keeps. */
int JTIK_NAME_level(void) {
#if defined(__x86_64__)
  unsigned a, b, c, d, low, high;
  const unsigned needed = 1u << 27 | 1u << 28 | 1u << 12; /* XGETBV, AVX, FMA */
  if (!__get_cpuid(1, &a, &b, &c, &d) || (c & needed) != needed) return 0;
  __asm__ volatile("xgetbv" : "=a"(low), "=d"(high) : "c"(0));
  if ((low & 6) != 6 || !__get_cpuid_count(7, 0, &a, &b, &c, &d) || !(b & (1u << 5))) return 0;
  return (low & 0xe6) == 0xe6 && (b & (1u << 16)) && (b & (1u << 17)) && (b & (1u << 31)) ? 2 : 1;
#else
  return 0;
#endif
}
"""

_INCLUDED = r"""
#include <math.h>
#include <stdint.h>
#include <string.h>
#if defined(JTIK_INSTRUCTIONS) && defined(__x86_64__)
#include <immintrin.h>
#endif
"""

_SINGLE = r"""
typedef float R;   /* a number */
typedef int32_t I; /* an integer that is as long */
#define JTIK_OF(function) function##f
#define JTIK_256(operation) _mm256_##operation##_ps
#define JTIK_512(operation) _mm512_##operation##_ps
#define JTIK_R256 __m256
#define JTIK_R512 __m512
"""

_DOUBLE = r"""
typedef double R;  /* a number */
typedef int64_t I; /* an integer that is as long */
#define JTIK_OF(function) function
#define JTIK_256(operation) _mm256_##operation##_pd
#define JTIK_512(operation) _mm512_##operation##_pd
#define JTIK_R256 __m256d
#define JTIK_R512 __m512d
"""

_LANE_MATHS = r"""
#ifdef JTIK_INSTRUCTIONS
#define JTIK_CPU __attribute__((target(JTIK_INSTRUCTIONS)))
#else
#define JTIK_CPU
#endif
#define JTIK_INLINE static inline __attribute__((always_inline)) JTIK_CPU
#pragma GCC diagnostic ignored "-Wpsabi"

typedef R V __attribute__((vector_size(JTIK_BYTES), may_alias)); /* numbers */
typedef I M __attribute__((vector_size(JTIK_BYTES), may_alias)); /* truth: all bits or none */

#define ALL(x) ((R)(x) - (V){0})
#define JTIK_HIGHEST ((I)1 << (8 * sizeof(I) - 2)) /* bit of a positive integer */
JTIK_INLINE V of_bits(M m) { V r; memcpy(&r, &m, sizeof r); return r; }
JTIK_INLINE M bits(V v) { M r; memcpy(&r, &v, sizeof r); return r; }
#if defined(JTIK_INSTRUCTIONS) && defined(__x86_64__) && JTIK_BYTES == 32
/* A mask that the compiler does not know as one: those it knows it packs into half a register, and unpacks again. */
#define MASK(comparison) ({ M m_ = (comparison); __asm__("" : "+x"(m_)); m_; })
JTIK_INLINE V choose(M m, V a, V b) {
  return (V)JTIK_256(blendv)((JTIK_R256)b, (JTIK_R256)a, (JTIK_R256)of_bits(m));
}
#else
#define MASK(comparison) (comparison)
JTIK_INLINE V choose(M m, V a, V b) { return of_bits((bits(a) & m) | (bits(b) & ~m)); }
#endif
JTIK_INLINE V where(M m, V a) { return of_bits(bits(a) & m); }
JTIK_INLINE V number(M m) { return where(m, ALL(1.0)); }
JTIK_INLINE int any(M m) { I r = 0; for (int i = 0; i < JTIK_LANES; ++i) r |= m[i]; return r != 0; }
JTIK_INLINE M sign_of(V x) { return bits(x) & (-JTIK_HIGHEST - JTIK_HIGHEST); }
JTIK_INLINE V v_fabs(V x) { return of_bits(bits(x) ^ sign_of(x)); }
#if defined(JTIK_INSTRUCTIONS) && defined(__x86_64__) && JTIK_BYTES == 32 /* their own return y where one is NaN */
JTIK_INLINE V v_other(V r, V x, V y) { return choose(y != y, x, r); }
JTIK_INLINE V v_fmin(V x, V y) { return v_other((V)JTIK_256(min)((JTIK_R256)x, (JTIK_R256)y), x, y); }
JTIK_INLINE V v_fmax(V x, V y) { return v_other((V)JTIK_256(max)((JTIK_R256)x, (JTIK_R256)y), x, y); }
#else
JTIK_INLINE V v_fmin(V x, V y) { return choose((x < y) | (y != y), x, y); }
JTIK_INLINE V v_fmax(V x, V y) { return choose((x > y) | (y != y), x, y); }
#endif
JTIK_INLINE V v_sign(V x) { return choose(x < 0, ALL(-1.0), choose(x > 0, ALL(1.0), x)); }
JTIK_INLINE V v_sqrt(V x) { V r; for (int i = 0; i < JTIK_LANES; ++i) r[i] = JTIK_OF(sqrt)(x[i]); return r; }
#if defined(JTIK_INSTRUCTIONS) && defined(__x86_64__) && JTIK_BYTES == 32
JTIK_INLINE V v_fma(V x, V y, V z) { return (V)JTIK_256(fmadd)((JTIK_R256)x, (JTIK_R256)y, (JTIK_R256)z); }
#elif defined(JTIK_INSTRUCTIONS) && defined(__x86_64__) && JTIK_BYTES == 64
JTIK_INLINE V v_fma(V x, V y, V z) { return (V)JTIK_512(fmadd)((JTIK_R512)x, (JTIK_R512)y, (JTIK_R512)z); }
#else
JTIK_INLINE V v_fma(V x, V y, V z) {
  V r;
  for (int i = 0; i < JTIK_LANES; ++i) r[i] = JTIK_OF(fma)(x[i], y[i], z[i]);
  return r;
}
#endif
#define ONE(f, x) ({ V a_ = (x), r_; for (int i_ = 0; i_ < JTIK_LANES; ++i_) r_[i_] = f(a_[i_]); r_; })
#define TWO(f, x, y) \
  ({ V a_ = (x), b_ = (y), r_; for (int i_ = 0; i_ < JTIK_LANES; ++i_) r_[i_] = f(a_[i_], b_[i_]); r_; })
"""


def lane_maths(level: Level, *, single: bool = False) -> str:
    """C of the arithmetic, for numbers R, vectors V of them and masks M.

    Args:
        level: the instructions that it uses, and the number of lanes.
        single: whether numbers have single precision, in twice as many lanes.
    """
    instructions = [f'#define JTIK_INSTRUCTIONS "{level.instructions}"'] if level.instructions else []
    sizes = [f"#define JTIK_BYTES {8 * level.lanes}", f"#define JTIK_LANES {level.lanes_of(single=single)}"]
    numbers, angles = (_SINGLE, lane_angles.SINGLE) if single else (_DOUBLE, lane_angles.DOUBLE)
    return "\n".join([*instructions, *sizes, _INCLUDED + numbers + _LANE_MATHS + lane_angles.COMMON + angles])
