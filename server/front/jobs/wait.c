#include "wait.h"

#include <math.h>
#include <stdlib.h>

struct waits {
  wait *first;
  bool stopped;
};

static double due(void *self) {
  const waits *all = self;
  double first = INFINITY;
  for (const wait *w = all->first; w != NULL; w = w->next) first = fmin(first, w->until);
  return first;
}

static void end(wait *w) {
  wait_off(w);
  w->over(w->self, &w->now);
}

static void run(void *self) {
  waits *all = self;
  const double now = loop_now();
  for (wait *w = all->first, *next; w != NULL; w = next) {
    next = w->next;
    if (w->until <= now) end(w);
  }
}

waits *waits_new(loop *l) {
  waits *all = calloc(1, sizeof *all);
  if (all != NULL) loop_add(l, (loop_chore){due, run, all});
  return all;
}

void waits_free(waits **all) {
  free(*all);
  *all = NULL;
}

static void changed(void *self, const job_view *now) {
  wait *w = self;
  w->now = *now;
  if (now->active == NULL || w->enough(w->self, now)) end(w);
}

void wait_on(waits *all, wait *w, double seconds) {
  w->until = all->stopped ? 0 : loop_now() + seconds;
  w->next = all->first;
  if (w->next != NULL) w->next->at = &w->next;
  w->at = &all->first;
  all->first = w;
  w->watch = (job_watch){.changed = changed, .self = w};
  job_watch_on(w->now.active, &w->watch);
}

void wait_off(wait *w) {
  if (w->at == NULL) return;
  job_watch_off(&w->watch);
  *w->at = w->next;
  if (w->next != NULL) w->next->at = w->at;
  w->next = NULL;
  w->at = NULL;
}

void waits_stop(waits *all) {
  all->stopped = true;
  while (all->first != NULL) end(all->first);
}
