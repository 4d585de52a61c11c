/* pool_queue.h - requests of the pool: what is known of one, and the queue of those that wait.
 */
#ifndef SCATTERD_POOL_QUEUE_H
#define SCATTERD_POOL_QUEUE_H

#include "pool.h"

struct pool_task {
  pool_task *next; /* in the queue */
  ipc_ask ask;
  int body;
  const pool_calls *calls;
  void *context;
  bool is_job;
  bool wishes;               /* its worker waits for an ipc_given */
  double saved;              /* loop_now of its last checkpoint */
  double submitted, started; /* loop_now; at which a worker got it */
  char phase[32];
  double entered; /* loop_now at which the phase began */
};

/* NULL when out of memory. */
pool_task *task_new(const ipc_ask *ask, int body, const pool_calls *calls, void *context);

/* The phase so far ends at a time, for the counters; another begins unless `phase` is "". */
void task_enter_phase(pool_task *t, const char *phase, double when);

/* Counts a run, for the metrics. */
void pool_count_run(const char *process, ipc_work what, const pool_outcome *outcome);

/* Counts its end, tells its owner, and frees it. */
void task_end(pool_task *t, pool_outcome *outcome);

typedef struct {
  pool_task *first, **last;
  int count;
} pool_queue;

void queue_init(pool_queue *q);
void queue_push(pool_queue *q, pool_task *t);
void queue_push_front(pool_queue *q, pool_task *t);
pool_task *queue_pop(pool_queue *q); /* not of an empty one */
void queue_remove(pool_queue *q, pool_task *t);

#endif
