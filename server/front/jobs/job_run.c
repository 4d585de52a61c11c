/* Running jobs: which goes next, what is told of it meanwhile. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/sendfile.h>
#include <unistd.h>

#include "job_shared.h"
#include "log.h"
#include "memory_file.h"

static const double pause_seconds = 1; /* when a request cannot be opened now */

/* ---- Files ---- */

/* A part of a file as a file of its own, in memory; -1 with errno. */
static int slice(int from, int64_t offset, int64_t size) {
  const int to = memory_file("request");
  off_t at = offset;
  while (to >= 0 && at < offset + size) {
    const ssize_t sent = sendfile(to, from, &at, (size_t)(offset + size - at));
    if (sent > 0 || (sent < 0 && errno == EINTR)) continue;
    close(to);
    return -1;
  }
  return to;
}

static int open_request(const job *c) {
  if (c->batch == NULL) return job_files_open(c->all, &c->row, JOB_REQUEST);
  const int file = job_files_open(c->all, &c->batch->row, JOB_REQUEST);
  const int own = file >= 0 ? slice(file, c->row.offset, c->row.size) : -1;
  if (file >= 0) close(file);
  return own;
}

/* ---- Progress ---- */

static bool advance_row(job *c, double fraction) {
  const int progress = (int)fmin(99, floor(100 * fraction)); /* 100 is for what is over */
  const bool more = progress > c->row.progress;
  c->fraction = fraction;
  if (more) c->row.progress = progress;
  return more;
}

void job_advance(job *c, double fraction) {
  const double step = fraction - c->fraction;
  if (!(step > 0)) return;
  const bool more = advance_row(c, fmin(1, fraction));
  job_touch(c);
  if (more) job_tell(c, JOB_EVENT_PROGRESS);
  job *batch = c->batch;
  if (batch == NULL || batch->row.parts == 0 || c->all->shared != NULL) return;
  batch->sum += step;
  if (advance_row(batch, batch->sum / batch->row.parts)) {
    batch->row.updated = c->row.updated;
    job_tell(batch, JOB_EVENT_PROGRESS);
  }
}

static void checkpoint_kept(job *c, int error) {
  if (error == 0) return;
  log_say(LOG_ERROR, "job", "%s: its checkpoint cannot be kept: %s", c->row.id, strerror(error));
}

/* One that comes before the last one is written is left out: another will follow. */
static void keep_checkpoint(job *c, const ipc_news *news, int fd) {
  if (c->filing[JOB_CHECKPOINT] != NULL) {
    clerk_close(c->all->clerk, fd);
    return;
  }
  job_files_keep(c, JOB_CHECKPOINT, fd, (size_t)news->size, checkpoint_kept);
}

/* Said once it runs; an executor may have had it for some time. */
static void begin_run(job *c) {
  const char *place = c->run != NULL ? executor_place(c->run) : "";
  if (c->row.state != JOB_RUNNING) {
    job_become(c, JOB_RUNNING, "runs, attempt %d%s%s", c->row.attempts, *place != '\0' ? ", " : "",
               place);
  }
  job *batch = c->batch;
  if (batch != NULL && c->all->shared != NULL) {
    job_shared_begin_batch(batch);
  } else if (batch != NULL && batch->row.state == JOB_ACCEPTED) {
    job_become(batch, JOB_RUNNING, "runs, %d parts", batch->row.parts);
  }
}

static void heard(void *context, const ipc_news *news, int fd) {
  job *c = context;
  if (news->kind == IPC_CHECKPOINT) {
    keep_checkpoint(c, news, fd);
    return;
  }
  if (news->kind == IPC_READY) {
    begin_run(c);
    return;
  }
  const bool other = strcmp(c->row.phase, news->phase) != 0;
  memcpy(c->row.phase, news->phase, sizeof c->row.phase);
  if (other) {
    snprintf(c->row.message, sizeof c->row.message, "%s", c->row.phase);
    job_touch(c);
    c->row.residual = 0;
    job_tell(c, JOB_EVENT_PHASE);
  }
  job_advance(c, news->fraction);
  if (news->residual > 0 && isfinite(news->residual)) {
    c->row.residual = news->residual;
    job_tell(c, JOB_EVENT_RESIDUAL);
  }
}

/* ---- On and off a worker ---- */

static void close_files(job *c) {
  if (c->body >= 0) close(c->body);
  if (c->checkpoint >= 0) close(c->checkpoint);
  c->body = c->checkpoint = -1;
}

static bool uses_memory_here(const job *c) {
  return c->run == NULL || executor_is_here(c->all->executor);
}

/* Takes it into the counts of what runs. */
static void count_in(job *c) {
  c->all->counts.running++;
  if (uses_memory_here(c)) c->all->counts.memory += c->row.estimate;
  *c->row.phase = '\0';
  c->row.residual = 0;
}

void job_leave(job *c) {
  jobs *j = c->all;
  if (uses_memory_here(c)) j->counts.memory -= c->row.estimate;
  c->task = NULL;
  c->run = NULL;
  close_files(c);
  j->counts.running--;
}

/* ---- The start of a run ---- */

/* Is it for the executor? */
static bool goes_away(const job *c) {
  return !c->is_for_worker && executor_takes(c->all->executor, c->row.process, c->row.points);
}

static bool fits(void *context, void *owner) {
  const jobs *j = context;
  const job *c = owner;
  const bool away = goes_away(c);
  if (!(away ? executor_has_room(j->executor) : pool_has_room(j->pool))) return false;
  if (away && !executor_is_here(j->executor)) return true;
  return j->counts.running == 0 || j->counts.memory + c->row.estimate <= j->budget;
}

static ipc_ask ask_of(const job *c) {
  const parameters *set = c->all->set;
  ipc_ask ask = {.work = IPC_RUN_STORED,
                 .size = c->row.size,
                 .content = (media)c->row.content,
                 .content_coding = (coding)c->row.content_coding,
                 .limits = set->limits};
  ask.limits.seconds = set->job_seconds;
  snprintf(ask.process, sizeof ask.process, "%s", c->row.process);
  const job_owners *owners = &c->all->owners;
  if (owners->narrow != NULL) owners->narrow(owners->self, c->row.submitter, &ask);
  return ask;
}

static void open_checkpoint(job *c, ipc_ask *ask) {
  if (c->row.started <= 0) return; /* it has never run */
  c->checkpoint = job_files_open(c->all, &c->row, JOB_CHECKPOINT);
  const off_t size = c->checkpoint >= 0 ? lseek(c->checkpoint, 0, SEEK_END) : 0;
  ask->checkpoint = size > 0 ? (int64_t)size : 0;
}

static const pool_calls calls = {job_ended, heard};

/* To the executor, which has copied the request when this returns. What it cannot even begin with
 * is a job that has failed. */
static bool start_away(job *c, ipc_ask *ask) {
  ask->limits.threads = 1;
  c->run = executor_start(c->all->executor, c->row.id, ask, c->body, c->checkpoint, &calls, c);
  const int reason = errno;
  close_files(c);
  if (c->run == NULL) {
    job_fail(c, 500, "it cannot be given to the executor: %s", strerror(reason));
    return true;
  }
  count_in(c);
  c->row.attempts++;
  c->row.updated = unix_now();
  snprintf(c->row.message, sizeof c->row.message, "waits in %s", executor_place(c->run));
  if (executor_is_here(c->all->executor)) begin_run(c);
  job_save(c);
  return true;
}

bool job_adopt(job *c) {
  if (!goes_away(c)) return false;
  c->run = executor_find(c->all->executor, c->row.id, &calls, c);
  if (c->run == NULL) return false;
  count_in(c);
  return true;
}

/* Its request cannot be opened: it waits until it can, for its attempts where that is not sure to
 * come. False if it waits. */
static bool give_up(job *c, int error) {
  jobs *j = c->all;
  if (store_result_of(error) != STORE_DOWN) c->row.attempts++;
  if (error != ENOENT && c->row.attempts < j->set->job_attempts) {
    j->pause = loop_now() + pause_seconds;
    return false;
  }
  job_fail(c, 500, "its request cannot be read: %s", strerror(error));
  return true;
}

static bool start(job *c) {
  ipc_ask ask = ask_of(c);
  if (job_adopt(c)) return true; /* another daemon's, or ours, on a store that is shared */
  c->seconds = ask.limits.seconds;
  c->body = open_request(c);
  if (c->body < 0) return give_up(c, errno);
  open_checkpoint(c, &ask);
  if (goes_away(c)) return start_away(c, &ask);
  c->task = pool_start(c->all->pool, &ask, c->body, c->checkpoint, &calls, c);
  if (c->task == NULL) { /* if no worker is to blame, none will say when there is room again */
    if (pool_has_room(c->all->pool)) c->all->pause = loop_now() + pause_seconds;
    close_files(c);
    return false;
  }
  count_in(c);
  c->row.attempts++;
  begin_run(c);
  return true;
}

void jobs_schedule(void *self) {
  jobs *j = self;
  while (!j->stopped && j->pause == INFINITY &&
         (pool_has_room(j->pool) || executor_has_room(j->executor))) {
    job *c = job_queue_take(j->queue, fits, j);
    if (c == NULL && j->shared != NULL && job_shared_take(j->shared)) continue;
    if (c == NULL) break;
    if (start(c)) continue;
    job_enqueue(c, true);
    break;
  }
  j->queued = false;
}

void job_enqueue(job *c, bool first) {
  job_queue_add(c->all->queue, &c->node, c, c->row.submitter, c->row.priority, first);
  c->all->queued = true;
}

void job_stop(job *c) {
  job_queue_remove(c->all->queue, &c->node);
  job_files_forget(c);
  if (c->ends) job_count_end(c, false);
  if (c->task == NULL && c->run == NULL) return;
  if (c->task != NULL) pool_cancel(c->all->pool, c->task);
  if (c->run != NULL) executor_cancel(c->run);
  job_leave(c);
}
