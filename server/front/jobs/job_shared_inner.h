/* job_shared_inner.h - what job_shared.c, job_elsewhere.c and job_claim.c share.
 */
#ifndef SCATTERD_JOB_SHARED_INNER_H
#define SCATTERD_JOB_SHARED_INNER_H

#include "job_shared.h"

struct job_shared {
  jobs *all;
  char id[JOB_HOLDER];
  loop_source source;
  int generation;            /* of the connection whose descriptor is watched */
  double tick, beat, burial; /* when they are due, by loop_now */
  bool more;                 /* there may be jobs to take */
  int64_t waiting;
  double counted; /* when it was, by loop_now */
  unsigned round; /* of looks at what is ours */
};

bool job_row_is_over(const job_row *row);

/* job_elsewhere.c */
job *job_mirror(jobs *j, const job_row *row); /* one that is not ours; NULL when out of memory */
void job_put_elsewhere(job *c);               /* it is ours no more */
bool job_is_needed(const job *c);             /* in memory */
void job_drop_unneeded(job *c);
void job_read_again(job *c);              /* may be gone after it */
void job_check(job *c, const char *self); /* somebody changed it: is it still ours? */

/* job_claim.c */
job *job_take_up(job_shared *h, const job_row *row);
void job_give_back(job *c);
void job_end_done_batch(jobs *j, const job_row *row);

#endif
