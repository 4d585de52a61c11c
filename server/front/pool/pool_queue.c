#include "pool_queue.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "counter.h"

/* ---- Tasks ---- */

pool_task *task_new(const ipc_ask *ask, int body, const pool_calls *calls, void *context) {
  pool_task *t = calloc(1, sizeof *t);
  if (t == NULL) return NULL;
  t->ask = *ask;
  t->body = body;
  t->submitted = loop_now();
  t->saved = -INFINITY;
  t->calls = calls;
  t->context = context;
  return t;
}

void task_enter_phase(pool_task *t, const char *phase, double when) {
  if (*t->phase != '\0') counter_add(COUNTER_PHASE_SECONDS, when - t->entered, LABELS(t->phase));
  if (*phase != '\0') snprintf(t->phase, sizeof t->phase, "%s", phase);
  t->entered = *phase != '\0' ? when : INFINITY; /* nothing to add after the last */
}

void pool_count_run(const char *process, ipc_work what, const pool_outcome *outcome) {
  static const char *const ends[] = {
      [POOL_REPLY] = "reply", [POOL_MEMORY] = "memory",   [POOL_TIME] = "time",
      [POOL_CRASH] = "crash", [POOL_STOPPED] = "stopped", [POOL_ELSEWHERE] = "elsewhere"};
  static const char *const works[] = {
      [IPC_RUN] = "run", [IPC_RUN_STORED] = "job", [IPC_CHECK] = "check", [IPC_RENDER] = "render"};
  const char *id = *process != '\0' ? process : "any", *work = works[what];
  counter_add(COUNTER_RUNS, 1, LABELS(id, work, ends[outcome->end]));
  counter_observe(COUNTER_RUN_SECONDS, outcome->seconds, LABELS(id, work));
}

void task_end(pool_task *t, pool_outcome *outcome) {
  task_enter_phase(t, "", loop_now());
  pool_count_run(t->ask.process, t->ask.work, outcome);
  memcpy(outcome->phase, t->phase, sizeof t->phase);
  t->calls->done(t->context, outcome);
  free(t);
}

/* ---- The queue ---- */

void queue_init(pool_queue *q) {
  *q = (pool_queue){.last = &q->first};
}

pool_task *queue_pop(pool_queue *q) {
  pool_task *t = q->first;
  q->first = t->next;
  if (q->first == NULL) q->last = &q->first;
  q->count--;
  return t;
}

void queue_push(pool_queue *q, pool_task *t) {
  t->next = NULL;
  *q->last = t;
  q->last = &t->next;
  q->count++;
}

void queue_push_front(pool_queue *q, pool_task *t) {
  t->next = q->first;
  q->first = t;
  if (t->next == NULL) q->last = &t->next;
  q->count++;
}

void queue_remove(pool_queue *q, pool_task *t) {
  for (pool_task **at = &q->first; *at != NULL; at = &(*at)->next) {
    if (*at != t) continue;
    *at = t->next;
    if (t->next == NULL) q->last = at;
    q->count--;
    return;
  }
}
