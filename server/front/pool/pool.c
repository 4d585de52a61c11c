#include "pool.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "counter.h"
#include "pool_worker.h"

static const double retry_most = 60; /* of Retry-After */

int pool_workers(int64_t parameter) {
  if (parameter > 0) return (int)parameter;
  const long processors = sysconf(_SC_NPROCESSORS_ONLN);
  return processors < 2 ? 2 : (int)processors;
}

/* ---- Giving out work ---- */

void pool_dispatch(pool *p) {
  for (int k = 0; k < p->count && p->queue.first != NULL; k++) {
    worker *w = &p->workers[k];
    if (w->state != IDLE) continue;
    pool_task *t = queue_pop(&p->queue);
    if (worker_give(w, t)) continue;
    queue_push_front(&p->queue, t);
    worker_kill(w); /* it died or does not listen; its exit starts another */
  }
  if (p->room != NULL && pool_has_room(p)) p->room(p->room_self);
}

/* ---- Deadlines ---- */

static double due(void *self) {
  const pool *p = self;
  double first = INFINITY;
  for (int k = 0; k < p->count; k++) first = fmin(first, p->workers[k].until);
  return first;
}

static void run(void *self) {
  pool *p = self;
  const double now = loop_now();
  for (int k = 0; k < p->count; k++) {
    if (p->workers[k].until <= now) worker_run_out(&p->workers[k]);
  }
}

/* ---- The pool ---- */

pool *pool_new(loop *l, const parameters *set, fault *why) {
  pool *p = calloc(1, sizeof *p);
  const int count = pool_workers(set->workers);
  if (p != NULL) p->workers = calloc((size_t)count, sizeof *p->workers);
  if (p == NULL || p->workers == NULL) {
    free(p);
    fault_set(why, "out of memory");
    return NULL;
  }
  p->loop = l;
  p->set = set;
  p->count = count;
  queue_init(&p->queue);
  child_environment(set->limits.threads);
  for (int k = 0; k < count; k++) {
    worker *w = &p->workers[k];
    *w = (worker){.pool = p, .child = {.pidfd = -1, .socket = -1}};
    worker_start(w);
  }
  loop_add(l, (loop_chore){due, run, p});
  return p;
}

void pool_stop(pool *p) {
  p->stopped = true;
  for (int k = 0; k < p->count; k++) worker_end(&p->workers[k]);
  while (p->queue.first != NULL) {
    pool_task *t = queue_pop(&p->queue);
    t->calls->done(t->context, &(pool_outcome){.end = POOL_STOPPED, .fd = -1});
    free(t);
  }
}

void pool_free(pool **p) {
  if (*p == NULL) return;
  pool_stop(*p);
  free((*p)->workers);
  free(*p);
  *p = NULL;
}

static bool has_idle(const pool *p) {
  for (int k = 0; k < p->count; k++) {
    if (p->workers[k].state == IDLE) return true;
  }
  return false;
}

pool_task *pool_submit(pool *p, const ipc_ask *ask, int body, const pool_calls *calls,
                       void *context) {
  if (p->stopped) return NULL;
  if (p->queue.count >= p->set->queue && !(p->queue.count == 0 && has_idle(p))) return NULL;
  pool_task *t = task_new(ask, body, calls, context);
  if (t == NULL) return NULL;
  queue_push(&p->queue, t);
  pool_dispatch(p);
  return t;
}

/* Workers that may run jobs at the same time: one is kept for who waits. */
static int most_jobs(const pool *p) {
  return p->count > 1 ? p->count - 1 : 1;
}

bool pool_has_room(const pool *p) {
  return !p->stopped && p->queue.first == NULL && p->jobs < most_jobs(p) && has_idle(p);
}

/* The checkpoint follows its ask at once. */
static bool send_checkpoint(worker *w, const pool_task *t, int fd) {
  const ipc_given given = {.status = 200, .size = t->ask.checkpoint};
  return t->ask.checkpoint == 0 || worker_send(w, &given, sizeof given, fd);
}

pool_task *pool_start(pool *p, const ipc_ask *ask, int body, int checkpoint,
                      const pool_calls *calls, void *context) {
  if (!pool_has_room(p)) return NULL;
  worker *w = p->workers;
  while (w->state != IDLE) w++;
  pool_task *t = task_new(ask, body, calls, context);
  if (t == NULL) return NULL;
  t->is_job = true;
  if (worker_give(w, t) && send_checkpoint(w, t, checkpoint)) return t;
  if (w->task != NULL) (void)worker_release(w);
  worker_kill(w);
  free(t);
  return NULL;
}

void *pool_context(const pool_task *task) {
  return task->context;
}

const char *pool_owner(const pool_task *task) {
  return task->ask.owner;
}

void pool_on_room(pool *p, void (*room)(void *self), void *self) {
  p->room = room;
  p->room_self = self;
}

void pool_on_values(pool *p, const pool_values *values) {
  p->values = *values;
}

void pool_give(pool *p, pool_task *task, const ipc_given *given, int fd) {
  task->wishes = false;
  for (int k = 0; k < p->count; k++) {
    worker *w = &p->workers[k];
    if (w->task == task && !worker_send(w, given, sizeof *given, fd)) worker_kill(w);
  }
}

void pool_cancel(pool *p, pool_task *task) {
  for (int k = 0; k < p->count; k++) {
    worker *w = &p->workers[k];
    if (w->task != task) continue;
    task_enter_phase(task, "", loop_now());
    counter_add(COUNTER_CANCELLED, 1, LABELS(task->ask.process));
    (void)worker_release(w);
    w->planned = true;
    worker_kill(w);
    free(task);
    return;
  }
  queue_remove(&p->queue, task);
  free(task);
}

int pool_ready(const pool *p) {
  int count = 0;
  for (int k = 0; k < p->count; k++) {
    count += p->workers[k].state == IDLE || p->workers[k].state == BUSY;
  }
  return count;
}

int pool_waiting(const pool *p) {
  return p->queue.count;
}

void pool_states(const pool *p, int count[POOL_STATES]) {
  memset(count, 0, POOL_STATES * sizeof *count);
  for (int k = 0; k < p->count; k++) count[p->workers[k].state]++;
}

const char *pool_state_name(int k) {
  static const char *const names[POOL_STATES] = {[ABSENT] = "absent",
                                                 [STARTING] = "starting",
                                                 [IDLE] = "idle",
                                                 [BUSY] = "busy",
                                                 [ENDING] = "ending"};
  return names[k];
}

int pool_count(const pool *p) {
  return p->count;
}

pid_t pool_pid(const pool *p, int k) {
  return p->workers[k].child.pid;
}

int pool_tasks(const pool *p) {
  int count = p->queue.count;
  for (int k = 0; k < p->count; k++) count += p->workers[k].task != NULL;
  return count;
}

static bool is_execution_of(const pool_task *t, const char *owner) {
  return t != NULL && t->ask.work != IPC_RUN_STORED && t->ask.work != IPC_RENDER &&
         strcmp(t->ask.owner, owner) == 0;
}

int pool_tasks_of(const pool *p, const char *owner) {
  int count = 0;
  for (int k = 0; k < p->count; k++) count += is_execution_of(p->workers[k].task, owner);
  for (const pool_task *t = p->queue.first; t != NULL; t = t->next)
    count += is_execution_of(t, owner);
  return count;
}

int pool_retry_after(const pool *p) {
  const double seconds = p->mean * (p->queue.count + 1) / p->count;
  return (int)ceil(fmin(retry_most, fmax(1, seconds)));
}
