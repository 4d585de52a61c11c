#include "store.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "log.h"
#include "store_sql.h"

/* ---- Failures ---- */

int store_errno(store_result result) {
  static const int numbers[] = {
      [STORE_OK] = 0,        [STORE_NONE] = ENOENT,    [STORE_TAKEN] = EEXIST,
      [STORE_FULL] = ENOSPC, [STORE_DOWN] = EHOSTDOWN, [STORE_FAILED] = EIO,
      [STORE_LIMIT] = EIO,   [STORE_BUSY] = EIO};
  return numbers[result];
}

static const struct {
  int error;
  store_result means;
} meanings[] = {
    {0, STORE_OK},        {ENOSPC, STORE_FULL}, {EDQUOT, STORE_FULL}, {EHOSTDOWN, STORE_DOWN},
    {ENOMEM, STORE_DOWN}, {EMFILE, STORE_DOWN}, {ENFILE, STORE_DOWN},
};

store_result store_result_of(int error) {
  for (size_t k = 0; k < sizeof meanings / sizeof *meanings; k++) {
    if (meanings[k].error == error) return meanings[k].means;
  }
  return STORE_FAILED;
}

store_result store_blame(const char *subject, int error) {
  const store_result result = store_result_of(error);
  if (result == STORE_FAILED) log_say(LOG_ERROR, subject, "%s", strerror(error));
  return result;
}

/* ---- Opening ---- */

static void tell_mode(const store *s, const char *path) {
  struct stat facts;
  if (fstat(s->directory, &facts) != 0 || (facts.st_mode & S_IWOTH) == 0) return;
  log_say(LOG_ERROR, "store", "everybody on this machine may write in %s; chmod o-w it", path);
}

static bool lock_directory(store *s, const char *path, fault *why) {
  s->directory = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (s->directory < 0) {
    return fault_set(why, "data-dir: cannot open %.200s: %s", path, strerror(errno));
  }
  s->lock = openat(s->directory, "lock", O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (s->lock < 0) return fault_set(why, "data-dir: cannot lock %.200s: %s", path, strerror(errno));
  if (flock(s->lock, LOCK_EX | LOCK_NB) == 0) {
    tell_mode(s, path);
    return true;
  }
  return fault_set(why, "data-dir: another daemon uses %.200s", path);
}

static bool open_folder(store *s, const char *name, int *folder, fault *why) {
  if (mkdirat(s->directory, name, 0700) != 0 && errno != EEXIST) {
    return fault_set(why, "data-dir: cannot make %s: %s", name, strerror(errno));
  }
  *folder = openat(s->directory, name, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (*folder >= 0 && fsync(s->directory) == 0) return true;
  return fault_set(why, "data-dir: cannot open %s: %s", name, strerror(errno));
}

static bool open_files(store *s, fault *why) {
  return open_folder(s, "jobs", &s->files, why) && open_folder(s, "data", &s->data, why);
}

store *store_open(const char *directory, const char *url, fault *why) {
  store *s = calloc(1, sizeof *s);
  if (s == NULL) {
    fault_set(why, "out of memory");
    return NULL;
  }
  s->directory = s->files = s->data = s->lock = -1;
  const bool is_own = *url == '\0';
  s->door = is_own ? &store_sqlite : &store_postgres;
  if (!lock_directory(s, directory, why) || !open_files(s, why) ||
      !sql_open(s, is_own ? directory : url, why)) {
    store_close(&s);
    return NULL;
  }
  if (!is_own && (s->writer = store_writer_new(s, url)) == NULL) {
    fault_set(why, "out of memory");
    store_close(&s);
  }
  return s;
}

void store_close(store **s) {
  if (*s == NULL) return;
  store_writer_free(&(*s)->writer);
  sql_close(*s);
  if ((*s)->files >= 0) close((*s)->files);
  if ((*s)->data >= 0) close((*s)->data);
  if ((*s)->lock >= 0) close((*s)->lock);
  if ((*s)->directory >= 0) close((*s)->directory);
  free(*s);
  *s = NULL;
}

int store_files(const store *s) {
  return s->files;
}

store_result store_begin(store *s) {
  return sql_run(s, BEGIN);
}

store_result store_commit(store *s) {
  return sql_run(s, COMMIT);
}

void store_rollback(store *s) {
  if (sql_is_open(s)) (void)sql_run(s, ROLLBACK); /* some failures do so themselves */
}

store_result store_end(store *s, store_result result) {
  if (result == STORE_OK) result = store_commit(s);
  if (result != STORE_OK) store_rollback(s);
  return result;
}

/* ---- Jobs ---- */

static const char *const uris[] = {":success", ":running", ":failed"};

store_result store_add(store *s, job_row *row, const job_extra *extra) {
  sql_row(s, ADD, row);
  sql_text(s, ADD, ":key", extra->key);
  sql_text(s, ADD, ":digest", extra->digest);
  sql_text(s, ADD, ":base", extra->base);
  for (int k = 0; k < 3; k++) sql_text(s, ADD, uris[k], extra->uri[k]);
  store_result result = sql_step(s, ADD);
  if (result == STORE_OK) row->number = sql_get_long(s, ADD, 0);
  sql_reset(s, ADD);
  for (int k = 0; k < JOB_PINS && *extra->pin[k] != '\0' && result == STORE_OK; k++) {
    sql_text(s, PIN, ":id", extra->pin[k]);
    sql_long(s, PIN, ":number", row->number);
    result = sql_run(s, PIN);
  }
  return result;
}

store_result store_update(store *s, const job_row *row, const char *held, const void *problem,
                          size_t size) {
  sql_row(s, UPDATE, row);
  sql_long(s, UPDATE, ":number", row->number);
  sql_text(s, UPDATE, ":held", held);
  const store_result result = sql_change(s, UPDATE);
  if (result != STORE_OK || problem == NULL) return result;
  sql_long(s, SET_PROBLEM, ":number", row->number);
  sql_blob(s, SET_PROBLEM, ":problem", problem, size);
  return sql_run(s, SET_PROBLEM);
}

store_result store_job(store *s, const char *id, job_row *row) {
  sql_text(s, JOB, ":id", id);
  return sql_fetch(s, JOB, row);
}

store_result store_job_number(store *s, int64_t number, job_row *row) {
  sql_long(s, JOB_NUMBER, ":number", number);
  return sql_fetch(s, JOB_NUMBER, row);
}

store_result store_part(store *s, int64_t parent, int part, job_row *row) {
  sql_long(s, PART, ":number", parent);
  sql_long(s, PART, ":part", part);
  return sql_fetch(s, PART, row);
}

store_result store_next_ended(store *s, int64_t parent, double after, job_row *row) {
  sql_long(s, NEXT_ENDED, ":number", parent);
  sql_real(s, NEXT_ENDED, ":after", after);
  return sql_fetch(s, NEXT_ENDED, row);
}

void *store_problem(store *s, int64_t number, size_t *size) {
  sql_long(s, PROBLEM, ":number", number);
  return sql_fetch_blob(s, PROBLEM, size);
}

store_result store_extra(store *s, int64_t number, job_extra *extra) {
  sql_long(s, EXTRA, ":number", number);
  const store_result result = sql_step(s, EXTRA);
  if (result == STORE_OK) {
    sql_get_text(s, EXTRA, 0, extra->key, sizeof extra->key);
    sql_get_text(s, EXTRA, 1, extra->digest, sizeof extra->digest);
    for (int k = 0; k < 3; k++) sql_get_text(s, EXTRA, 2 + k, extra->uri[k], JOB_URI);
    sql_get_text(s, EXTRA, 5, extra->base, sizeof extra->base);
  }
  sql_reset(s, EXTRA);
  return result;
}

store_result store_by_key(store *s, const char *submitter, const char *key, job_row *row,
                          char digest[JOB_DIGEST]) {
  sql_text(s, BY_KEY, ":submitter", submitter);
  sql_text(s, BY_KEY, ":key", key);
  store_result result = sql_fetch(s, BY_KEY, row);
  if (result != STORE_OK) return result;
  sql_long(s, KEY_DIGEST, ":number", row->number);
  result = sql_step(s, KEY_DIGEST);
  if (result == STORE_OK) sql_get_text(s, KEY_DIGEST, 0, digest, JOB_DIGEST);
  sql_reset(s, KEY_DIGEST);
  return result;
}

store_result store_by_digest(store *s, const char *owner, const char *digest, double until,
                             job_row *row) {
  sql_text(s, BY_DIGEST, ":owner", owner);
  sql_text(s, BY_DIGEST, ":digest", digest);
  sql_real(s, BY_DIGEST, ":until", until);
  return sql_fetch(s, BY_DIGEST, row);
}

/* Bytes first: the rows know those of parts. */
store_result store_remove(store *s, int64_t number) {
  static const statement in_order[] = {REMOVE_LARGE, REMOVE_SMALL, REMOVE,
                                       REMOVE_CALLS, REMOVE_LOG,   UNPIN};
  store_result result = STORE_OK;
  for (size_t k = s->door->shared ? 0 : 1; k < 6 && result == STORE_OK; k++) {
    sql_long(s, in_order[k], ":number", number);
    result = sql_run(s, in_order[k]);
  }
  return result;
}

store_result store_part_states(store *s, int64_t parent, int64_t count[JOB_STATES]) {
  store_result result;
  memset(count, 0, JOB_STATES * sizeof *count);
  sql_long(s, PART_STATES, ":number", parent);
  while ((result = sql_step(s, PART_STATES)) == STORE_OK) {
    const int state = (int)sql_get_long(s, PART_STATES, 0);
    if (state >= 0 && state < JOB_STATES) {
      count[state] = sql_get_long(s, PART_STATES, 1);
    }
  }
  sql_reset(s, PART_STATES);
  return result == STORE_NONE ? STORE_OK : result;
}

store_result store_active(store *s, store_visit *visit, void *context) {
  return sql_visit(s, ACTIVE, visit, context);
}

store_result store_expired(store *s, double now, store_visit *visit, void *context) {
  sql_real(s, EXPIRED, ":now", now);
  return sql_visit(s, EXPIRED, visit, context);
}

double store_first_expiry(store *s, double unknown) {
  return sql_number_of(s, FIRST_EXPIRY, INFINITY, unknown);
}

store_result store_shift(store *s, double by) {
  static const statement shifts[] = {SHIFT_JOBS, SHIFT_CALLS, SHIFT_DATA};
  if (s->door->shared) return STORE_OK; /* others' clocks are right */
  store_result result = store_begin(s);
  for (int k = 0; k < 3 && result == STORE_OK; k++) {
    sql_real(s, shifts[k], ":by", by);
    result = sql_run(s, shifts[k]);
  }
  return store_end(s, result);
}

int64_t store_job_bytes(store *s, const char *owner) {
  sql_text(s, JOB_BYTES, ":owner", owner);
  return (int64_t)sql_number_of(s, JOB_BYTES, 0, -1);
}

store_result store_list(store *s, const store_filter *f, store_visit *visit, void *context) {
  sql_text(s, LIST, ":owner", f->owner != NULL ? f->owner : "");
  sql_text(s, LIST, ":processes", f->processes);
  sql_long(s, LIST, ":states", f->states);
  sql_real(s, LIST, ":created_least", f->created_least);
  sql_real(s, LIST, ":created_most", f->created_most);
  sql_real(s, LIST, ":seconds_least", f->seconds_least);
  sql_real(s, LIST, ":seconds_most", f->seconds_most);
  sql_long(s, LIST, ":timed", f->timed);
  sql_long(s, LIST, ":parent", f->has_parent ? f->parent : 0);
  sql_real(s, LIST, ":now", f->now);
  sql_long(s, LIST, ":limit", f->limit);
  sql_long(s, LIST, ":offset", f->offset);
  return sql_visit(s, LIST, visit, context);
}
