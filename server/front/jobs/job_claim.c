/* Making jobs ours, and ending those of anybody: batches by whoever ends the last part, any job by
 * whoever dismisses it. */
#include <stdio.h>

#include "job_shared_inner.h"
#include "store_shared.h"

/* ---- Jobs ---- */

/* The batch of a part is in memory as long as the part is. */
static bool attach(job *c) {
  job_row row;
  jobs *j = c->all;
  if (c->row.parent == 0 || c->batch != NULL) return true;
  if (store_job_number(j->store, c->row.parent, &row) != STORE_OK) return false;
  c->batch = job_mirror(j, &row);
  if (c->batch == NULL) return false;
  c->batch->members++;
  return true;
}

/* A job that the store says is ours, in memory; NULL if that cannot be: then it is found again with
 * the next look. */
job *job_take_up(job_shared *h, const job_row *row) {
  job *c = job_mirror(h->all, row);
  if (c == NULL) return NULL;
  c->row = *row;
  snprintf(c->row.holder, sizeof c->row.holder, "%s", h->id);
  snprintf(c->held, sizeof c->held, "%s", h->id);
  c->elsewhere = false;
  c->round = h->round;
  c->fraction = 0;
  if (attach(c)) return c;
  job_put_elsewhere(c);
  job_drop_unneeded(c);
  return NULL;
}

/* ---- Batches ---- */

static bool claim(job *batch) {
  job_shared *h = batch->all->shared;
  if (!batch->elsewhere) return false; /* about to be stored */
  if (store_claim(h->all->store, h->id, &batch->row) != STORE_OK) return false;
  snprintf(batch->held, sizeof batch->held, "%s", h->id);
  batch->elsewhere = false;
  return true;
}

void job_shared_begin_batch(job *batch) {
  if (batch->row.state != JOB_ACCEPTED || !claim(batch)) return;
  job_become(batch, JOB_RUNNING, "runs, %d parts", batch->row.parts);
}

/* Gives back what turned out not to be over. */
void job_give_back(job *c) {
  job_row row = c->row;
  *row.holder = '\0';
  (void)store_update(c->all->store, &row, c->held, NULL, 0);
  job_put_elsewhere(c);
  job_drop_unneeded(c);
}

void job_end_done_batch(jobs *j, const job_row *row) {
  job *batch = job_mirror(j, row);
  if (batch == NULL || !batch->elsewhere) return;
  batch->row = *row;
  if (!claim(batch)) return;
  (void)job_count_parts(batch);
  if (!batch->changed) job_give_back(batch);
}

void job_shared_part_ended(job *part) {
  job_row row;
  jobs *j = part->all;
  if (part->row.parent == 0 || store_has_active_part(j->store, part->row.parent)) return;
  if (store_job_number(j->store, part->row.parent, &row) != STORE_OK || job_row_is_over(&row))
    return;
  job_end_done_batch(j, &row);
}

/* ---- Dismissing ---- */

static job_row dismissed(const jobs *j, const job_row *row) {
  job_row next = *row;
  next.state = JOB_DISMISSED;
  next.updated = unix_now();
  *next.holder = '\0';
  snprintf(next.message, sizeof next.message, "dismissed");
  if (job_row_is_over(row)) return next;
  next.finished = next.updated;
  if (next.parent == 0) next.expires = next.finished + j->set->result_seconds;
  return next;
}

static store_result write_dismissed(store *s, const job_row *row, const char *held) {
  const bool is_batch = row->parts > 0;
  store_result result = store_begin(s);
  if (result == STORE_OK) result = store_update(s, row, held, NULL, 0);
  if (result == STORE_OK && is_batch) result = store_dismiss_parts(s, row->number, row->updated);
  if (result == STORE_OK) result = store_drop_small(s, row->number, -1);
  if (result == STORE_OK) result = store_drop_large(s, row->id, 0, JOB_FILES);
  if (result == STORE_OK) result = store_log(s, row->number, row->updated, "dismissed");
  if (result == STORE_OK) result = store_tell(s, is_batch ? "*" : row->id);
  return store_end(s, result);
}

/* It is written whoever has it, who then loses it; only what changed hands meanwhile is read again.
 */
store_result job_shared_dismiss(jobs *j, const job_row *row, job_view *view) {
  job_shared *h = j->shared;
  job_row was = *row, next;
  store_result result = STORE_NONE;
  for (int k = 0; k < 5 && result == STORE_NONE; k++) {
    if (k > 0 && (result = store_job(j->store, row->id, &was)) != STORE_OK) break;
    next = dismissed(j, &was);
    result = was.state == JOB_DISMISSED ? STORE_OK : write_dismissed(j->store, &next, was.holder);
  }
  *view = (job_view){.row = next};
  job *c = result == STORE_OK ? job_find(j, row->id) : NULL;
  if (c != NULL) job_check(c, h->id);
  if (next.parts > 0) h->tick = 0;
  h->counted = 0;
  return result == STORE_NONE ? STORE_FAILED : result;
}
