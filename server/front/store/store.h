/* store.h - what survives the daemon: jobs in SQLite and their files, or all of it in a PostgreSQL
 * database that several daemons share (store_shared.h).
 *
 * A data directory belongs to one daemon at a time. Rows are written in a transaction (write-ahead
 * log, synchronous FULL): what is committed stays, also over a power cut. Files are kept (keep.h)
 * before a row refers to them. Test: unit.store, http.jobs_kill9.
 */
#ifndef SCATTERD_STORE_H
#define SCATTERD_STORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "data_row.h"
#include "fault.h"
#include "job_row.h"

#define STORE_DATABASE "jobs.db" /* in its directory; its log is beside it with -wal */

typedef struct store store;

typedef enum {
  STORE_OK,
  STORE_NONE,   /* there is no such row */
  STORE_TAKEN,  /* another job has this Idempotency-Key */
  STORE_LIMIT,  /* its submitter has as many jobs as it may */
  STORE_BUSY,   /* another daemon is at it, and hangs */
  STORE_FULL,   /* the disk is, or a quota */
  STORE_DOWN,   /* the database does not answer, memory or descriptors lack: which passes */
  STORE_FAILED, /* anything else; the log knows */
} store_result;

/* Opens the store of a directory, making what is missing; with a `url` (postgresql://...) the rows
 * and all bytes are in that database. NULL when another daemon has the directory or it cannot be
 * read. */
store *store_open(const char *directory, const char *url, fault *why);
void store_close(store **s);

/* Do several daemons share it? Does its database answer? */
bool store_is_shared(const store *s);
bool store_is_up(const store *s);

/* Several writes as one; after a failure of any of them, roll back. */
store_result store_begin(store *s);
store_result store_commit(store *s);
void store_rollback(store *s);

/* The end of a transaction of which this has come: committed if it is STORE_OK, and undone unless
 * that is then, too. What came of it all. */
store_result store_end(store *s, store_result result);

/* Directory descriptor of the files of jobs. */
int store_files(const store *s);

/* ---- Jobs ---- */

/* Adds a job and sets its number. */
store_result store_add(store *s, job_row *row, const job_extra *extra);

/* Writes what changed; STORE_NONE if its holder is not `held` any more. `problem` of a failed job:
 * its bytes; NULL leaves them. */
store_result store_update(store *s, const job_row *row, const char *held, const void *problem,
                          size_t size);

store_result store_job(store *s, const char *id, job_row *row);
store_result store_job_number(store *s, int64_t number, job_row *row);

/* Job `part` of a batch. */
store_result store_part(store *s, int64_t parent, int part, job_row *row);

/* The part of a batch that ended first after the time `after`. */
store_result store_next_ended(store *s, int64_t parent, double after, job_row *row);

/* How many parts of a batch are in each state. */
store_result store_part_states(store *s, int64_t parent, int64_t count[JOB_STATES]);

/* Bytes of a failed job's problem, malloc'ed; NULL with errno, ENOENT if there are none. */
void *store_problem(store *s, int64_t number, size_t *size);

store_result store_extra(store *s, int64_t number, job_extra *extra);

/* The newest job of a submitter with this Idempotency-Key, and the digest of its request. */
store_result store_by_key(store *s, const char *submitter, const char *key, job_row *row,
                          char digest[JOB_DIGEST]);

/* The newest successful job with this digest that is there until `until`, of `owner` if that is not
 * "". */
store_result store_by_digest(store *s, const char *owner, const char *digest, double until,
                             job_row *row);

/* Removes a job and its parts. */
store_result store_remove(store *s, int64_t number);

typedef bool store_visit(void *context, const job_row *row); /* false: enough */

/* Jobs that are accepted or running, in order of acceptance. */
store_result store_active(store *s, store_visit *visit, void *context);

/* Jobs whose time is over. */
store_result store_expired(store *s, double now, store_visit *visit, void *context);

/* The earliest `expires` of a job; INFINITY without any, `unknown` when it cannot be read. */
double store_first_expiry(store *s, double unknown);

/* Bytes of the requests of jobs that are not over and of the results of all, of those of
 * `owner` if that is not ""; -1 when they cannot be read. Cost: all jobs. */
int64_t store_job_bytes(store *s, const char *owner);

/* Which jobs a list shows. */
typedef struct {
  const char *owner;   /* only those of this submitter; NULL or "": of all */
  char processes[512]; /* ",solve,apply,", "" for all */
  unsigned states;     /* set of 1 << job_state */
  double created_least, created_most;
  double seconds_least, seconds_most; /* from start to end, or to `now` while it runs */
  bool timed;                         /* the two above are asked for */
  bool has_parent;                    /* only the parts of this batch; else no parts */
  int64_t parent;
  double now;
  int64_t limit, offset;
} store_filter;

/* Newest first. */
store_result store_list(store *s, const store_filter *f, store_visit *visit, void *context);

/* ---- Calls to subscribers ---- */

store_result store_add_call(store *s, int64_t job, int address, double when);

/* Those that are due first, at most `most`. */
typedef void store_call(void *context, const job_call *call);
store_result store_calls(store *s, int most, store_call *visit, void *context);

/* Writes attempts and due; forgets it. */
store_result store_update_call(store *s, const job_call *call);
store_result store_remove_call(store *s, int64_t number);

/* Moves all dates at which something ends or is due by so many seconds (clock.h); those of a shared
 * database stay. */
store_result store_shift(store *s, double by);

/* ---- Small bytes of jobs, by number and kind (`which`) ---- */

store_result store_add_small(store *s, int64_t job, int which, const void *bytes, size_t size);

/* malloc'ed; NULL with errno, ENOENT if there are none. */
void *store_small(store *s, int64_t job, int which, size_t *size);

/* Forgets those of one kind, -1: all. */
store_result store_drop_small(store *s, int64_t job, int which);

/* ---- Large bytes within a shared store, by owner (id of a job or of data) and kind ---- */

/* Takes the place of what was there; no transaction of its own. */
store_result store_add_large(store *s, const char *owner, int which, int fd, size_t size);

/* A nameless file with them, for reading only; -1 with errno. */
int store_open_large(store *s, const char *owner, int which);

/* Forgets those of the kinds from `least` to `most`. */
store_result store_drop_large(store *s, const char *owner, int least, int most);

/* ---- Drafts: large bytes of a shared store that the clerk writes (clerk.h), before a transaction
 * of the loop takes them over. What a daemon leaves goes when it is buried (store_shared.h). ----
 */

enum { STORE_DRAFT = 64 };

/* A new name for one. */
void store_name_draft(store *s, char draft[STORE_DRAFT]);

/* Writes it, durably, over a connection that is used for nothing else and made when it is first
 * needed. The only function of a store that a second thread may call, one call at a time. 0 or an
 * errno; then it may be there all the same. */
int store_write_draft(store *s, const char *draft, int fd, size_t size);

/* Makes it the bytes of `owner`, in place of what was there; no transaction of its own. Cost: none
 * of its bytes is touched. If it has gone (this daemon was taken for dead, or its database was
 * replaced by a copy), the same as store_add_large. */
store_result store_adopt(store *s, const char *draft, const char *owner, int which, int fd,
                         size_t size);

/* Forgets it, if it is there. */
void store_drop_draft(store *s, const char *draft);

/* A failure of the store as an errno. */
int store_errno(store_result result);

/* What an errno of opening, reading or writing means for the store's users: STORE_FULL (507) when
 * the disk or a quota is full, STORE_DOWN (503) for what the daemon will have again (memory,
 * descriptors, the database), STORE_FAILED (500) for anything else, STORE_OK for 0. */
store_result store_result_of(int error);

/* The same, with a line in the log if it is STORE_FAILED. */
store_result store_blame(const char *subject, int error);

/* ---- Log of a job ---- */

store_result store_log(store *s, int64_t number, double time, const char *text);

/* Its last lines in order of time, at most `most`. */
typedef void store_line(void *context, double time, const char *text);
store_result store_read_log(store *s, int64_t number, int most, store_line *visit, void *context);

/* ---- Data ---- */

/* Directory descriptor of the files of data, each called by its id. */
int store_data_files(const store *s);

store_result store_data_add(store *s, const data_row *row);
store_result store_data(store *s, const char *id, data_row *row);

/* Sum of all sizes, of those of `owner` if that is not ""; -1 when they cannot be read. */
int64_t store_data_bytes(store *s, const char *owner);

/* It stays at least until `expires`. */
store_result store_data_renew(store *s, const char *id, double expires);

/* Is a job waiting or running that refers to it? STORE_NONE if not. */
store_result store_data_pinned(store *s, const char *id);

/* One whose time is over and that no such job needs; the earliest time, INFINITY without any,
 * `unknown` when it cannot be read. */
store_result store_data_expired(store *s, double now, char id[DATA_ID]);
double store_data_first_expiry(store *s, double unknown);

/* Removes one that expires at `most`; STORE_NONE if it does not, by now. */
store_result store_data_remove(store *s, const char *id, double most);

#endif
