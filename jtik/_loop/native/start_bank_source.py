"""The C code that takes the starts of a bank in the order of their distance from a target.

It computes as `jtik._loop.search.start_bank.StartBank.keys` does, to the bit. Loops over starts have fixed lengths:
compilers make vector instructions of them.
"""

from __future__ import annotations

from jtik._loop.search.start_bank import SIZE

SOURCE = rf"""
#include <math.h>
#include <stdint.h>
#include <string.h>

#define JTIK_BANK {SIZE} /* number of starts, a power of two: the lowest bits of a key are the row of its start */
#define JTIK_SIDE_BY_SIDE 32 /* starts whose distances are summed at the same time */
#define JTIK_FIRST INT32_MIN /* less than all keys */
#ifndef JTIK_CPU
#define JTIK_CPU
#endif

/* Restarts, see jtik._loop.search.starts.Starts: the first ones are those of a bank in the order of their keys, where
   there is one, all others come in the order of their configurations. */
typedef struct {{
  const double* configurations;
  const float* coefficients;
  const double* centre;
  long long size; /* of the bank, 0 without one */
}} JTIK_NAME_starts;

/* The keys of the starts of a bank for a target of so many numbers: the closer, the smaller. */
static JTIK_CPU void JTIK_NAME_keys(int32_t* keys, const JTIK_NAME_starts* bank, const double* target,
                                    int numbers) {{
  for (int first = 0; first < JTIK_BANK; first += JTIK_SIDE_BY_SIDE) {{
    float distance[JTIK_SIDE_BY_SIDE];
    memcpy(distance, bank->coefficients + first, sizeof distance);
    for (int j = 0; j < numbers; ++j) {{
      const float *factors = bank->coefficients + (j + 1) * JTIK_BANK + first;
      const float number = (float)(target[j] - bank->centre[j]);
      for (int k = 0; k < JTIK_SIDE_BY_SIDE; ++k) {{
        const float product = number * factors[k];
        distance[k] = distance[k] + product;
      }}
    }}
    for (int k = 0; k < JTIK_SIDE_BY_SIDE; ++k) {{
      int32_t bits;
      if (!(fabsf(distance[k]) < INFINITY)) distance[k] = INFINITY;
      memcpy(&bits, distance + k, sizeof bits);
      bits ^= (bits >> 31) & INT32_MAX; /* integers in the order of the numbers */
      keys[first + k] = (bits & -JTIK_BANK) | (first + k);
    }}
  }}
}}

/* The key that follows another one; after the last comes the first. */
static JTIK_CPU int32_t JTIK_NAME_following(const int32_t* keys, int32_t key) {{
  const uint32_t next = (uint32_t)key + 1;
  uint32_t smallest = UINT32_MAX;
  for (int k = 0; k < JTIK_BANK; ++k) {{
    const uint32_t beyond = (uint32_t)keys[k] - next; /* larger for all before than for all after it */
    smallest = beyond < smallest ? beyond : smallest;
  }}
  return (int32_t)(next + smallest);
}}
"""
