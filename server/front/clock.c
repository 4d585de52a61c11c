#include "clock.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

#include "callback.h"
#include "data.h"
#include "log.h"

static const double least_step = 10;   /* (s) */
static const double retry_seconds = 1; /* when the dates could not be stored */

struct clock_watch {
  const service *service;
  double offset; /* of the time of day to the time since boot */
  double retry;  /* loop_now before which it is not tried again */
};

/* The time since boot counts what a machine sleeps: a result may expire while nobody is awake. */
static double offset_now(void) {
  struct timespec t;
  clock_gettime(CLOCK_BOOTTIME, &t);
  return unix_now() - ((double)t.tv_sec + 1e-9 * (double)t.tv_nsec);
}

static double step(const clock_watch *w) {
  const double by = offset_now() - w->offset;
  if (store_is_shared(w->service->store)) return 0; /* its clock counts, not this machine's */
  return fabs(by) < least_step ? 0 : by;
}

void clock_watch_look(clock_watch *w) {
  const service *s = w->service;
  const double by = step(w);
  if (by == 0 || loop_now() < w->retry) return;
  if (store_shift(s->store, by) != STORE_OK) {
    w->retry = loop_now() + retry_seconds;
    return;
  }
  w->offset += by;
  jobs_shift(s->jobs, by);
  data_shift(s->data, by);
  callbacks_shift(s->callbacks, by);
  log_say(LOG_INFO, "clock", "the time of day was set by %.0f s; what expires was moved with it",
          by);
}

static double due(void *self) {
  const clock_watch *w = self;
  return step(w) == 0 ? INFINITY : w->retry;
}

static void run(void *self) {
  clock_watch_look(self);
}

clock_watch *clock_watch_new(loop *l, const service *s) {
  clock_watch *w = calloc(1, sizeof *w);
  if (w == NULL) return NULL;
  *w = (clock_watch){.service = s, .offset = offset_now()};
  loop_add(l, (loop_chore){due, run, w});
  return w;
}

void clock_watch_free(clock_watch **w) {
  free(*w);
  *w = NULL;
}
