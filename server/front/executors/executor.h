/* executor.h - where jobs run that are too large for a worker: mpiexec on this machine, or Slurm.
 *
 * A run is a directory with the request in it (run_dir.h), and the same program started on it by
 * other means than the pool's. What becomes of it is told as the pool tells it. Nothing here waits:
 * other programs are children that the event loop watches, directories are looked at now and then.
 * Tests: http.executor_mpi, http.executor_slurm
 */
#ifndef SCATTERD_EXECUTOR_H
#define SCATTERD_EXECUTOR_H

#include "loop.h"
#include "param.h"
#include "pool.h"

typedef struct executor executor;
typedef struct executor_run executor_run;

/* The one that set->executor names; `local` takes no jobs. NULL with *why, also where the programs
 * it needs are missing. Brings set->limits.ranks to what will be. */
executor *executor_new(loop *l, parameters *set, fault *why);

/* Ends runs with POOL_STOPPED; those of Slurm go on, and are found again by executor_find. */
void executor_stop(executor *x);
void executor_free(executor **x);

/* Is a job for it? */
bool executor_takes(const executor *x, const char *process, int64_t points);

/* Does what it runs use this machine's memory? */
bool executor_is_here(const executor *x);

bool executor_has_room(const executor *x);
void executor_on_room(executor *x, void (*room)(void *self), void *self);

/* Starts a run called `name`, the job's id; body and checkpoint (-1: none) are read before it
 * returns. `calls` as those of a pool task, with IPC_READY when it has begun to run. NULL with
 * errno. */
executor_run *executor_start(executor *x, const char *name, const ipc_ask *ask, int body,
                             int checkpoint, const pool_calls *calls, void *context);

/* A run of that name that an earlier daemon left and that goes on; NULL if there is none. */
executor_run *executor_find(executor *x, const char *name, const pool_calls *calls, void *context);

/* Ends a run, within a second; nothing of `calls` is called any more. */
void executor_cancel(executor_run *r);

/* Where it runs, for people: "Slurm job 17"; "" if there is nothing to say. */
const char *executor_place(const executor_run *r);

/* Removes what is left of runs that are not wanted, and ends them if they go on. */
void executor_sweep(executor *x, bool (*wanted)(void *context, const char *name), void *context);

int executor_runs(const executor *x); /* how many there are */

#endif
