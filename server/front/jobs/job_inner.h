/* job_inner.h - what the files job_*.c of the life of a job share: the jobs in memory.
 */
#ifndef SCATTERD_JOB_INNER_H
#define SCATTERD_JOB_INNER_H

#include "allowance.h"
#include "job.h"
#include "job_queue.h"
#include "job_tally.h"

typedef struct {
  int64_t last; /* id */
  int count;    /* events told; the newest JOB_EVENTS of them are kept */
  job_event ring[JOB_EVENTS];
} job_events;

typedef enum { JOB_REQUEST, JOB_CHECKPOINT, JOB_RESULT, JOB_FILES } job_file;

typedef struct {
  char *bytes;
  size_t size;
} job_small;

typedef struct {
  int fd; /* 0 for none */
  size_t size;
  char draft[STORE_DRAFT]; /* where its bytes are in the store by now, "" for nowhere */
} job_large;

typedef struct job_filing job_filing; /* a file that is being written, of job_files.c */

/* What is to be said of a change that another one overtook before it was stored. */
typedef struct job_note {
  struct job_note *next;
  double when;
  char text[];
} job_note;

struct job {
  job_row row;
  jobs *all;
  queue_node node;      /* while it waits */
  pool_task *task;      /* while it runs on a worker */
  executor_run *run;    /* while the executor has it, which may let it wait */
  bool is_for_worker;   /* the executor cannot run it */
  int body, checkpoint; /* descriptors while it runs */
  double seconds;       /* that its run may take */
  double fraction;      /* of the work, never falls within a run */
  double took;          /* seconds of the run whose result is being kept */
  bool ends;            /* that is so: it counts as running */
  /* batch */
  job *batch;           /* the job it is part of */
  job *parts, *sibling; /* its parts before they are stored */
  int ended, failed;    /* of its parts */
  double sum;           /* of the fractions of its parts */
  /* to be stored */
  bool changed; /* it is to be stored, or is but has not yet been told */
  bool again;   /* it has changed since it was stored */
  job *next_changed;
  job_extra *extra; /* of a new one */
  job_note *overtaken;
  job_small small[JOB_FILES];
  job_large large[JOB_FILES]; /* if the store takes them */
  job_filing *filing[JOB_FILES];
  char *problem; /* of a failed one */
  size_t problem_size;
  void (*stored)(void *self, const job_row *row, store_result result);
  void *stored_self;
  /* of several daemons (job_shared.h) */
  bool elsewhere;        /* not ours: the row as it was read last */
  char held[JOB_HOLDER]; /* holder as it is stored */
  bool lost;             /* found to be another's, or dismissed, when it was to be stored */
  int members;           /* parts in memory, of a batch */
  unsigned round;        /* in which it was seen to be ours */
  int told_progress;     /* what the others know of its progress */
  double told_residual;
  char told_phase[JOB_PHASE];
  /* watched */
  job_watch *watches;
  job_events *events;
};

struct jobs {
  loop *loop;
  const parameters *set;
  pool *pool;
  executor *executor;
  store *store;
  void *by_id;     /* tsearch */
  job_tally tally; /* of those in memory, batches by their parts */
  job_queue *queue;
  bool queued;               /* something, since it was last looked at what may start */
  struct job_shared *shared; /* NULL: no other daemon has jobs here */
  job *changed, **last_changed;
  double retry;  /* when to try again to store what could not be */
  double pause;  /* until when none is started, INFINITY: no pause */
  double expiry; /* when the next result expires, by unix_now */
  int64_t budget;
  int64_t held; /* places of jobs that are being checked */
  double last;  /* newest `finished`: no two are equal */
  double mean;  /* seconds of a run, weighted towards the recent ones */
  bool stopped;
  job_counts counts;
  clerk *clerk;
  job_filing *filings; /* what is being written, wanted or not */
  allowance bytes;     /* of requests and results */
  void (*told)(void *self);
  void *told_self;
  job_owners owners;
};

/* job.c */
job *job_new(jobs *j, const job_row *row); /* registered; NULL when out of memory */
void job_free(job *c);
job *job_find(jobs *j, const char *id);
void job_become(job *c, job_state state, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void job_touch(job *c);                     /* it is updated; never earlier than it was */
void job_tell(job *c, job_event_kind kind); /* an event, and everybody who watches */
job_view job_look(const job *c);

/* job_add.c */
int job_places(const job *c); /* in the queue and of its submitter's: its parts, or its own */

/* job_files.c */
/* Keeps the first `size` bytes of fd, which it takes; then calls `kept` with 0 or an errno: at
 * once, or from the loop when a large file is written (clerk.h), if the job has not forgotten it.
 */
typedef void job_kept(job *c, int error);
void job_files_keep(job *c, job_file kind, int fd, size_t size, job_kept *kept);
void job_files_forget(job *c);              /* what is being kept: no file will be left of it */
void job_files_orphan(jobs *j, void *self); /* nobody waits for the jobs of `self` to be stored */
bool job_files_copy(job *c, const job_row *from);               /* the result; false with errno */
int job_files_open(jobs *j, const job_row *row, job_file kind); /* -1 with errno */
store_result job_files_write(job *c);                           /* within a transaction */
void job_files_clear(job *c);                                   /* what is written */
/* Forgets request and checkpoint, and the result with those of the parts. */
void job_files_drop(jobs *j, const job_row *row, bool result);

/* job_save.c: stores what changed */
void job_save(job *c);     /* at the end of this round */
void job_overtake(job *c); /* keeps what is to be said of a change that is not stored yet */
void job_clear_overtaken(job *c);
void job_refuse(job *c, store_result result); /* a new one, which cannot be stored; it is freed */
void jobs_flush(jobs *j);

/* job_run.c */
void jobs_schedule(void *self); /* starts what may start */
void job_advance(job *c, double fraction);
void job_enqueue(job *c, bool first);
void job_stop(job *c);  /* off the queue, off its worker or its executor */
void job_leave(job *c); /* off its worker or its executor, which has ended or stopped it */
bool job_adopt(job *c); /* from the executor, which still has it */

/* job_end.c */
void job_ended(void *context, const pool_outcome *o); /* as pool_calls.done, of a job */
void job_fail(job *c, int status, const char *format, ...) __attribute__((format(printf, 3, 4)));
void job_part_ended(job *part); /* its batch is told; once it is stored */
void job_end_batch(job *batch); /* all its parts have ended */
/* Does it end, so that it only counts as running until its result is kept? */
void job_count_end(job *c, bool ends);

/* job_recover.c */
void job_wait_again(job *c);  /* its run ended with a daemon */
bool job_count_parts(job *c); /* of a batch; ends it if all are over. False: they cannot be read */
bool jobs_recover(jobs *j, fault *why);
void jobs_expire(jobs *j);

#endif
