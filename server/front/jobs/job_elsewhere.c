/* Jobs that another daemon has, or none: as they were read last, for who watches them here. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "job_shared_inner.h"
#include "log.h"
#include "store_shared.h"

bool job_row_is_over(const job_row *row) {
  return job_state_is_final((job_state)row->state);
}

/* ---- In memory ---- */

bool job_is_needed(const job *c) {
  return !c->elsewhere || c->changed || c->watches != NULL || c->members > 0;
}

void job_drop_unneeded(job *c) {
  if (!job_is_needed(c)) job_free(c);
}

void job_put_elsewhere(job *c) {
  job_files_forget(c);
  c->elsewhere = true;
  *c->row.holder = *c->held = '\0';
}

/* A job that is not ours, as it was read. NULL when out of memory. */
job *job_mirror(jobs *j, const job_row *row) {
  job *c = job_find(j, row->id);
  if (c != NULL) return c;
  c = job_new(j, row);
  if (c != NULL) c->elsewhere = true;
  return c;
}

/* ---- Jobs that are elsewhere ---- */

void job_shared_fill(jobs *j, job_row *row) {
  if (row->parts == 0 || job_row_is_over(row)) return;
  row->progress = (int)fmin(99, floor(store_part_progress(j->store, row->number)));
}

/* Shows everybody who watches what has changed. What is over is gone after this, false. */
static bool renew(job *c, const job_row *now) {
  const job_row was = c->row;
  c->row = *now;
  job_shared_fill(c->all, &c->row);
  if (was.state != now->state) {
    job_tell(c, JOB_EVENT_STATUS);
  } else if (strcmp(was.phase, now->phase) != 0) {
    job_tell(c, JOB_EVENT_PHASE);
  } else if (was.residual != now->residual) {
    job_tell(c, JOB_EVENT_RESIDUAL);
  } else if (was.progress != c->row.progress || c->row.parts > 0) { /* a part may have ended */
    job_tell(c, JOB_EVENT_PROGRESS);
  }
  if (!job_row_is_over(now)) return true;
  job_drop_unneeded(c);
  return false;
}

/* Its row is gone, which only a job that is over can be. */
static void renew_as_gone(job *c) {
  job_row row = c->row;
  row.state = JOB_DISMISSED;
  row.updated = unix_now();
  snprintf(row.message, sizeof row.message, "dismissed");
  (void)renew(c, &row);
}

void job_read_again(job *c) {
  job_row row;
  const store_result result = store_job(c->all->store, c->row.id, &row);
  if (result == STORE_OK) {
    (void)renew(c, &row);
  } else if (result == STORE_NONE) {
    renew_as_gone(c);
  }
}

void job_shared_lose(job *c) {
  log_say(LOG_INFO, "lost", "job %s is not of this daemon any more", c->row.id);
  job_stop(c);
  job_files_clear(c);
  free(c->problem);
  c->problem = NULL;
  job_put_elsewhere(c);
  job_read_again(c);
}

job *job_shared_look(jobs *j, const job_row *row) {
  job *c = job_find(j, row->id);
  if (c != NULL && !c->elsewhere) return job_row_is_over(row) && !c->changed ? NULL : c;
  if (c != NULL) return renew(c, row) ? c : NULL;
  if (job_row_is_over(row)) return NULL;
  c = job_mirror(j, row);
  if (c != NULL) job_shared_fill(j, &c->row);
  return c;
}

/* Somebody changed it: is it still ours, what has become of it? */
void job_check(job *c, const char *self) {
  job_row row;
  if (c->elsewhere) {
    job_read_again(c);
  } else if (!c->changed && store_job(c->all->store, c->row.id, &row) == STORE_OK &&
             strcmp(row.holder, self) != 0) {
    job_shared_lose(c);
  }
}
