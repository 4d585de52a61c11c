#include "pool.h"

#include <errno.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/stat.h>
#include <unistd.h>

#include "child.h"
#include "counter.h"
#include "log.h"

static const double start_seconds = 30;    /* for a worker to come up */
static const double end_seconds = 5;       /* for a worker to go when told */
static const double first_delay = 0.1;     /* after a worker died without serving anything */
static const double longest_delay = 5;     /* the delay doubles up to here */
static const double retry_most = 60;       /* of Retry-After */
static const double memory_of_mean = 0.05; /* weight of the newest request in the mean time */

struct pool_task {
  pool_task *next; /* in the queue */
  ipc_ask ask;
  int body;
  const pool_calls *calls;
  void *context;
  bool is_job;
  double submitted, started; /* loop_now; at which a worker got it */
  char phase[32];
  double entered; /* loop_now at which the phase began */
};

typedef enum { ABSENT, STARTING, IDLE, BUSY, ENDING } state;

typedef struct {
  pool *pool;
  state state;
  double until; /* ABSENT: when to start it; STARTING, BUSY, ENDING: when patience ends */
  child child;
  loop_source exited, spoke;
  pool_task *task; /* BUSY */
  int64_t served;  /* requests, in this life */
  int failures;    /* lives in a row that served nothing */
  bool planned;    /* its end is */
} worker;

struct pool {
  loop *loop;
  const parameters *set;
  int count;
  worker *workers;
  pool_task *first, **last; /* queue */
  int waiting;
  bool stopped;
  double mean; /* seconds of a request, weighted towards the recent ones */
  int jobs;    /* workers busy with one */
  void (*room)(void *self);
  void *room_self;
  pool_values values;
};

int pool_workers(int64_t parameter) {
  if (parameter > 0) return (int)parameter;
  const long processors = sysconf(_SC_NPROCESSORS_ONLN);
  return processors < 2 ? 2 : (int)processors;
}

/* ---- Tasks ---- */

static pool_task *queue_pop(pool *p) {
  pool_task *t = p->first;
  p->first = t->next;
  if (p->first == NULL) p->last = &p->first;
  p->waiting--;
  return t;
}

static void queue_push(pool *p, pool_task *t) {
  t->next = NULL;
  *p->last = t;
  p->last = &t->next;
  p->waiting++;
}

static void queue_push_front(pool *p, pool_task *t) {
  t->next = p->first;
  p->first = t;
  if (t->next == NULL) p->last = &t->next;
  p->waiting++;
}

static void queue_remove(pool *p, pool_task *t) {
  for (pool_task **at = &p->first; *at != NULL; at = &(*at)->next) {
    if (*at != t) continue;
    *at = t->next;
    if (t->next == NULL) p->last = at;
    p->waiting--;
    return;
  }
}

/* The phase so far ends at a time, for the counters; another begins unless `phase` is "". */
static void enter_phase(pool_task *t, const char *phase, double when) {
  if (*t->phase != '\0') counter_add(COUNTER_PHASE_SECONDS, when - t->entered, LABELS(t->phase));
  if (*phase != '\0') snprintf(t->phase, sizeof t->phase, "%s", phase);
  t->entered = *phase != '\0' ? when : INFINITY; /* nothing to add after the last */
}

static void count_end(pool_task *t, const pool_outcome *outcome) {
  static const char *const ends[] = {[POOL_REPLY] = "reply",
                                     [POOL_MEMORY] = "memory",
                                     [POOL_TIME] = "time",
                                     [POOL_CRASH] = "crash",
                                     [POOL_STOPPED] = "stopped"};
  static const char *const works[] = {
      [IPC_RUN] = "run", [IPC_RUN_STORED] = "job", [IPC_CHECK] = "check", [IPC_RENDER] = "render"};
  const char *id = *t->ask.process != '\0' ? t->ask.process : "any", *work = works[t->ask.work];
  enter_phase(t, "", loop_now());
  counter_add(COUNTER_RUNS, 1, LABELS(id, work, ends[outcome->end]));
  counter_observe(COUNTER_RUN_SECONDS, outcome->seconds, LABELS(id, work));
}

/* Takes the task off a worker. */
static pool_task *release(worker *w) {
  pool *p = w->pool;
  pool_task *t = w->task;
  w->task = NULL;
  p->jobs -= t->is_job;
  if (p->values.ended != NULL) p->values.ended(p->values.self, t);
  return t;
}

/* Ends the task of a worker. */
static void finish(worker *w, pool_outcome *outcome) {
  pool_task *t = release(w);
  outcome->worker = w->child.pid;
  outcome->seconds = loop_now() - t->started;
  count_end(t, outcome);
  memcpy(outcome->phase, t->phase, sizeof t->phase);
  if (!t->is_job) w->pool->mean += memory_of_mean * (outcome->seconds - w->pool->mean);
  t->calls->done(t->context, outcome);
  free(t);
}

static void finish_without_reply(worker *w, pool_end end) {
  pool_outcome outcome = {.end = end, .fd = -1};
  if (w->task != NULL) finish(w, &outcome);
}

/* ---- Life of a worker ---- */

static void become(worker *w, state s, double seconds) {
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
  become(w, ENDING, end_seconds);
}

static void kill_worker(worker *w) {
  child_kill(&w->child);
  close_socket(w);
  become(w, ENDING, end_seconds);
}

/* After a life that served nothing: the delay grows, so that a worker that cannot live costs
 * little. */
static void start_later(worker *w) {
  become(w, ABSENT, fmin(longest_delay, first_delay * ldexp(1, w->failures++)));
}

static bool watch(worker *w) {
  return loop_watch(w->pool->loop, w->child.pidfd, EPOLLIN, &w->exited) &&
         loop_watch(w->pool->loop, w->child.socket, EPOLLIN, &w->spoke);
}

static void start(worker *w) {
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
  become(w, STARTING, start_seconds);
}

/* ---- Giving out work ---- */

static bool hand_over(worker *w, pool_task *t) {
  t->started = loop_now(); /* before, as the worker may be done when the send returns */
  if (!ipc_send(w->child.socket, &t->ask, sizeof t->ask, t->body)) return false;
  counter_observe(COUNTER_WAIT_SECONDS, t->started - t->submitted, NO_LABELS);
  w->task = t;
  w->pool->jobs += t->is_job;
  become(w, BUSY, t->ask.limits.seconds);
  return true;
}

static void dispatch(pool *p) {
  for (int k = 0; k < p->count && p->first != NULL; k++) {
    worker *w = &p->workers[k];
    if (w->state != IDLE) continue;
    pool_task *t = queue_pop(p);
    if (hand_over(w, t)) continue;
    queue_push_front(p, t);
    kill_worker(w); /* it died or does not listen; its exit starts another */
  }
  if (p->room != NULL && pool_has_room(p)) p->room(p->room_self);
}

static void become_idle(worker *w) {
  w->state = IDLE;
  w->until = INFINITY;
  if (w->served >= w->pool->set->recycle) dismiss(w);
}

/* ---- What workers say ---- */

static bool has_bytes(int fd, int64_t size) {
  struct stat facts;
  return fd >= 0 && size >= 0 && fstat(fd, &facts) == 0 && facts.st_size >= size;
}

/* A reply came. False if it is not one. */
static bool take_reply(worker *w, const ipc_news *news, int fd) {
  pool_outcome outcome = {.end = POOL_MEMORY, .fd = -1};
  if (w->state != BUSY) return false;
  if (news->status != 0) {
    if (!has_bytes(fd, news->size) || news->coding >= CODING_COUNT) return false;
    outcome = (pool_outcome){.end = POOL_REPLY,
                             .status = news->status,
                             .coding = news->coding,
                             .fd = fd,
                             .size = (size_t)news->size,
                             .points = news->points,
                             .memory_bytes = news->memory_bytes};
    memcpy(outcome.type, news->type, sizeof outcome.type - 1);
    memcpy(outcome.detail, news->detail, sizeof outcome.detail - 1);
  } else if (fd >= 0) {
    return false;
  }
  w->served++;
  w->failures = 0;
  enter_phase(w->task, "", news->time);
  finish(w, &outcome);
  become_idle(w);
  return true;
}

static bool take_ready(worker *w, const ipc_news *news, int fd) {
  (void)news;
  if (fd >= 0 || w->state != STARTING) return false;
  become_idle(w);
  return true;
}

static bool take_progress(worker *w, const ipc_news *news, int fd) {
  pool_task *t = w->task;
  if (fd >= 0 || w->state != BUSY) return false;
  enter_phase(t, news->phase, news->time);
  if (t->calls->heard != NULL) t->calls->heard(t->context, news, -1);
  return true;
}

static bool take_checkpoint(worker *w, const ipc_news *news, int fd) {
  pool_task *t = w->task;
  if (w->state != BUSY || !has_bytes(fd, news->size)) return false;
  if (t->calls->heard != NULL) {
    t->calls->heard(t->context, news, fd);
  } else {
    close(fd);
  }
  return true;
}

static bool take_wish(worker *w, const ipc_news *news, int fd) {
  static const ipc_given nobody = {.status = 400, .detail = "values by reference are not served"};
  const pool_values *v = &w->pool->values;
  if (w->state != BUSY || (news->kind == IPC_KEEP) != (fd >= 0)) return false;
  if (fd >= 0 && !has_bytes(fd, news->size)) return false;
  if (v->wanted != NULL) {
    v->wanted(v->self, w->task, news, fd);
  } else {
    if (fd >= 0) close(fd);
    pool_give(w->pool, w->task, &nobody, -1);
  }
  return true;
}

/* What comes is acted upon, or false: it makes no sense now. */
static bool (*const takes[])(worker *w, const ipc_news *news, int fd) = {
    [IPC_READY] = take_ready, [IPC_PROGRESS] = take_progress, [IPC_CHECKPOINT] = take_checkpoint,
    [IPC_FETCH] = take_wish,  [IPC_KEEP] = take_wish,         [IPC_REPLY] = take_reply,
};

static bool take(worker *w, ipc_news *news, int fd) {
  if ((size_t)news->kind >= sizeof takes / sizeof *takes) return false;
  news->phase[sizeof news->phase - 1] = '\0';
  news->href[sizeof news->href - 1] = '\0';
  news->type[sizeof news->type - 1] = '\0';
  return takes[news->kind](w, news, fd);
}

/* Reads all that a worker said. One that talks nonsense is killed. */
static void listen_to(worker *w) {
  ipc_news news;
  int fd;
  while (w->child.socket >= 0) {
    const ipc_result result = ipc_receive(w->child.socket, &news, sizeof news, &fd);
    if (result == IPC_NOTHING) return;
    if (result == IPC_MESSAGE && take(w, &news, fd)) continue;
    if (result == IPC_MESSAGE && fd >= 0) close(fd);
    kill_worker(w); /* gone, or to be; on_exited does the rest */
  }
}

static void on_spoke(void *self, uint32_t events) {
  worker *w = self;
  (void)events;
  listen_to(w);
  dispatch(w->pool);
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
  listen_to(w); /* a reply may have come just before the end */
  finish_without_reply(w, POOL_CRASH);
  const pid_t pid = w->child.pid;
  reap(w, &how);
  log_exit(w, pid, &how);
  if (w->planned || w->served > 0) {
    start(w);
  } else {
    start_later(w);
  }
}

/* ---- Deadlines ---- */

static double due(void *self) {
  const pool *p = self;
  double first = INFINITY;
  for (int k = 0; k < p->count; k++) first = fmin(first, p->workers[k].until);
  return first;
}

static void run_out(worker *w) {
  if (w->state == ABSENT) {
    start(w);
    return;
  }
  if (w->state == BUSY) w->planned = true;
  finish_without_reply(w, POOL_TIME);
  kill_worker(w);
}

static void run(void *self) {
  pool *p = self;
  const double now = loop_now();
  for (int k = 0; k < p->count; k++) {
    if (p->workers[k].until <= now) run_out(&p->workers[k]);
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
  p->last = &p->first;
  child_environment(set->limits.threads);
  for (int k = 0; k < count; k++) {
    worker *w = &p->workers[k];
    *w = (worker){.pool = p, .child = {.pidfd = -1, .socket = -1}};
    w->exited = (loop_source){on_exited, w};
    w->spoke = (loop_source){on_spoke, w};
    start(w);
  }
  loop_add(l, (loop_chore){due, run, p});
  return p;
}

static void end_worker(worker *w) {
  siginfo_t how;
  child_kill(&w->child);
  finish_without_reply(w, POOL_STOPPED);
  reap(w, &how);
  w->state = ABSENT;
  w->until = INFINITY;
}

void pool_stop(pool *p) {
  p->stopped = true;
  for (int k = 0; k < p->count; k++) end_worker(&p->workers[k]);
  while (p->first != NULL) {
    pool_task *t = queue_pop(p);
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

static pool_task *task_new(const ipc_ask *ask, int body, const pool_calls *calls, void *context) {
  pool_task *t = calloc(1, sizeof *t);
  if (t == NULL) return NULL;
  t->ask = *ask;
  t->body = body;
  t->submitted = loop_now();
  t->calls = calls;
  t->context = context;
  return t;
}

pool_task *pool_submit(pool *p, const ipc_ask *ask, int body, const pool_calls *calls,
                       void *context) {
  if (p->stopped) return NULL;
  if (p->waiting >= p->set->queue && !(p->waiting == 0 && has_idle(p))) return NULL;
  pool_task *t = task_new(ask, body, calls, context);
  if (t == NULL) return NULL;
  queue_push(p, t);
  dispatch(p);
  return t;
}

/* Workers that may run jobs at the same time: one is kept for who waits. */
static int most_jobs(const pool *p) {
  return p->count > 1 ? p->count - 1 : 1;
}

bool pool_has_room(const pool *p) {
  return !p->stopped && p->first == NULL && p->jobs < most_jobs(p) && has_idle(p);
}

/* The checkpoint follows its ask at once. */
static bool send_checkpoint(worker *w, const pool_task *t, int fd) {
  const ipc_given given = {.status = 200, .size = t->ask.checkpoint};
  return t->ask.checkpoint == 0 || ipc_send(w->child.socket, &given, sizeof given, fd);
}

pool_task *pool_start(pool *p, const ipc_ask *ask, int body, int checkpoint,
                      const pool_calls *calls, void *context) {
  if (!pool_has_room(p)) return NULL;
  worker *w = p->workers;
  while (w->state != IDLE) w++;
  pool_task *t = task_new(ask, body, calls, context);
  if (t == NULL) return NULL;
  t->is_job = true;
  if (hand_over(w, t) && send_checkpoint(w, t, checkpoint)) return t;
  if (w->task != NULL) (void)release(w);
  kill_worker(w);
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
  for (int k = 0; k < p->count; k++) {
    worker *w = &p->workers[k];
    if (w->task == task && !ipc_send(w->child.socket, given, sizeof *given, fd)) kill_worker(w);
  }
}

void pool_cancel(pool *p, pool_task *task) {
  for (int k = 0; k < p->count; k++) {
    worker *w = &p->workers[k];
    if (w->task != task) continue;
    enter_phase(task, "", loop_now());
    counter_add(COUNTER_CANCELLED, 1, LABELS(task->ask.process));
    (void)release(w);
    w->planned = true;
    kill_worker(w);
    free(task);
    return;
  }
  queue_remove(p, task);
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
  return p->waiting;
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
  int count = p->waiting;
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
  for (const pool_task *t = p->first; t != NULL; t = t->next) count += is_execution_of(t, owner);
  return count;
}

int pool_retry_after(const pool *p) {
  const double seconds = p->mean * (p->waiting + 1) / p->count;
  return (int)ceil(fmin(retry_most, fmax(1, seconds)));
}
