"""Sine, cosine and arc tangent of several numbers at once, as C for `jtik.symbolic.lanes.maths`.

Sine and cosine are by reduction to a quarter turn, in parts of pi / 2, and minimax polynomials; the arc tangent is by
reduction to an eighth turn and a polynomial. With double precision the results are right to three units of the last
place. Beyond 1e5, where the reduction to a quarter turn loses digits, and for what is not finite sine and cosine are
the C library's; so is the arc tangent where both arguments are zero, and for very small, very large or other numbers
that the reduction cannot divide.

With single precision errors are below 3e-7, of sine and cosine up to 1e3; at larger angles they grow with the angle.

One function computes the sines and cosines of many angles in a loop: the length of straight code, not the number of its
operations, decides how fast it runs.
"""

from __future__ import annotations

COMMON = r"""
typedef struct { V sin, cos; } sin_cos;

static __attribute__((noinline, cold)) JTIK_CPU void far_atan2(const V* y, V* x) { *x = TWO(atan2, *y, *x); }
"""
"""What both forms need."""

DOUBLE = r"""
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
  r = of_bits(bits(r) | sign_of(y));
  if (__builtin_expect(any(~usual), 0)) {
    V far = x;
    far_atan2(&y, &far);
    r = choose(usual, r, far);
  }
  return r;
}
"""

SINGLE = r"""
JTIK_INLINE sin_cos sin_cos_of(V x) {
  const V shift = ALL(0x1.8p+23); /* rounds to an integer, which the lowest bits then hold */
  const V t = v_fma(x, ALL(0x1.45f306p-1), shift);
  const M quarter = bits(t);
  const V k = t - shift;
  const V r = v_fma(k, ALL(0x1.777a5cp-25), v_fma(k, ALL(-0x1.921fb6p+0), x)), u = r * r;
  V a = v_fma(u, ALL(-0x1.994388p-13), ALL(0x1.11073ap-7));
  a = v_fma(u, a, ALL(-0x1.555546p-3));
  V b = v_fma(u, ALL(0x1.9a020ap-16), ALL(-0x1.6c0c8ap-10));
  b = v_fma(u, b, ALL(0x1.55554ap-5));
  const V s = v_fma(r * u, a, r), c = v_fma(u * u, b, v_fma(u, ALL(-0.5), ALL(1.0)));
  const M odd = -(quarter & 1);
  sin_cos found;
  found.sin = of_bits(bits(choose(odd, c, s)) ^ ((quarter & 2) << 30));
  found.cos = of_bits(bits(choose(odd, s, c)) ^ (((quarter + 1) & 2) << 30));
  return found;
}

/* Sine and cosine of n angles. */
static __attribute__((noinline)) JTIK_CPU void v_sin_cos(int n, const V* x, V* s, V* c) {
  for (int i = 0; i < n; ++i) {
    const sin_cos found = sin_cos_of(x[i]);
    s[i] = found.sin;
    c[i] = found.cos;
  }
}

JTIK_INLINE V v_atan2(V y, V x) {
  const V ax = v_fabs(x), ay = v_fabs(y);
  const M steep = ay > ax;
  const V n = choose(steep, ax, ay), d = choose(steep, ay, ax);
  const M usual = (d > ALL(1e-30)) & (d < ALL(1e30)), beyond = n > d * ALL(0x1.a8279ap-2);
  const V t = choose(beyond, n - d, n) / choose(beyond, n + d, d), u = t * t;
  V a = v_fma(u, ALL(-0x1.f251a2p-5), ALL(0x1.b20152p-4));
  a = v_fma(u, a, ALL(-0x1.23b6acp-3));
  a = v_fma(u, a, ALL(0x1.9991acp-3));
  a = v_fma(u, a, ALL(-0x1.55554ap-2));
  V r = v_fma(t * u, a, t);
  r = choose(beyond, ALL(0x1.921fb6p-1) + r, r);
  r = choose(steep, ALL(0x1.921fb6p+0) - r, r);
  r = choose(bits(x) < 0, ALL(0x1.921fb6p+1) - r, r);
  r = of_bits(bits(r) | sign_of(y));
  if (__builtin_expect(any(~usual), 0)) {
    V far = x;
    far_atan2(&y, &far);
    r = choose(usual, r, far);
  }
  return r;
}
"""
