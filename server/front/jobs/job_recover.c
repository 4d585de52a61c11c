/* What the last daemon left, and what is too old. */
#include <math.h>
#include <search.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "job_shared.h"
#include "keep.h"
#include "log.h"

/* (s) after a failure, and as others may have jobs that expire */
static const double patience = 60;

/* ---- Starting ---- */

typedef struct {
  jobs *jobs;
  job *batch; /* the newest: its parts follow it */
  int count;
  bool failed; /* not all of it could be read */
} recovery;

static bool find_batch(recovery *r, job *c) {
  if (c->row.parent == 0) return true;
  if (r->batch != NULL && r->batch->row.number == c->row.parent) {
    c->batch = r->batch;
    return true;
  }
  return false; /* its batch is over, so it is not wanted */
}

/* Parts that are over are no longer in memory. */
bool job_count_parts(job *c) {
  int64_t count[JOB_STATES];
  if (store_part_states(c->all->store, c->row.number, count) != STORE_OK) return false;
  c->failed = (int)(count[JOB_FAILED] + count[JOB_DISMISSED]);
  c->ended = c->failed + (int)count[JOB_SUCCESSFUL];
  c->sum = c->ended;
  if (c->ended == c->row.parts) job_end_batch(c); /* the last daemon ended just before this */
  return true;
}

void job_wait_again(job *c) {
  const jobs *j = c->all;
  if (job_adopt(c)) return;
  if (c->row.state == JOB_RUNNING && c->row.attempts >= j->set->job_attempts) {
    job_fail(c, 500, "the service ended in each of %d attempts (limit: job-attempts)",
             c->row.attempts);
    return;
  }
  c->row.progress = 0;
  if (c->row.state == JOB_RUNNING) {
    job_become(c, JOB_ACCEPTED, "waits again: the service ended in attempt %d", c->row.attempts);
  }
  if (j->shared == NULL) job_enqueue(c, false); /* else whoever takes it */
}

static bool take_up(void *context, const job_row *row) {
  recovery *r = context;
  job *c = job_new(r->jobs, row);
  r->failed = c == NULL || (c->row.parts > 0 && !job_count_parts(c));
  if (r->failed) return false;
  r->count++;
  if (c->row.parts > 0) {
    r->batch = c;
  } else if (find_batch(r, c)) {
    job_wait_again(c);
  } else {
    job_become(c, JOB_DISMISSED, "its batch is over");
  }
  return true;
}

/* Is a file in use, or may it be? Its name is ID.kind. */
static bool wanted(void *context, const char *name) {
  jobs *j = context;
  char id[JOB_ID];
  job_row row;
  const size_t length = strcspn(name, ".");
  if (length != JOB_ID - 1) return false;
  snprintf(id, sizeof id, "%.*s", (int)length, name);
  const store_result known = store_job(j->store, id, &row);
  if (known != STORE_OK) return known != STORE_NONE; /* what cannot be known is kept */
  const bool is_result = strcmp(name + length, ".result") == 0;
  const bool is_draft = strstr(name + length, ".draft") != NULL;
  if (is_draft || row.state == JOB_DISMISSED) return false;
  return job_state_is_final((job_state)row.state) == is_result;
}

/* Is a run of a job that is not over? */
static bool is_active(void *context, const char *name) {
  const job *c = job_find(context, name);
  return c != NULL && !job_state_is_final((job_state)c->row.state);
}

bool jobs_recover(jobs *j, fault *why) {
  recovery r = {.jobs = j};
  if (j->shared != NULL) { /* others may be at work, on what this one ran before, too */
    executor_sweep(j->executor, is_active, j);
    return true;
  }
  if (store_active(j->store, take_up, &r) != STORE_OK || r.failed) {
    return fault_set(why, "data-dir: the jobs cannot be read");
  }
  keep_sweep(store_files(j->store), wanted, j);
  executor_sweep(j->executor, is_active, j);
  j->expiry = store_first_expiry(j->store, unix_now() + patience);
  if (r.count > 0) log_say(LOG_INFO, "recovered", "%d jobs wait again", r.count);
  return true;
}

/* ---- Expiry ---- */

typedef struct {
  int count;
  job_row row[100];
} expired;

static bool note(void *context, const job_row *row) {
  expired *e = context;
  e->row[e->count++] = *row;
  return e->count < 100;
}

static store_result remove_rows(store *s, const expired *e) {
  store_result result = store_begin(s);
  for (int k = 0; k < e->count && result == STORE_OK; k++) {
    result = store_remove(s, e->row[k].number);
  }
  return store_end(s, result);
}

/* Files first: the rows know those of parts. */
static bool forget(jobs *j, expired *e) {
  if (store_expired(j->store, unix_now(), note, e) != STORE_OK) return false;
  for (int k = 0; k < e->count; k++) {
    job_files_drop(j, &e->row[k], true);
    log_say(LOG_DEBUG, "expired", "job %s", e->row[k].id);
  }
  return remove_rows(j->store, e) == STORE_OK;
}

void jobs_expire(jobs *j) {
  expired *e = calloc(1, sizeof *e);
  const bool good = e != NULL && forget(j, e);
  const double later = unix_now() + patience;
  j->expiry = good ? store_first_expiry(j->store, later) : later;
  if (j->shared != NULL) j->expiry = fmin(j->expiry, later);
  free(e);
}

void jobs_shift(jobs *j, double by) {
  j->expiry += by;
}

/* ---- The whole ---- */

/* Jobs are queued wherever the store is brought up to date, so also by who only looks for one. */
static double due(void *self) {
  const jobs *j = self;
  if (j->queued) return 0;
  const double save = j->changed == NULL ? INFINITY : j->retry > 0 ? j->retry : 0;
  const double shared = j->shared != NULL ? job_shared_due(j->shared) : INFINITY;
  return fmin(fmin(fmin(save, shared), j->pause), loop_now() + (j->expiry - unix_now()));
}

static void run(void *self) {
  jobs *j = self;
  jobs_flush(j);
  if (j->shared != NULL) job_shared_run(j->shared);
  if (j->expiry <= unix_now()) jobs_expire(j);
  if (j->pause <= loop_now()) j->pause = INFINITY;
  jobs_schedule(j);
}

static int64_t budget_of(const parameters *set) {
  if (set->memory_budget > 0) return set->memory_budget;
  return (int64_t)sysconf(_SC_PHYS_PAGES) / 4 * 3 * sysconf(_SC_PAGESIZE);
}

jobs *jobs_new(loop *l, const parameters *set, pool *p, executor *x, store *s, clerk *k,
               fault *why) {
  jobs *j = calloc(1, sizeof *j);
  if (j == NULL) goto failed;
  *j = (jobs){.loop = l,
              .set = set,
              .pool = p,
              .executor = x,
              .store = s,
              .clerk = k,
              .queue = job_queue_new()};
  j->last_changed = &j->changed;
  j->expiry = j->pause = INFINITY;
  j->budget = budget_of(set);
  if (j->queue == NULL) goto failed;
  if (store_is_shared(s)) {
    j->expiry = 0;
    j->shared = job_shared_new(j);
    if (j->shared == NULL) goto failed;
  }
  if (!jobs_recover(j, why)) {
    jobs_free(&j);
    return NULL;
  }
  loop_add(l, (loop_chore){due, run, j});
  pool_on_room(p, jobs_schedule, j);
  executor_on_room(x, jobs_schedule, j);
  return j;
failed:
  fault_set(why, "out of memory");
  if (j != NULL) job_queue_free(&j->queue);
  free(j);
  return NULL;
}

static void leave_batch(const void *node, VISIT when, int depth) {
  (void)depth;
  if (when == postorder || when == leaf) (*(job *const *)node)->batch = NULL;
}

static void free_all(jobs *j) {
  twalk(j->by_id, leave_batch); /* which may go first */
  while (j->by_id != NULL) job_free(*(job **)j->by_id);
}

void jobs_free(jobs **j) {
  if (*j == NULL) return;
  (*j)->stopped = true;
  for (int k = 0; k < 2 && (*j)->changed != NULL; k++) { /* parts, then their batches */
    (*j)->retry = 0;
    jobs_flush(*j);
  }
  pool_on_room((*j)->pool, NULL, NULL);
  executor_on_room((*j)->executor, NULL, NULL);
  job_shared_free(&(*j)->shared);
  free_all(*j);
  job_queue_free(&(*j)->queue);
  job_tally_clear(&(*j)->tally);
  free(*j);
  *j = NULL;
}
