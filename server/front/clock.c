#include "clock.h"

#include <math.h>
#include <stdlib.h>

#include "callback.h"
#include "data.h"
#include "log.h"
#include "store_shared.h"

static const double least_step = 10;   /* (s) */
static const double retry_seconds = 1; /* when the dates could not be stored */

struct clock_watch {
  const service *service;
  double retry; /* loop_now before which it is not tried again */
};

/* Daemons that share a store go by its clock. */
static double step(const clock_watch *w) {
  return store_is_shared(w->service->store) ? 0 : unix_step();
}

static bool was_set(double by) {
  return fabs(by) >= least_step;
}

void clock_watch_look(clock_watch *w) {
  const service *s = w->service;
  const double by = step(w);
  if (was_set(by) && loop_now() < w->retry) return;
  if (was_set(by) && store_shift(s->store, by) != STORE_OK) {
    w->retry = loop_now() + retry_seconds;
    return;
  }
  if (!store_is_shared(s->store)) unix_follow();
  if (!was_set(by)) return;
  jobs_shift(s->jobs, by);
  data_shift(s->data, by);
  callbacks_shift(s->callbacks, by);
  log_say(LOG_INFO, "clock", "the time of day was set by %.0f s; what expires was moved with it",
          by);
}

static double due(void *self) {
  const clock_watch *w = self;
  return was_set(step(w)) ? w->retry : INFINITY;
}

static void run(void *self) {
  clock_watch_look(self);
}

/* From the beginning; from then on with each beat. */
static void follow_store(store *s) {
  double now = 0;
  const double before = unix_now();
  if (store_clock(s, &now) == STORE_OK) (void)unix_tune(now, before);
}

clock_watch *clock_watch_new(loop *l, const service *s) {
  clock_watch *w = calloc(1, sizeof *w);
  if (w == NULL) return NULL;
  *w = (clock_watch){.service = s};
  unix_follow();
  if (store_is_shared(s->store)) follow_store(s->store);
  loop_add(l, (loop_chore){due, run, w});
  return w;
}

void clock_watch_free(clock_watch **w) {
  free(*w);
  *w = NULL;
}
