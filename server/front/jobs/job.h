/* job.h - jobs: accepted durably, queued, run, watched, ended, dismissed, forgotten.
 *
 * What is not over is in memory (job) and in the store; what is over only in the store. Changes of
 * one round of the event loop are stored in one transaction; nobody hears of a change before it is
 * stored. server/README.md tells the life of a job. Tests: http.jobs, http.jobs_kill9.
 */
#ifndef SCATTERD_JOB_H
#define SCATTERD_JOB_H

#include "allowance.h"
#include "clerk.h"
#include "executor.h"
#include "job_row.h"
#include "loop.h"
#include "param.h"
#include "pool.h"
#include "store.h"

typedef struct jobs jobs;
typedef struct job job; /* one that is not over; job_inner.h */

/* Takes up what the last daemon left: what was running waits again, or has failed if it was tried
 * often enough. NULL with *why. */
jobs *jobs_new(loop *l, const parameters *set, pool *p, executor *x, store *s, clerk *k,
               fault *why);

/* After pool_stop, executor_stop and clerk_finish: stores what is to be stored. */
void jobs_free(jobs **j);

/* ---- Accepting ---- */

typedef struct {
  char process[JOB_PROCESS];
  int64_t offset, size; /* of its request in the descriptor of the order */
  int64_t points, estimate;
} job_part;

typedef struct {
  job_row row;            /* process to estimate, reusable; the rest is filled in */
  const job_extra *extra; /* copied */
  int body;               /* descriptor of the request, or of the requests of the parts; taken */
  const job_part *parts;  /* of a batch; copied */
  /* Called once it is stored, from the loop, or could not be. */
  void (*stored)(void *self, const job_row *row, store_result result);
  void *self;
} job_order;

/* Accepts a job: STORE_OK when `stored` will be called, or has been, else what went wrong. Has the
 * file of the request written (two fsyncs, aside if it is large: clerk.h), during which it has its
 * place in the queue and its bytes count; the row comes then with the others of that round. */
store_result jobs_add(jobs *j, const job_order *order);

/* Nobody waits for `stored` of `self` any more. */
void jobs_forget(jobs *j, void *self);

/* Accepts a job that has the result of another one; its body is not taken. */
store_result jobs_add_answered(jobs *j, const job_order *order, const job_row *other);

/* How many more may wait; how long until there may be room, in seconds. */
int64_t jobs_room(const jobs *j);

/* Keeps a place for a job that is being checked (1), or gives it back (-1). */
void jobs_hold(jobs *j, int places);
int jobs_retry_after(const jobs *j);

/* How many jobs of a submitter are not over, each request of a batch being one. */
int64_t jobs_of(const jobs *j, const char *submitter);

/* Who knows what submitters may use: lowers what a run may; says whether `size` bytes more may be
 * kept, and then takes them off. */
typedef struct {
  void *self;
  void (*narrow)(void *self, const char *submitter, ipc_ask *ask);
  bool (*keep)(void *self, const char *submitter, int64_t size, const allowance_counter *counter);
} job_owners;
void jobs_on_owners(jobs *j, const job_owners *owners);

/* Most memory (bytes) that one job may be estimated to need, on a worker or by the executor. */
int64_t jobs_most_memory(const jobs *j);
int64_t jobs_most_memory_of(const jobs *j, const char *process, int64_t points);

/* ---- Looking ---- */

typedef struct {
  job_row row;
  char phase[32];  /* of a running one, "" if not known */
  double residual; /* of the iteration in that phase, 0 if not known */
  job *active;     /* NULL if it is over */
  int64_t event;   /* id of its newest event, 0 if none is kept */
  bool elsewhere;  /* another daemon may have it: what happened before is not known here */
} job_view;

/* A stored job as it is now. */
job_view jobs_view(jobs *j, const job_row *row);

/* A job of `owner`, of anybody if that is ""; STORE_NONE for those of others, too. */
store_result jobs_find(jobs *j, const char *owner, const char *id, job_view *view);

/* Those a filter shows, as they are now. */
store_result jobs_list(jobs *j, const store_filter *f, store_visit *visit, void *context);

/* The store, with all changes in it. */
store *jobs_store(jobs *j);

/* Opens the result of a successful job; -1 with errno. */
int jobs_result(jobs *j, const job_row *row);

/* ---- Watching ---- */

typedef enum {
  JOB_EVENT_STATUS,
  JOB_EVENT_PROGRESS,
  JOB_EVENT_PHASE,
  JOB_EVENT_RESIDUAL
} job_event_kind;

enum { JOB_EVENTS = 32 }; /* kept of each job */

typedef struct {
  int64_t id; /* grows, also over restarts */
  job_event_kind kind;
  int state, progress;
  char phase[32];
  double residual; /* 0: none */
  double time;
} job_event;

/* Somebody who is told of every change; the last one finds a final state in `now`, and the watch
 * off. */
typedef struct job_watch {
  struct job_watch *next, **at;
  void (*changed)(void *self, const job_view *now);
  void *self;
} job_watch;

void job_watch_on(job *which, job_watch *w);
void job_watch_off(job_watch *w); /* nothing if it is off */

/* The oldest kept event with an id above `after`; NULL if there is none. */
const job_event *job_event_after(const job *which, int64_t after);

/* Id of the last event of a job that is over. */
int64_t job_event_last(const job_row *row);

/* Has it had more events than it keeps? */
bool job_events_dropped(const job *which);

/* ---- Ending ---- */

/* Dismisses a job, killing its run: STORE_OK, or what went wrong. *view is what is left. */
store_result jobs_dismiss(jobs *j, const job_row *row, job_view *view);

/* ---- Counting ---- */

/* What this daemon is called in a shared store; "" in one of its own. */
const char *jobs_holder(const jobs *j);

typedef struct {
  int64_t waiting, running;
  int64_t memory; /* sum of the estimates of the running ones (bytes) */
  int64_t ended[JOB_STATES];
} job_counts;

job_counts jobs_counts(const jobs *j);

/* Who is told when there may be a call to a subscriber to be made. */
void jobs_on_change(jobs *j, void (*changed)(void *self), void *self);

/* The time of day was set by so many seconds, and the dates of the store with it (clock.h). */
void jobs_shift(jobs *j, double by);

#endif
