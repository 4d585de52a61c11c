/* job_shared.h - the jobs of a store that several daemons share (store_shared.h).
 *
 * A job that waits is in the database only, until a daemon whose turn it is takes it; then it is in
 * that daemon's memory as any job is. What somebody watches here and another daemon has is in
 * memory as well, `elsewhere`: the row as it was last read, read again when the other daemon tells,
 * and once a second. With a store of its own a daemon has no job_shared, and all of this is nothing
 * to it. Test: http.daemons, http.jobs.postgres.
 */
#ifndef SCATTERD_JOB_SHARED_H
#define SCATTERD_JOB_SHARED_H

#include "job_inner.h"

typedef struct job_shared job_shared;

/* NULL when out of memory. */
job_shared *job_shared_new(jobs *j);

/* What was taken and has not begun is free again. */
void job_shared_free(job_shared **h);

/* This daemon's holder id. */
const char *job_shared_id(const job_shared *h);

/* When it wants to be run again (loop_now's clock). */
double job_shared_due(const job_shared *h);
void job_shared_run(job_shared *h);

/* ---- Queue ---- */

/* Jobs that wait, on all daemons: as of about a second ago, of 0.1 s if the queue seems full. */
int64_t job_shared_waiting(job_shared *h);

/* There may be more to take; so many of our own. */
void job_shared_more(job_shared *h, int64_t count);

/* Puts the next job into our queue. False if there is none, or none to be had. */
bool job_shared_take(job_shared *h);

/* ---- Storing ---- */

/* May its submitter have a new job, with all that other daemons have added by now? */
bool job_shared_may_add(const job *c);

/* Sets the holder that a job is to be stored with. */
void job_shared_mark(job *c);

/* Tells the other daemons of all changes from `first` on, in their transaction. */
store_result job_shared_tell(job_shared *h, const job *first);

/* After a change: what nobody needs in memory goes. */
void job_shared_settle(job *c);

/* A new job is stored: it waits for whoever takes it. */
void job_shared_release(job *c);

/* Another daemon has it, or somebody dismissed it: its run here is killed. */
void job_shared_lose(job *c);

/* ---- Looking ---- */

/* The job of a row just read, in memory as that row is; NULL if it is over or memory is short. */
job *job_shared_look(jobs *j, const job_row *row);

/* Fills in what is stored with the parts of a batch: its progress. */
void job_shared_fill(jobs *j, job_row *row);

/* ---- Ending ---- */

store_result job_shared_dismiss(jobs *j, const job_row *row, job_view *view);

/* ---- Batches ---- */

/* The first of its parts has begun: so has the batch, unless another daemon was faster. */
void job_shared_begin_batch(job *batch);

/* A part is over: perhaps the batch is. */
void job_shared_part_ended(job *part);

#endif
