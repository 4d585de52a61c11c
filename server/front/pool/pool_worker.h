/* pool_worker.h - a worker of the pool: the life of its process, and what is said with it.
 *
 * States and what leads from one to another: server/README.md, "Workers".
 */
#ifndef SCATTERD_POOL_WORKER_H
#define SCATTERD_POOL_WORKER_H

#include "child.h"
#include "pool_queue.h"

typedef enum { ABSENT, STARTING, IDLE, BUSY, ENDING } worker_state;

typedef struct {
  pool *pool;
  worker_state state;
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
  pool_queue queue;
  bool stopped;
  double mean; /* seconds of a request, weighted towards the recent ones */
  int jobs;    /* workers busy with one */
  void (*room)(void *self);
  void *room_self;
  pool_values values;
};

/* ---- pool_worker.c: its life ---- */

void worker_start(worker *w);
void worker_become(worker *w, worker_state s, double seconds); /* with patience for so long */
void worker_become_idle(worker *w);
void worker_kill(worker *w);
void worker_end(worker *w);     /* for good, its task with it */
void worker_run_out(worker *w); /* its patience has ended */

/* Takes its task off a worker: it ends, is cancelled, or goes back. */
pool_task *worker_release(worker *w);

/* Ends the task of a worker. */
void worker_finish(worker *w, pool_outcome *outcome);

/* ---- pool_talk.c: what is said ---- */

/* Sends it a message and a descriptor (-1: none), whose bytes stay what they are whatever the
 * worker does with it. False if it does not listen. */
bool worker_send(worker *w, const void *message, size_t size, int fd);

/* Gives it a task. False if it does not listen. */
bool worker_give(worker *w, pool_task *t);

/* Reads what a worker said, so many messages at most: the others have their turn, too. One that
 * talks nonsense is killed. */
void worker_listen(worker *w, int most);

/* ---- pool.c ---- */

/* Gives waiting tasks to idle workers. */
void pool_dispatch(pool *p);

#endif
