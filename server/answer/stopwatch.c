#include "stopwatch.h"

#include <math.h>
#include <string.h>
#include <time.h>

static double now(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

const char *lap_name(lap l) {
#define LAP_NAME(symbol, name) name,
  static const char *const names[] = {LAP_LIST(LAP_NAME)};
#undef LAP_NAME
  return names[l];
}

void stopwatch_start(stopwatch *watch) {
  memset(watch, 0, sizeof *watch);
  watch->begun = watch->last = now();
}

void stopwatch_lap(stopwatch *watch, lap l) {
  double t = now();
  watch->seconds[l] += t - watch->last;
  watch->last = t;
}

void stopwatch_move(stopwatch *watch, lap from, lap to, double seconds) {
  double moved = fmin(seconds, watch->seconds[from]);
  watch->seconds[from] -= moved;
  watch->seconds[to] += moved;
}

double stopwatch_total(const stopwatch *watch) {
  return now() - watch->begun;
}
