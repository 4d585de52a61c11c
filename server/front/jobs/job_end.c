/* What becomes of a job when its run ends: a result that is kept, a problem, another attempt; and
 * of a batch when its last part does. */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "job_shared.h"
#include "log.h"
#include "problem.h"

static const double weight_of_new = 0.05; /* in the mean time of a run */
enum { PROBLEM_BYTES = 1 << 16 };

/* ---- Problems ---- */

static void take_problem(job *c, int status, void *bytes, size_t size, const char *message) {
  free(c->problem);
  c->problem = bytes;
  c->problem_size = size;
  c->row.status = status;
  job_become(c, JOB_FAILED, "%s", message);
}

void job_fail(job *c, int status, const char *format, ...) {
  char text[PROBLEM_TEXT];
  problem p;
  size_t size = 0;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  problem_begin(&p, status, "%s", text);
  char *bytes = problem_bytes(&p, &size);
  take_problem(c, status, bytes, size, p.detail);
}

static void end_refused(job *c, const pool_outcome *o) {
  const size_t size = o->size < PROBLEM_BYTES ? o->size : 0;
  char *bytes = size > 0 ? malloc(size) : NULL;
  if (bytes == NULL || pread(o->fd, bytes, size, 0) != (ssize_t)size) {
    free(bytes);
    job_fail(c, 500, "the problem of the run cannot be read");
    return;
  }
  take_problem(c, o->status, bytes, size,
               *o->detail != '\0' ? o->detail : problem_phrase(o->status));
}

/* ---- Another attempt ---- */

/* What a run added is taken back: it begins again. */
static void retreat(job *c) {
  if (c->batch != NULL) c->batch->sum -= c->fraction;
  c->fraction = 0;
  c->row.progress = 0;
}

/* This attempt came to nothing, by no fault of the job: it waits for the next, if it has one. Not
 * one that never ran, which an executor has refused. */
static bool wait_again(job *c, const char *why) {
  if (c->row.state != (int)JOB_RUNNING) return false;
  if (c->row.attempts >= c->all->set->job_attempts) return false;
  retreat(c);
  job_become(c, JOB_ACCEPTED, "waits again: %s in attempt %d", why, c->row.attempts);
  job_enqueue(c, true);
  return true;
}

/* ---- A result ---- */

static void end_unkept(job *c, int error) {
  const store_result why = store_result_of(error);
  if (why == STORE_DOWN && wait_again(c, "the result could not be kept")) return;
  job_fail(c, why == STORE_FULL ? 507 : 500, "the result cannot be kept: %s", strerror(error));
}

/* Until its result is kept it counts as running, with its memory, where the result may be. */
void job_count_end(job *c, bool ends) {
  jobs *j = c->all;
  c->ends = ends;
  j->counts.running += ends ? 1 : -1;
  j->counts.memory += ends ? c->row.estimate : -c->row.estimate;
}

static void result_kept(job *c, int error) {
  job_count_end(c, false);
  if (error == 0) {
    c->row.progress = 100;
    job_become(c, JOB_SUCCESSFUL, "done in %.3g s", c->took);
    return;
  }
  c->row.result_size = 0;
  end_unkept(c, error);
}

static void keep_result(job *c, const pool_outcome *o) {
  c->row.result_size = (int64_t)o->size;
  c->row.result_coding = (int)o->coding;
  c->row.points = o->points;
  c->took = o->seconds;
  job_count_end(c, true);
  job_files_keep(c, JOB_RESULT, o->fd, o->size, result_kept);
}

/* ---- Ends ---- */

static void end_replied(job *c, const pool_outcome *o) {
  if (o->status == 200) {
    keep_result(c, o);
    return;
  }
  const bool unheard = o->status == 503; /* a value by reference could not be had now */
  if (unheard && wait_again(c, "a value by reference could not be had")) {
    log_say(LOG_INFO, "retry", "job %s", c->row.id);
  } else {
    end_refused(c, o);
  }
  if (o->fd >= 0) close(o->fd);
}

static void end_memory(job *c, const pool_outcome *o) {
  job_fail(c, 422, "the solve%s%s needs more than %lld bytes of memory (memory-bytes)",
           *o->phase != '\0' ? " in phase " : "", o->phase,
           (long long)c->all->set->limits.memory_bytes);
}

static void end_time(job *c, const pool_outcome *o) {
  job_fail(c, 504, "the solve was stopped%s%s after %g s (limit: job-seconds%s)",
           *o->phase != '\0' ? " in phase " : "", o->phase, c->seconds,
           c->seconds < c->all->set->job_seconds ? ", seconds of the token" : "");
}

static void end_crashed(job *c, const pool_outcome *o) {
  if (wait_again(c, "the worker died")) return;
  job_fail(c, 500, "the worker died%s%s in %d attempts (limit: job-attempts)",
           *o->phase != '\0' ? " in phase " : "", o->phase, c->row.attempts);
}

/* The daemon stops; this attempt does not count. */
static void end_stopped(job *c, const pool_outcome *o) {
  (void)o;
  retreat(c);
  c->row.attempts--;
  job_become(c, JOB_ACCEPTED, "waits for the service to start again");
}

/* It has values by reference, say. This attempt does not count either. */
static void end_elsewhere(job *c, const pool_outcome *o) {
  (void)o;
  retreat(c);
  c->row.attempts--;
  c->is_for_worker = true;
  if (c->row.state == JOB_RUNNING) job_become(c, JOB_ACCEPTED, "waits for a worker");
  job_enqueue(c, true);
}

static void (*const ends[])(job *c, const pool_outcome *o) = {
    [POOL_REPLY] = end_replied, [POOL_MEMORY] = end_memory,   [POOL_TIME] = end_time,
    [POOL_CRASH] = end_crashed, [POOL_STOPPED] = end_stopped, [POOL_ELSEWHERE] = end_elsewhere,
};

void job_ended(void *context, const pool_outcome *o) {
  job *c = context;
  job_leave(c);
  c->all->mean += weight_of_new * (o->seconds - c->all->mean);
  ends[o->end](c, o);
}

/* ---- Batches ---- */

/* It has failed only if nothing of it was successful: else its results say what failed. */
void job_end_batch(job *batch) {
  const int good = batch->ended - batch->failed;
  if (good == 0) {
    job_fail(batch, 422, "none of the %d requests of the batch was successful", batch->row.parts);
    return;
  }
  batch->row.progress = 100;
  job_become(batch, JOB_SUCCESSFUL, "%d requests successful, %d not", good, batch->failed);
}

void job_part_ended(job *part) {
  job *batch = part->batch;
  if (part->all->shared != NULL) {
    job_shared_part_ended(part);
    return;
  }
  if (batch == NULL || job_state_is_final((job_state)batch->row.state)) return;
  job_advance(part, 1);
  batch->ended++;
  batch->failed += part->row.state != JOB_SUCCESSFUL;
  if (batch->watches != NULL) job_tell(batch, JOB_EVENT_PROGRESS);
  if (batch->ended == batch->row.parts) job_end_batch(batch);
}
