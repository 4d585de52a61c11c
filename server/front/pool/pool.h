/* pool.h - worker processes: starts them, gives them requests, watches and kills them.
 *
 * A worker takes one request at a time. One that crashes, is killed for time or has served its
 * number of requests is replaced; one that dies before it served anything is started again with a
 * growing delay. Requests that find no free worker wait in order of arrival. Jobs do not wait here:
 * pool_start takes one only when a worker is free for it, and all workers but one may run jobs, so
 * that requests somebody waits for find one soon. Test: http.faults, http.jobs.
 */
#ifndef SCATTERD_POOL_H
#define SCATTERD_POOL_H

#include <stdbool.h>
#include <sys/types.h>

#include "fault.h"
#include "ipc.h"
#include "loop.h"
#include "param.h"

typedef struct pool pool;
typedef struct pool_task pool_task; /* a request that waits or runs */

typedef enum {
  POOL_REPLY,     /* the worker answered */
  POOL_MEMORY,    /* it ran out of memory */
  POOL_TIME,      /* killed: limits.seconds passed */
  POOL_CRASH,     /* it died */
  POOL_STOPPED,   /* the pool was closed */
  POOL_ELSEWHERE, /* of an executor: only a worker can run it */
} pool_end;

typedef struct {
  pool_end end;
  int status;           /* REPLY: HTTP status */
  char type[128];       /* REPLY: media type */
  coding coding;        /* REPLY */
  int fd;               /* REPLY: the bytes, the receiver's to close; else -1 */
  size_t size;          /* REPLY: bytes, present in fd */
  int64_t points;       /* REPLY: of the cloud, 0 if there was none */
  int64_t memory_bytes; /* REPLY: estimated peak, 0 if unknown */
  char detail[200];     /* REPLY: of a problem, as far as it fits */
  pid_t worker;         /* 0 if none had it yet */
  double seconds;       /* on the worker */
  char phase[32];       /* last reported, "" if none */
} pool_outcome;

typedef struct {
  /* Called once, from the loop. */
  void (*done)(void *context, const pool_outcome *outcome);
  /* PROGRESS and CHECKPOINT (with its descriptor, the receiver's to close); NULL: nobody cares. */
  void (*heard)(void *context, const ipc_news *news, int fd);
} pool_calls;

/* Who answers IPC_FETCH and IPC_KEEP. */
typedef struct {
  void *self;
  /* The worker waits until pool_give; fd is the receiver's to close. */
  void (*wanted)(void *self, pool_task *t, const ipc_news *news, int fd);
  /* The task ends: what it wanted is wanted no more. */
  void (*ended)(void *self, pool_task *t);
} pool_values;

/* Starts set->workers processes (see pool_workers); they say pool_ready when they are up. */
pool *pool_new(loop *l, const parameters *set, fault *why);

/* Kills all workers and ends all tasks with POOL_STOPPED; none is taken after it. */
void pool_stop(pool *p);
void pool_free(pool **p);

/* Hands a request in; `body` is a descriptor (or -1) that stays open until the task ends. `calls`
 * lives as long. It may take ask->limits.seconds. NULL when the queue is full or out of memory. */
pool_task *pool_submit(pool *p, const ipc_ask *ask, int body, const pool_calls *calls,
                       void *context);

/* Starts a job, with its checkpoint if that is not -1. NULL when there is no room for it. */
pool_task *pool_start(pool *p, const ipc_ask *ask, int body, int checkpoint,
                      const pool_calls *calls, void *context);

/* Is there room for a job? */
bool pool_has_room(const pool *p);

/* Forgets a task, killing the worker if it runs; nothing of `calls` is called any more. */
void pool_cancel(pool *p, pool_task *task);

/* What the owner of a task knows it by. */
void *pool_context(const pool_task *task);

/* Whose values a task may refer to: ask->owner. */
const char *pool_owner(const pool_task *task);

/* Who is called when there may be room for a job. */
void pool_on_room(pool *p, void (*room)(void *self), void *self);

/* Who is asked for values; without anybody they are refused. */
void pool_on_values(pool *p, const pool_values *values);

/* Answers what a task wanted; fd (-1: none) stays the caller's. */
void pool_give(pool *p, pool_task *task, const ipc_given *given, int fd);

int pool_ready(const pool *p);                       /* workers up, idle or busy */
int pool_waiting(const pool *p);                     /* tasks waiting */
int pool_tasks(const pool *p);                       /* tasks waiting or running */
int pool_tasks_of(const pool *p, const char *owner); /* of these, executions that are no jobs */
int pool_retry_after(const pool *p); /* seconds after which the queue may have room, >= 1 */

/* How many workers are in each state of README.md; a state's name. */
enum { POOL_STATES = 5 };
void pool_states(const pool *p, int count[POOL_STATES]);
const char *pool_state_name(int k);

int pool_count(const pool *p);        /* workers, in whatever state */
pid_t pool_pid(const pool *p, int k); /* of worker k; 0 or less: it is not there */

/* Number of workers that a parameter value means: 0 is one per processor, at least 2. */
int pool_workers(int64_t parameter);

#endif
