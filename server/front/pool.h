/* pool.h - worker processes: starts them, gives them requests, watches and kills them.
 *
 * A worker takes one request at a time. One that crashes, is killed for time or has served its
 * number of requests is replaced; one that dies before it served anything is started again with a
 * growing delay. Requests that find no free worker wait in order of arrival.
 * Test: http.faults.
 */
#ifndef SCATTERD_POOL_H
#define SCATTERD_POOL_H

#include <sys/types.h>

#include "fault.h"
#include "ipc.h"
#include "loop.h"
#include "param.h"

typedef struct pool pool;
typedef struct pool_task pool_task; /* a request that waits or runs */

typedef enum {
  POOL_REPLY,   /* the worker answered */
  POOL_MEMORY,  /* it ran out of memory */
  POOL_TIME,    /* killed: limits.seconds passed */
  POOL_CRASH,   /* it died */
  POOL_STOPPED, /* the pool was closed */
} pool_end;

typedef struct {
  pool_end end;
  int status;     /* REPLY: HTTP status */
  char type[64];  /* REPLY: media type */
  coding coding;  /* REPLY */
  int fd;         /* REPLY: the bytes, the receiver's to close; else -1 */
  size_t size;    /* REPLY: bytes, present in fd */
  int64_t points; /* REPLY: of the cloud, 0 if there was none */
  pid_t worker;   /* 0 if none had it yet */
  double seconds; /* on the worker */
  char phase[32]; /* last reported, "" if none */
} pool_outcome;

typedef void pool_done(void *context, const pool_outcome *outcome);

/* Starts set->workers processes (see pool_workers); they say pool_ready when they are up. */
pool *pool_new(loop *l, const parameters *set, fault *why);

/* Kills all workers and ends all tasks with POOL_STOPPED; none is taken after it. */
void pool_stop(pool *p);
void pool_free(pool **p);

/* Hands a request in; `body` is a descriptor (or -1) that stays open until the task ends. `done` is
 * called once, later, from the loop. NULL when the queue is full or out of memory. */
pool_task *pool_submit(pool *p, const ipc_ask *ask, int body, pool_done *done, void *context);

/* Forgets a task, killing the worker if it runs; `done` is not called. */
void pool_cancel(pool *p, pool_task *task);

int pool_ready(const pool *p);       /* workers up, idle or busy */
int pool_waiting(const pool *p);     /* tasks waiting */
int pool_tasks(const pool *p);       /* tasks waiting or running */
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
