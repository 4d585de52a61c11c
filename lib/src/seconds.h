/* seconds.h - how long something takes. */
#ifndef SCATTER_SECONDS_H
#define SCATTER_SECONDS_H

#include <time.h>

/* Elapsed time since some fixed moment (s). */
static inline double seconds_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#endif
