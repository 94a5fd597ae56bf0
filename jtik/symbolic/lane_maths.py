"""Arithmetic on several numbers at once, as C for compilers with vector types (GCC and clang).

A *lane* is one of the numbers of a vector register. Every operation is that of one number, lane by lane: a result does
not depend on the number of lanes or on what the others hold. Sine and cosine are by reduction to a quarter turn, in
three parts of pi / 2, and minimax polynomials; beyond 1e5, where the reduction loses digits, and for what is not finite
they are the C library's. The arc tangent is by reduction to an eighth turn and a polynomial; where both arguments are
zero, and for very small, very large or other numbers that the reduction cannot divide, it is the C library's.

One function computes the sines and cosines of many angles in a loop: the length of straight code, not the number of its
operations, decides how fast it runs.
"""

from __future__ import annotations

from typing import NamedTuple


class Level(NamedTuple):
    """Instructions of processors.

    Attributes:
        instructions: as compilers name them; empty for those that every processor of its kind has.
        lanes: numbers in a vector.
    """

    instructions: str
    lanes: int


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

_LANE_MATHS = r"""
#include <math.h>
#include <stdint.h>
#include <string.h>
#if defined(JTIK_INSTRUCTIONS) && defined(__x86_64__)
#include <immintrin.h>
#endif

#ifdef JTIK_INSTRUCTIONS
#define JTIK_CPU __attribute__((target(JTIK_INSTRUCTIONS)))
#else
#define JTIK_CPU
#endif
#define JTIK_INLINE static inline __attribute__((always_inline)) JTIK_CPU
#pragma GCC diagnostic ignored "-Wpsabi"

typedef double V __attribute__((vector_size(8 * JTIK_LANES), may_alias));  /* numbers */
typedef int64_t M __attribute__((vector_size(8 * JTIK_LANES), may_alias)); /* truth: all bits or none */

#define ALL(x) ((x) - (V){0})
JTIK_INLINE V of_bits(M m) { V r; memcpy(&r, &m, sizeof r); return r; }
JTIK_INLINE M bits(V v) { M r; memcpy(&r, &v, sizeof r); return r; }
JTIK_INLINE V choose(M m, V a, V b) { return of_bits((bits(a) & m) | (bits(b) & ~m)); }
JTIK_INLINE V where(M m, V a) { return of_bits(bits(a) & m); }
JTIK_INLINE V number(M m) { return where(m, ALL(1.0)); }
JTIK_INLINE int any(M m) { int64_t r = 0; for (int i = 0; i < JTIK_LANES; ++i) r |= m[i]; return r != 0; }
JTIK_INLINE V v_fabs(V x) { return of_bits(bits(x) & 0x7fffffffffffffffLL); }
#if defined(JTIK_INSTRUCTIONS) && defined(__x86_64__) && JTIK_LANES == 4 /* their own return y where one is NaN */
JTIK_INLINE V v_other(V r, V x, V y) { return (V)_mm256_blendv_pd((__m256d)r, (__m256d)x, (__m256d)of_bits(y != y)); }
JTIK_INLINE V v_fmin(V x, V y) { return v_other((V)_mm256_min_pd((__m256d)x, (__m256d)y), x, y); }
JTIK_INLINE V v_fmax(V x, V y) { return v_other((V)_mm256_max_pd((__m256d)x, (__m256d)y), x, y); }
#else
JTIK_INLINE V v_fmin(V x, V y) { return choose((x < y) | (y != y), x, y); }
JTIK_INLINE V v_fmax(V x, V y) { return choose((x > y) | (y != y), x, y); }
#endif
JTIK_INLINE V v_sign(V x) { return choose(x < 0, ALL(-1.0), choose(x > 0, ALL(1.0), x)); }
JTIK_INLINE V v_sqrt(V x) { V r; for (int i = 0; i < JTIK_LANES; ++i) r[i] = sqrt(x[i]); return r; }
#if defined(JTIK_INSTRUCTIONS) && defined(__x86_64__) && JTIK_LANES == 4
JTIK_INLINE V v_fma(V x, V y, V z) { return (V)_mm256_fmadd_pd((__m256d)x, (__m256d)y, (__m256d)z); }
#elif defined(JTIK_INSTRUCTIONS) && defined(__x86_64__) && JTIK_LANES == 8
JTIK_INLINE V v_fma(V x, V y, V z) { return (V)_mm512_fmadd_pd((__m512d)x, (__m512d)y, (__m512d)z); }
#else
JTIK_INLINE V v_fma(V x, V y, V z) { V r; for (int i = 0; i < JTIK_LANES; ++i) r[i] = fma(x[i], y[i], z[i]); return r; }
#endif
#define ONE(f, x) ({ V a_ = (x), r_; for (int i_ = 0; i_ < JTIK_LANES; ++i_) r_[i_] = f(a_[i_]); r_; })
#define TWO(f, x, y) \
  ({ V a_ = (x), b_ = (y), r_; for (int i_ = 0; i_ < JTIK_LANES; ++i_) r_[i_] = f(a_[i_], b_[i_]); r_; })

typedef struct { V sin, cos; } sin_cos;

JTIK_INLINE sin_cos sin_cos_of(V x) {
  const V shift = ALL(0x1.8p+52); /* rounds to an integer, which the lowest bits then hold */
  const V t = v_fma(x, ALL(0x1.45f306dc9c883p-1), shift);
  const M quarter = bits(t);
  const V k = t - shift;
  const V near = v_fma(k, ALL(-0x1.1a62633145c07p-54), v_fma(k, ALL(-0x1.921fb54442d18p+0), x));
  const V r = v_fma(k, ALL(0x1.f1976b7ed8fbcp-110), near), u = r * r;
  V a = v_fma(u, ALL(-0x1.ab1703bbf3a86p-41), ALL(0x1.61217dac1ab99p-33));
  a = v_fma(u, a, ALL(-0x1.ae6454110cefep-26));
  a = v_fma(u, a, ALL(0x1.71de3a545f9a2p-19));
  a = v_fma(u, a, ALL(-0x1.a01a01a01993p-13));
  a = v_fma(u, a, ALL(0x1.111111111111p-7));
  a = v_fma(u, a, ALL(-0x1.5555555555555p-3));
  const V s = v_fma(r * u, a, r);
  V b = v_fma(u, ALL(-0x1.907ce9abe9ed9p-37), ALL(0x1.1eeb67e9d96f4p-29));
  b = v_fma(u, b, ALL(-0x1.27e4fa16e7de1p-22));
  b = v_fma(u, b, ALL(0x1.a01a019f4df82p-16));
  b = v_fma(u, b, ALL(-0x1.6c16c16c16964p-10));
  b = v_fma(u, b, ALL(0x1.5555555555555p-5));
  const V half = u * 0.5, w = 1.0 - half;
  const V c = w + v_fma(u * u, b, (1.0 - w) - half);
  const M odd = -(quarter & 1);
  sin_cos found;
  found.sin = of_bits(bits(choose(odd, c, s)) ^ ((quarter & 2) << 62));
  found.cos = of_bits(bits(choose(odd, s, c)) ^ (((quarter + 1) & 2) << 62));
  return found;
}

static __attribute__((noinline, cold)) JTIK_CPU void far_sin_cos(int n, const V* x, V* s, V* c) {
  for (int i = 0; i < n; ++i) {
    const M near = v_fabs(x[i]) < 1e5;
    s[i] = choose(near, s[i], ONE(sin, x[i]));
    c[i] = choose(near, c[i], ONE(cos, x[i]));
  }
}

/* Sine and cosine of n angles. */
static __attribute__((noinline)) JTIK_CPU void v_sin_cos(int n, const V* x, V* s, V* c) {
  M near = ~(M){0};
  for (int i = 0; i < n; ++i) {
    const sin_cos found = sin_cos_of(x[i]);
    s[i] = found.sin;
    c[i] = found.cos;
    near &= v_fabs(x[i]) < 1e5;
  }
  if (any(~near)) far_sin_cos(n, x, s, c);
}

static __attribute__((noinline, cold)) JTIK_CPU void far_atan2(const V* y, V* x) { *x = TWO(atan2, *y, *x); }

JTIK_INLINE V v_atan2(V y, V x) {
  const V ax = v_fabs(x), ay = v_fabs(y);
  const M steep = ay > ax;
  const V n = choose(steep, ax, ay), d = choose(steep, ay, ax);
  const M usual = (d > 1e-300) & (d < 1e300), beyond = n > d * 0x1.a827999fcef32p-2; /* an eighth of a half turn */
  const V t = choose(beyond, n - d, n) / choose(beyond, n + d, d), u = t * t;
  V a = v_fma(u, ALL(-0x1.3a2b7a07caea9p-6), ALL(0x1.41603647c7a7cp-5));
  a = v_fma(u, a, ALL(-0x1.a098bb6ba4941p-5));
  a = v_fma(u, a, ALL(0x1.dfe61e80903d2p-5));
  a = v_fma(u, a, ALL(-0x1.10fa75382537fp-4));
  a = v_fma(u, a, ALL(0x1.3b1262d95579ep-4));
  a = v_fma(u, a, ALL(-0x1.745d0b26b83e7p-4));
  a = v_fma(u, a, ALL(0x1.c71c7185314cbp-4));
  a = v_fma(u, a, ALL(-0x1.24924924360cbp-3));
  a = v_fma(u, a, ALL(0x1.999999999934ap-3));
  a = v_fma(u, a, ALL(-0x1.5555555555555p-2));
  V r = v_fma(t * u, a, t);
  r = choose(beyond, 0x1.921fb54442d18p-1 + (r + 0x1.1a62633145c07p-55), r);
  r = choose(steep, 0x1.921fb54442d18p+0 - (r - 0x1.1a62633145c07p-54), r);
  r = choose(bits(x) < 0, 0x1.921fb54442d18p+1 - (r - 0x1.1a62633145c07p-53), r);
  r = of_bits(bits(r) | (bits(y) & INT64_MIN));
  if (__builtin_expect(any(~usual), 0)) {
    V far = x;
    far_atan2(&y, &far);
    r = choose(usual, r, far);
  }
  return r;
}
"""


def lane_maths(level: Level) -> str:
    """C of the arithmetic.

    Args:
        level: the instructions that it uses, and the number of lanes.
    """
    instructions = [f'#define JTIK_INSTRUCTIONS "{level.instructions}"'] if level.instructions else []
    return "\n".join([*instructions, f"#define JTIK_LANES {level.lanes}", _LANE_MATHS])
