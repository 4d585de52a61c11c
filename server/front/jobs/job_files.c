/* The bytes of jobs: request, checkpoint, result. What is small stands in the store beside the row,
 * written in the row's transaction, and so costs no fsync of its own; what is larger is a file
 * (keep.h), there before the row says so. In a shared store it is written in that transaction as
 * well, or, if it is for the clerk, is a draft before, which the transaction takes over. */
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "job_inner.h"
#include "keep.h"
#include "memory_file.h"

enum { SMALL = 16384 };

struct job_filing {
  job_filing *next, **link;
  jobs *all;
  job *job; /* NULL: nobody wants it any more */
  job_file kind;
  int at, fd;
  size_t size;
  char name[64];
  bool is_draft; /* of that name, not a file */
  int error;
  job_kept *kept;
  clerk_task task;
};

static const char *const kinds[JOB_FILES] = {
    [JOB_REQUEST] = "request", [JOB_CHECKPOINT] = "checkpoint", [JOB_RESULT] = "result"};

static void name_file(const job_row *row, job_file kind, char name[64]) {
  snprintf(name, 64, "%s.%s", row->id, kinds[kind]);
}

/* Within a transaction. */
static store_result write_large(const job *c, job_file kind, const job_large *large) {
  store *s = c->all->store;
  const char *id = c->row.id;
  if (*large->draft == '\0') return store_add_large(s, id, (int)kind, large->fd, large->size);
  return store_adopt(s, large->draft, id, (int)kind, large->fd, large->size);
}

static bool write_checkpoint(const job *c, const job_large *large) {
  store *s = c->all->store;
  store_result result = store_begin(s);
  if (result == STORE_OK) result = write_large(c, JOB_CHECKPOINT, large);
  result = store_end(s, result);
  errno = store_errno(result);
  return result == STORE_OK;
}

static void clear_large(const job *c, job_large *large) {
  if (large->fd > 0) clerk_close(c->all->clerk, large->fd);
  if (*large->draft != '\0') store_drop_draft(c->all->store, large->draft); /* if it still is one */
  *large = (job_large){0};
}

/* A large one of a shared store is written with the row; a checkpoint, which no row tells of, now.
 */
static bool keep_shared(job *c, job_file kind, int fd, size_t size) {
  if (kind == JOB_CHECKPOINT) return write_checkpoint(c, &(job_large){.fd = fd, .size = size});
  const int own = fcntl(fd, F_DUPFD_CLOEXEC, 3);
  if (own < 0) return false;
  clear_large(c, &c->large[kind]);
  c->large[kind] = (job_large){.fd = own, .size = size};
  return true;
}

/* Like keep_shared, of what is a draft by now; it takes the descriptor with it. */
static bool keep_draft(job *c, job_filing *f) {
  job_large large = {.fd = f->fd, .size = f->size};
  memcpy(large.draft, f->name, sizeof large.draft);
  if (f->kind == JOB_CHECKPOINT) {
    const bool good = write_checkpoint(c, &large);
    if (!good) store_drop_draft(c->all->store, large.draft);
    return good;
  }
  clear_large(c, &c->large[f->kind]);
  c->large[f->kind] = large;
  f->fd = -1;
  return true;
}

static bool keep_small(job *c, job_file kind, int fd, size_t size) {
  job_small *small = &c->small[kind];
  free(small->bytes);
  *small = (job_small){malloc(size + 1), size};
  if (small->bytes != NULL && (size == 0 || pread(fd, small->bytes, size, 0) == (ssize_t)size)) {
    return true;
  }
  free(small->bytes);
  *small = (job_small){0};
  errno = errno != 0 ? errno : EIO;
  return false;
}

/* ---- Quotas ---- */

/* With what is being written; -1 when that cannot be known now. */
static int64_t count(void *self, const char *owner) {
  const jobs *j = self;
  int64_t bytes = store_job_bytes(j->store, owner);
  if (bytes < 0) return -1;
  for (const job_filing *f = j->filings; f != NULL; f = f->next) {
    const bool counts = f->job != NULL && f->kind != JOB_CHECKPOINT &&
                        (*owner == '\0' || strcmp(owner, f->job->row.submitter) == 0);
    if (counts) bytes += (int64_t)f->size;
  }
  return bytes;
}

/* Within job-bytes, and within what its submitter may have; false with errno. */
static bool has_room(job *c, int64_t size) {
  jobs *j = c->all;
  allowance_counter all = {count, j, ""}, own = {count, j, c->row.submitter};
  if (j->owners.keep != NULL && !j->owners.keep(j->owners.self, c->row.submitter, size, &own)) {
    return false;
  }
  return allowance_take(&j->bytes, size, j->set->job_bytes, loop_now(), &all);
}

/* A result is kept also where one cannot know: what a run took hours for waits for the store. */
static bool may_keep(job *c, job_file kind, int64_t size) {
  if (kind == JOB_CHECKPOINT || has_room(c, size)) return true;
  return kind == JOB_RESULT && store_result_of(errno) == STORE_DOWN;
}

/* ---- Aside: files, and drafts of a shared store ---- */

/* In the thread. */
static void write_file(void *self) {
  job_filing *f = self;
  f->error = f->is_draft ? store_write_draft(f->all->store, f->name, f->fd, f->size)
                         : keep_taken(f->at, f->name, &f->fd, f->size);
}

static void drop_written(const job_filing *f) {
  if (f->is_draft) {
    store_drop_draft(f->all->store, f->name);
  } else if (f->error == 0) {
    clerk_drop(f->all->clerk, f->at, f->name);
  }
}

static void free_filing(job_filing *f) {
  *f->link = f->next;
  if (f->next != NULL) f->next->link = f->link;
  clerk_close(f->all->clerk, f->fd);
  free(f);
}

/* A result whose draft could not be written, for a reason that passes, is written with its row. */
static bool can_wait(const job_filing *f) {
  return f->is_draft && f->kind == JOB_RESULT && store_result_of(f->error) == STORE_DOWN;
}

static void written(void *self) {
  job_filing *f = self;
  job *c = f->job;
  job_kept *kept = f->kept;
  int error = can_wait(f) ? 0 : f->error;
  if (c == NULL || error != 0) drop_written(f);
  if (c != NULL) c->filing[f->kind] = NULL;
  if (c != NULL && error == 0 && f->is_draft && !keep_draft(c, f)) error = errno;
  free_filing(f);
  if (c != NULL) kept(c, error);
}

static bool begin_aside(job *c, job_file kind, int fd, size_t size, job_kept *kept) {
  jobs *j = c->all;
  job_filing *f = calloc(1, sizeof *f);
  if (f == NULL) return false;
  *f = (job_filing){.next = j->filings,
                    .link = &j->filings,
                    .all = j,
                    .job = c,
                    .kind = kind,
                    .at = store_files(j->store),
                    .fd = fd,
                    .size = size,
                    .is_draft = store_is_shared(j->store),
                    .kept = kept,
                    .task = {write_file, written, f, NULL}};
  if (f->is_draft) {
    store_name_draft(j->store, f->name);
  } else {
    name_file(&c->row, kind, f->name);
  }
  if (f->next != NULL) f->next->link = &f->next;
  c->filing[kind] = j->filings = f;
  clerk_do(j->clerk, &f->task, (int64_t)size);
  return true;
}

static void forget(job_filing *f) {
  if (f == NULL) return;
  f->job->filing[f->kind] = NULL;
  f->job = NULL;
  if (clerk_take_back(f->all->clerk, &f->task)) free_filing(f);
}

void job_files_forget(job *c) {
  for (int k = 0; k < JOB_FILES; k++) forget(c->filing[k]);
}

void job_files_orphan(jobs *j, void *self) {
  for (const job_filing *f = j->filings; f != NULL; f = f->next) {
    if (f->job != NULL && f->job->stored_self == self) f->job->stored = NULL;
  }
}

/* ---- Either ---- */

static bool is_for_row(job_file kind, size_t size) {
  return size <= SMALL && kind != JOB_CHECKPOINT;
}

static bool keep_in_store(job *c, job_file kind, int fd, size_t size) {
  return is_for_row(kind, size) ? keep_small(c, kind, fd, size) : keep_shared(c, kind, fd, size);
}

void job_files_keep(job *c, job_file kind, int fd, size_t size, job_kept *kept) {
  const jobs *j = c->all;
  const bool is_aside = !is_for_row(kind, size) &&
                        (!store_is_shared(j->store) || (int64_t)size >= j->set->aside_bytes);
  bool good = may_keep(c, kind, (int64_t)size);
  if (good && is_aside && begin_aside(c, kind, fd, size, kept)) return;
  if (good) good = !is_aside && keep_in_store(c, kind, fd, size);
  const int error = good ? 0 : errno;
  if (fd >= 0) close(fd);
  kept(c, error);
}

static bool copy_within_store(job *c, int fd, size_t size) {
  return has_room(c, (int64_t)size) && keep_in_store(c, JOB_RESULT, fd, size);
}

bool job_files_copy(job *c, const job_row *from) {
  const int fd = job_files_open(c->all, from, JOB_RESULT);
  if (fd < 0) return false;
  char name[64], other[64];
  bool good;
  if (from->result_size <= SMALL || store_is_shared(c->all->store)) {
    good = copy_within_store(c, fd, (size_t)from->result_size);
  } else {
    name_file(from, JOB_RESULT, name);
    name_file(&c->row, JOB_RESULT, other);
    good = keep_link(store_files(c->all->store), name, other);
  }
  close(fd);
  return good;
}

/* The batch's request holds those of its parts. */
int job_files_open(jobs *j, const job_row *row, job_file kind) {
  char name[64];
  size_t size = 0;
  const bool shared = store_is_shared(j->store);
  if (shared && kind == JOB_CHECKPOINT) return store_open_large(j->store, row->id, (int)kind);
  void *bytes = store_small(j->store, row->number, (int)kind, &size);
  if (bytes == NULL && errno != ENOENT) return -1;
  if (bytes == NULL && shared) return store_open_large(j->store, row->id, (int)kind);
  if (bytes == NULL) {
    name_file(row, kind, name);
    return keep_open(store_files(j->store), name);
  }
  int fd = memory_file(kinds[kind]);
  const ssize_t written = fd >= 0 ? write(fd, bytes, size) : -1;
  const int error = written < 0 ? errno : ENOMEM; /* there was room for a part of it */
  free(bytes);
  if (fd >= 0 && written != (ssize_t)size) {
    close(fd);
    fd = -1;
  }
  errno = error;
  return fd;
}

/* What one that is over does not need. */
static store_result drop_unneeded(job *c) {
  store *s = c->all->store;
  const bool all = c->row.state == JOB_DISMISSED;
  const store_result result = store_drop_small(s, c->row.number, all ? -1 : (int)JOB_REQUEST);
  if (result != STORE_OK || !store_is_shared(s)) return result;
  return store_drop_large(s, c->row.id, 0, all ? JOB_FILES : JOB_CHECKPOINT);
}

store_result job_files_write(job *c) {
  store *s = c->all->store;
  const bool over = job_state_is_final((job_state)c->row.state);
  store_result result = over ? drop_unneeded(c) : STORE_OK;
  for (int k = 0; k < JOB_FILES && result == STORE_OK; k++) {
    const job_small *small = &c->small[k];
    const job_large *large = &c->large[k];
    if (over && k != (int)JOB_RESULT) continue;
    if (small->bytes != NULL) {
      result = store_add_small(s, c->row.number, k, small->bytes, small->size);
    } else if (large->fd > 0) {
      result = write_large(c, (job_file)k, large);
    }
  }
  return result;
}

void job_files_clear(job *c) {
  for (int k = 0; k < JOB_FILES; k++) {
    free(c->small[k].bytes);
    c->small[k] = (job_small){0};
    clear_large(c, &c->large[k]);
  }
}

static bool drop_part(void *context, const job_row *row) {
  job_files_drop(context, row, true);
  return true;
}

void job_files_drop(jobs *j, const job_row *row, bool result) {
  char name[64];
  if (store_is_shared(j->store)) return; /* with the row */
  for (int k = 0; k < JOB_FILES; k++) {
    if (k == JOB_RESULT && (!result || row->result_size <= SMALL)) continue;
    if (k == JOB_REQUEST && (row->parent != 0 || row->size <= SMALL)) continue;
    name_file(row, (job_file)k, name);
    clerk_drop(j->clerk, store_files(j->store), name);
  }
  if (!result || row->parts == 0 || row->number == 0) return;
  store_filter parts = {.states = ~0u,
                        .created_most = INFINITY,
                        .has_parent = true,
                        .parent = row->number,
                        .limit = INT64_MAX};
  (void)store_list(j->store, &parts, drop_part, j);
}
