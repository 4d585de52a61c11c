/* one_process.c - in place of pool.c: the worker's code within the front, one request a round of
 * the loop, so that a fuzzer sees what both do with one request. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "answer.h"
#include "pool.h"

enum { TASKS_MAX = 8, REPORTS = 3000 };

struct pool_task {
  pool_task *next;
  ipc_ask ask;
  int body;
  const pool_calls *calls;
  void *context;
};

struct pool {
  pool_task *first;
  void (*room)(void *self);
  void *room_self;
};

static pool only;

/* Nobody waits for long. */
static bool report(void *context, const char *phase, double fraction) {
  int *left = context;
  (void)fraction;
  return strcmp(phase, "pause") != 0 && --*left > 0;
}

static void fetch(void *context, const char *href, ask_fetched *out) {
  (void)context, (void)href;
  *out = (ask_fetched){.status = 404, .detail = "there is nothing"};
}

static void release(void *context, ask_fetched *out) {
  (void)context, (void)out;
}

/* The body, exactly sized. */
static uint8_t *read_body(const pool_task *t) {
  uint8_t *bytes = malloc(t->ask.size > 0 ? (size_t)t->ask.size : 1);
  if (bytes == NULL) abort();
  if (t->ask.size > 0 && pread(t->body, bytes, (size_t)t->ask.size, 0) != t->ask.size) abort();
  return bytes;
}

static reply answer_to(const pool_task *t) {
  int left = REPORTS;
  uint8_t *body = read_body(t);
  const ask a = {.work = t->ask.work,
                 .process = t->ask.process,
                 .output = t->ask.output,
                 .results_url = t->ask.results_url,
                 .body = body,
                 .size = (size_t)t->ask.size,
                 .content = t->ask.content,
                 .content_coding = t->ask.content_coding,
                 .accept = t->ask.accept,
                 .accept_coding = t->ask.accept_coding,
                 .limits = &t->ask.limits,
                 .calls = {&left, report, NULL, fetch, release, NULL, NULL}};
  reply r;
  answer(&a, &r);
  free(body);
  return r;
}

static pool_outcome outcome_of(const reply *r) {
  pool_outcome o = {.end = r->bytes != NULL ? POOL_REPLY : POOL_MEMORY,
                    .status = r->status,
                    .coding = r->coding,
                    .fd = -1,
                    .points = r->points,
                    .memory_bytes = r->memory_bytes};
  memcpy(o.type, r->type, sizeof o.type);
  memcpy(o.detail, r->detail, sizeof o.detail);
  if (r->bytes == NULL) return o;
  o.size = r->size;
  o.fd = memfd_create("reply", MFD_CLOEXEC);
  if (o.fd < 0 || pwrite(o.fd, r->bytes, r->size, 0) != (ssize_t)r->size) abort();
  return o;
}

static double due(void *self) {
  const pool *p = self;
  return p->first != NULL ? 0 : INFINITY;
}

static void run(void *self) {
  pool *p = self;
  pool_task *t = p->first;
  reply r = answer_to(t);
  const pool_outcome o = outcome_of(&r);
  free(r.bytes);
  p->first = t->next;
  t->calls->done(t->context, &o);
  free(t);
  if (p->room != NULL) p->room(p->room_self);
}

pool *pool_new(loop *l, const parameters *set, fault *why) {
  (void)set, (void)why;
  loop_add(l, (loop_chore){due, run, &only});
  return &only;
}

void pool_stop(pool *p) {
  (void)p;
}

void pool_free(pool **p) {
  *p = NULL;
}

pool_task *pool_submit(pool *p, const ipc_ask *what, int body, const pool_calls *calls,
                       void *context) {
  if (pool_tasks(p) >= TASKS_MAX) return NULL;
  pool_task *t = calloc(1, sizeof *t), **end = &p->first;
  if (t == NULL) return NULL;
  *t = (pool_task){.ask = *what, .body = body, .calls = calls, .context = context};
  while (*end != NULL) end = &(*end)->next;
  return *end = t;
}

pool_task *pool_start(pool *p, const ipc_ask *what, int body, int checkpoint,
                      const pool_calls *calls, void *context) {
  (void)checkpoint;
  return pool_submit(p, what, body, calls, context);
}

bool pool_has_room(const pool *p) {
  return p->first == NULL;
}

void pool_cancel(pool *p, pool_task *task) {
  for (pool_task **at = &p->first; *at != NULL; at = &(*at)->next) {
    if (*at != task) continue;
    *at = task->next;
    free(task);
    return;
  }
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
  (void)p, (void)values;
}

void pool_give(pool *p, pool_task *task, const ipc_given *given, int fd) {
  (void)p, (void)task, (void)given, (void)fd;
}

int pool_tasks(const pool *p) {
  int count = 0;
  for (const pool_task *t = p->first; t != NULL; t = t->next) count++;
  return count;
}

/* There is one owner, nobody. */
int pool_tasks_of(const pool *p, const char *owner) {
  int count = 0;
  for (const pool_task *t = p->first; t != NULL; t = t->next) {
    count += strcmp(t->ask.owner, owner) == 0;
  }
  return count;
}

int pool_waiting(const pool *p) {
  return pool_tasks(p);
}

int pool_ready(const pool *p) {
  return p->first == NULL;
}

int pool_retry_after(const pool *p) {
  (void)p;
  return 1;
}

void pool_states(const pool *p, int count[POOL_STATES]) {
  (void)p;
  memset(count, 0, POOL_STATES * sizeof *count);
}

const char *pool_state_name(int k) {
  (void)k;
  return "idle";
}

int pool_count(const pool *p) {
  (void)p;
  return 0;
}

pid_t pool_pid(const pool *p, int k) {
  (void)p, (void)k;
  return 0;
}

int pool_workers(int64_t parameter) {
  (void)parameter;
  return 1;
}
