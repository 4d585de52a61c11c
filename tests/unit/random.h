/* random.h - reproducible random numbers for tests; the seed is printed and can be given. */
#ifndef SCATTERD_TEST_RANDOM_H
#define SCATTERD_TEST_RANDOM_H

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct {
  uint64_t state;
} test_random;

/* Seed from SCATTERD_TEST_SEED, else from the clock; printed, so that a failure can be repeated. */
static inline test_random test_random_start(void) {
  const char *given = getenv("SCATTERD_TEST_SEED");
  uint64_t seed = given != NULL ? strtoull(given, NULL, 10) : (uint64_t)time(NULL);
  printf("SCATTERD_TEST_SEED=%llu\n", (unsigned long long)seed);
  return (test_random){seed};
}

/* SplitMix64. */
static inline uint64_t test_random_next(test_random *r) {
  uint64_t z = r->state += 0x9E3779B97F4A7C15u;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
  return z ^ (z >> 31);
}

/* 0 .. n-1 */
static inline uint64_t test_random_below(test_random *r, uint64_t n) {
  return test_random_next(r) % n;
}

#endif
