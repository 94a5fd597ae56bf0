"""The C code that takes the starts of a bank in the order of their distance from a target."""

SOURCE = r"""
#define JTIK_SIDE_BY_SIDE 4 /* vectors of distances that are summed at the same time: none waits for the other */
#define JTIK_NO_START {-1, -INFINITY}

/* A start of a bank, and its distance from the target. */
typedef struct { long long index; R distance; } JTIK_NAME_start;

/* The distances of all starts from a target, whose numbers are so far apart. */
static JTIK_CPU void JTIK_NAME_distances(V* distances, const R* target, int apart, const V* bank,
                                         long long count) {
  const long long stride = count / JTIK_LANES;
  for (long long b = 0; b < stride; b += JTIK_SIDE_BY_SIDE) {
    V distance[JTIK_SIDE_BY_SIDE];
    for (int k = 0; k < JTIK_SIDE_BY_SIDE; ++k) distance[k] = bank[b + k];
    for (int j = 0; j < JTIK_NT; ++j) {
      const V* row = bank + (j + 1) * stride + b;
      const V number = ALL(target[j * apart]);
      for (int k = 0; k < JTIK_SIDE_BY_SIDE; ++k) distance[k] = v_fma(row[k], number, distance[k]);
    }
    for (int k = 0; k < JTIK_SIDE_BY_SIDE; ++k) distances[b + k] = distance[k];
  }
}

/* The start that follows one in the order of their distances, then of the bank. */
static JTIK_CPU void JTIK_NAME_follow(JTIK_NAME_start* start, const V* distances, long long count) {
  const V latest = ALL(start->distance);
  const long long stride = count / JTIK_LANES, following = (start->index + 1) % count;
  V smallest = ALL(INFINITY);
  M which = {0}, at = {0};
  for (int i = 0; i < JTIK_LANES; ++i) at[i] = i;
  for (long long b = 0; b < stride; ++b, at += JTIK_LANES) {
    const V distance = distances[b];
    const M later = (distance > latest) | ((distance == latest) & (at > (I)start->index));
    const M closer = later & (distance < smallest);
    smallest = choose(closer, distance, smallest);
    which = bits(choose(closer, of_bits(at), of_bits(which)));
  }
  start->distance = INFINITY;
  for (int i = 0; i < JTIK_LANES; ++i) {
    if (smallest[i] < start->distance || (smallest[i] == start->distance && which[i] < start->index)) {
      start->distance = smallest[i];
      start->index = which[i];
    }
  }
  if (start->distance == INFINITY) start->index = following; /* none that is left has a finite distance */
}
"""
