/* wait.h - requests that wait for a job, but not for ever. Test: http.jobs.
 */
#ifndef SCATTERD_WAIT_H
#define SCATTERD_WAIT_H

#include "job.h"
#include "loop.h"

typedef struct waits waits;

waits *waits_new(loop *l); /* NULL when out of memory */
void waits_free(waits **all);

/* All zero while it is off; lives in whatever waits. */
typedef struct wait {
  struct wait *next, **at;
  job_watch watch;
  double until; /* loop_now */
  job_view now; /* the job as it was last seen */
  bool (*enough)(void *self, const job_view *now);
  void (*over)(void *self, const job_view *now); /* enough, or the time is over; it is off then */
  void *self;
} wait;

/* Waits until `enough` says so, at most `seconds`; the caller has set the last three members and
 * `now`, whose job is active. */
void wait_on(waits *all, wait *w, double seconds);
void wait_off(wait *w); /* nothing if it is off */

/* It is over for all of them, now. */
void waits_stop(waits *all);

#endif
