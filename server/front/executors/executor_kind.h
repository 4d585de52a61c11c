/* executor_kind.h - what executors have in common, and how they differ. */
#ifndef SCATTERD_EXECUTOR_KIND_H
#define SCATTERD_EXECUTOR_KIND_H

#include "command.h"
#include "executor.h"
#include "run_dir.h"

enum { EXECUTOR_PATH = PARAM_TEXT + 128, EXECUTOR_PLACE = 64 };

struct executor_run {
  executor_run *next;
  executor *by;
  char name[80], place[EXECUTOR_PLACE];
  char path[EXECUTOR_PATH];
  int dir;
  const pool_calls *calls; /* NULL: nobody waits for it any more */
  void *context;
  char process[IPC_NAME];
  bool has_begun;
  double started;  /* loop_now; when it was given away, then when it began */
  double deadline; /* when its time is over; INFINITY before it began */
  double limit;    /* (s) of its time */
  int64_t heard;   /* of its news */
  char phase[32];
  command *command; /* mpi: mpiexec; slurm: sbatch while it submits */
  double patience;  /* mpi: when it is killed that does not end; slurm: when to submit again, or to
                       give up what is gone */
  int64_t id;       /* slurm: of the job; 0: not known */
  int tries;        /* slurm: submissions that failed */
  bool is_sought;   /* slurm: it may have been submitted */
  unsigned asked;   /* slurm: the last question that named it */
};

typedef struct {
  const char *name;
  bool is_here, persists; /* uses this machine; runs outlive the daemon */
  int most;               /* runs at a time, unless the parameter says */
  double seconds;         /* between two looks */
  const char *programs[4];
  bool (*start)(executor_run *r); /* the directory is ready; false with errno */
  bool (*find)(executor_run *r);  /* was it given away? */
  void (*look)(executor *x);      /* now and then; NULL: nothing */
  void (*end)(executor_run *r);   /* is to end it; it calls run_remove when it has */
} executor_kind;

extern const executor_kind executor_local, executor_mpi, executor_slurm;

struct executor {
  const executor_kind *kind;
  loop *loop;
  const parameters *set;
  char program[EXECUTOR_PATH], path[EXECUTOR_PATH]; /* of scatterd, of the runs */
  int dir;
  executor_run *first;
  int count, most;
  double next;             /* look */
  command *asking;         /* slurm: squeue */
  unsigned question, turn; /* slurm: its number; that from which on all are asked for once */
  bool was_deaf;           /* slurm: it did not answer, which was logged */
  void (*room)(void *self);
  void *room_self;
};

/* ---- executor_run.c ---- */

/* A run with its directory, fresh or found. NULL with errno. */
executor_run *run_new(executor *x, const char *name, const pool_calls *calls, void *context);

/* Tells what it said since the last time; true if there is its reply. */
bool run_hear(executor_run *r);

/* It begins, if it did not yet. */
void run_begin(executor_run *r);

/* Tells how it ended: with its reply, if it left one, else with `end`. It has no owner afterwards.
 */
void run_finish(executor_run *r, pool_end end);

/* The same with a problem of the given status, in these words. */
void run_fail(executor_run *r, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Forgets it; with its directory, unless it goes on without us. */
void run_remove(executor_run *r, bool with_files);

#endif
