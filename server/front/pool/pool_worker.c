/* The life of a worker: started, watched, killed, replaced. */
#include "pool_worker.h"

#include <errno.h>
#include <limits.h>
#include <math.h>
#include <string.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "counter.h"
#include "log.h"

static const int at_once = 16;             /* messages of a worker that are read in one go */
static const double start_seconds = 30;    /* for a worker to come up */
static const double end_seconds = 5;       /* for a worker to go when told */
static const double first_delay = 0.1;     /* after a worker died without serving anything */
static const double longest_delay = 5;     /* the delay doubles up to here */
static const double memory_of_mean = 0.05; /* weight of the newest request in the mean time */

/* ---- Its task ---- */

pool_task *worker_release(worker *w) {
  pool *p = w->pool;
  pool_task *t = w->task;
  w->task = NULL;
  p->jobs -= t->is_job;
  if (p->values.ended != NULL) p->values.ended(p->values.self, t);
  return t;
}

void worker_finish(worker *w, pool_outcome *outcome) {
  pool_task *t = worker_release(w);
  outcome->worker = w->child.pid;
  outcome->seconds = loop_now() - t->started;
  if (!t->is_job) w->pool->mean += memory_of_mean * (outcome->seconds - w->pool->mean);
  task_end(t, outcome);
}

static void finish_without_reply(worker *w, pool_end end) {
  pool_outcome outcome = {.end = end, .fd = -1};
  if (w->task != NULL) worker_finish(w, &outcome);
}

/* ---- Its process ---- */

void worker_become(worker *w, worker_state s, double seconds) {
  w->state = s;
  w->until = loop_now() + seconds;
}

static void close_socket(worker *w) {
  if (w->child.socket < 0) return;
  loop_forget(w->pool->loop, w->child.socket, &w->spoke);
  close(w->child.socket);
  w->child.socket = -1;
}

/* Waits for the end of the process, which was killed or has ended, and closes what is open. */
static void reap(worker *w, siginfo_t *how) {
  close_socket(w);
  if (w->child.pidfd >= 0) loop_forget(w->pool->loop, w->child.pidfd, &w->exited);
  child_reap(&w->child, how);
}

/* Tells an idle worker to go: it leaves its loop when the socket closes. */
static void dismiss(worker *w) {
  w->planned = true;
  close_socket(w);
  worker_become(w, ENDING, end_seconds);
}

void worker_become_idle(worker *w) {
  w->state = IDLE;
  w->until = INFINITY;
  if (w->served >= w->pool->set->recycle) dismiss(w);
}

void worker_kill(worker *w) {
  child_kill(&w->child);
  close_socket(w);
  worker_become(w, ENDING, end_seconds);
}

/* After a life that served nothing: the delay grows, so that a worker that cannot live costs
 * little. */
static void start_later(worker *w) {
  worker_become(w, ABSENT, fmin(longest_delay, first_delay * ldexp(1, w->failures++)));
}

static void on_spoke(void *self, uint32_t events) {
  worker *w = self;
  (void)events;
  worker_listen(w, at_once);
  pool_dispatch(w->pool);
}

static void log_exit(const worker *w, pid_t pid, const siginfo_t *how) {
  const bool exited = how->si_code == CLD_EXITED;
  const bool clean = w->planned && (how->si_status == (exited ? 0 : SIGKILL));
  log_line line;
  counter_add(COUNTER_EXITS, 1, LABELS(clean ? "planned" : exited ? "code" : "signal"));
  log_begin(&line, clean ? LOG_DEBUG : LOG_ERROR, "worker-exit");
  log_count(&line, "worker", pid);
  log_count(&line, exited ? "code" : "signal", how->si_status);
  log_count(&line, "served", w->served);
  log_end(&line);
}

static void on_exited(void *self, uint32_t events) {
  worker *w = self;
  siginfo_t how = {0};
  (void)events;
  worker_listen(w, INT_MAX); /* a reply may have come just before the end */
  finish_without_reply(w, POOL_CRASH);
  const pid_t pid = w->child.pid;
  reap(w, &how);
  log_exit(w, pid, &how);
  if (w->planned || w->served > 0) {
    worker_start(w);
  } else {
    start_later(w);
  }
}

static bool watch(worker *w) {
  w->exited = (loop_source){on_exited, w};
  w->spoke = (loop_source){on_spoke, w};
  return loop_watch(w->pool->loop, w->child.pidfd, EPOLLIN, &w->exited) &&
         loop_watch(w->pool->loop, w->child.socket, EPOLLIN, &w->spoke);
}

void worker_start(worker *w) {
  if (!child_start(&w->child, w->pool->set->limits.memory_bytes) || !watch(w)) {
    log_say(LOG_ERROR, "worker", "cannot start a worker: %s", strerror(errno));
    child_kill(&w->child);
    reap(w, &(siginfo_t){0});
    start_later(w);
    return;
  }
  counter_add(COUNTER_STARTS, 1, NO_LABELS);
  w->served = 0;
  w->planned = false;
  worker_become(w, STARTING, start_seconds);
}

void worker_run_out(worker *w) {
  if (w->state == ABSENT) {
    worker_start(w);
    return;
  }
  if (w->state == BUSY) w->planned = true;
  finish_without_reply(w, POOL_TIME);
  worker_kill(w);
}

void worker_end(worker *w) {
  siginfo_t how;
  child_kill(&w->child);
  finish_without_reply(w, POOL_STOPPED);
  reap(w, &how);
  w->state = ABSENT;
  w->until = INFINITY;
}
