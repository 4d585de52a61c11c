#include "progress.h"

#include <math.h>
#include <string.h>

/* In the order they come in; a request skips what it has no need of. Factors are most of a steady
 * solve, steps of one in time, which factors before its first step within its own phase. */
static const struct {
  const char *phase;
  double from, to; /* fractions of the whole */
} places[] = {{"search", 0, 0.01},
              {"nearest neighbours", 0.01, 0.04},
              {"stencil", 0.04, 0.05},
              {"neighbours", 0.05, 0.07},
              {"neighbour lists", 0.07, 0.1},
              {"assemble", 0.1, 0.25},
              {"apply", 0.1, 0.95},
              {"factor", 0.25, 0.7},
              {"solve", 0.7, 0.95},
              {"march", 0.25, 0.95},
              {"encode", 0.95, 1}};

static double whole(const char *phase, double fraction) {
  for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
    if (strcmp(places[k].phase, phase) != 0) continue;
    return places[k].from + fraction * (places[k].to - places[k].from);
  }
  return fraction;
}

bool progress_report(void *context, const char *phase, double fraction) {
  progress *p = context;
  p->told = fmax(p->told, fmin(1, whole(phase, fraction)));
  return p->calls->report == NULL || p->calls->report(p->calls->context, phase, p->told);
}

void progress_residual(void *context, double value) {
  const progress *p = context;
  if (p->calls->residual != NULL) p->calls->residual(p->calls->context, value);
}
