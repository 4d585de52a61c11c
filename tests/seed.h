/* seed.h - random numbers of tests: SplitMix64, a seed from SCATTERD_SEED or the clock, printed. */
#ifndef TESTS_SEED_H
#define TESTS_SEED_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

static inline uint64_t seed_new(const char *test) {
  const char *given = getenv("SCATTERD_SEED");
  const uint64_t seed = given != NULL ? strtoull(given, NULL, 10) : (uint64_t)time(NULL);
  printf("%s: SCATTERD_SEED=%llu\n", test, (unsigned long long)seed);
  return seed;
}

static inline uint64_t seed_next(uint64_t *state) {
  uint64_t z = (*state += 0x9e3779b97f4a7c15u);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
  return z ^ (z >> 31);
}

/* Uniform in [low, high). */
static inline double seed_uniform(uint64_t *state, double low, double high) {
  return low + (high - low) * (double)(seed_next(state) >> 11) * 0x1p-53;
}

/* Uniform in 0 .. n-1. */
static inline int seed_below(uint64_t *state, int n) {
  return (int)(seed_next(state) % (uint64_t)n);
}

#endif
