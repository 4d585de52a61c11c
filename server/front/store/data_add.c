/* How bytes become an object: hashed aside; known, or room looked for; written aside; stored. What
 * belongs to a filing is the thread's while its task is with the clerk. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data_inner.h"
#include "digest.h"
#include "keep.h"

struct data_filing {
  data_filing *next, **at;
  data_store *all;
  data_filing **held; /* by whom it is wanted, NULL: by nobody any more */
  void (*done)(void *self, data_result result, const data_row *row);
  void *self;
  int64_t most; /* bytes that the owner may have */
  data_row row;
  int fd, folder;          /* from the one into the other */
  char draft[STORE_DRAFT]; /* or into this, "" if not */
  clerk_task task;
  int error;   /* errno of the task, 0 if it went well */
  bool writes; /* it is being written: its bytes count, and equal ones wait for it */
  bool waits;  /* for equal ones */
};

static void place(data_filing *f);

/* ---- The end ---- */

static data_result result_of(store_result result) {
  return result == STORE_OK     ? DATA_NEW
         : result == STORE_FULL ? DATA_FULL
         : result == STORE_DOWN ? DATA_DOWN
                                : DATA_FAILED;
}

static data_result result_of_errno(int error) {
  return result_of(store_blame("data", error));
}

static data_filing *find_equal(const data_store *d, const char *id, bool writes) {
  for (data_filing *f = d->first; f != NULL; f = f->next) {
    /* NOLINTNEXTLINE(clang-analyzer-unix.Malloc): end() takes f off the list, by f->at */
    if ((writes ? f->writes : f->waits) && strcmp(f->row.id, id) == 0) return f;
  }
  return NULL;
}

/* Those who waited for it find the object now, or one of them writes it after all. */
static void place_equals(data_store *d, const char *id) {
  data_filing *f;
  while (find_equal(d, id, true) == NULL && (f = find_equal(d, id, false)) != NULL) {
    f->waits = false;
    place(f);
  }
}

static void end(data_filing *f, data_result result) {
  data_store *d = f->all;
  const data_row row = f->row;
  *f->at = f->next;
  if (f->next != NULL) f->next->at = f->at;
  clerk_close(d->clerk, f->fd);
  if (f->held != NULL) {
    *f->held = NULL;
    f->done(f->self, result, &row);
  }
  free(f);
  place_equals(d, row.id);
}

/* ---- Storing ---- */

static data_result renew(data_filing *f) {
  data_store *d = f->all;
  data_row known;
  const store_result found = store_data(d->store, f->row.id, &known);
  if (found == STORE_NONE) return DATA_NEW;
  if (found != STORE_OK) return result_of(found);
  const bool is_same = strcmp(known.type, f->row.type) == 0;
  const double expires = unix_now() + d->set->data_seconds;
  f->row = known;
  if (!is_same) return DATA_OTHER;
  const store_result result = store_data_renew(d->store, known.id, expires);
  f->row.expires = fmax(known.expires, expires);
  return result == STORE_OK ? DATA_KNOWN : result_of(result);
}

/* With those that are being written; -1 when that cannot be known now. */
static int64_t bytes_of(const data_store *d, const char *owner) {
  int64_t bytes = store_data_bytes(d->store, owner);
  if (bytes < 0) return -1;
  for (const data_filing *f = d->first; f != NULL; f = f->next) {
    const bool counts = f->writes && (*owner == '\0' || strcmp(f->row.owner, owner) == 0);
    if (counts) bytes += f->row.size;
  }
  return bytes;
}

/* DATA_NEW if there is some. */
static data_result look_for_room(const data_filing *f) {
  const data_store *d = f->all;
  const int64_t all = bytes_of(d, ""), own = bytes_of(d, f->row.owner), size = f->row.size;
  if (all < 0 || own < 0) return DATA_DOWN;
  return all + size <= d->set->data_bytes && own + size <= f->most ? DATA_NEW : DATA_QUOTA;
}

static void date(data_filing *f) {
  data_store *d = f->all;
  f->row.created = unix_now();
  f->row.expires = f->row.created + d->set->data_seconds;
  d->expiry = fmin(d->expiry, f->row.expires);
}

/* As the bytes of the row. */
static store_result take_over(const data_filing *f) {
  store *s = f->all->store;
  const size_t size = (size_t)f->row.size;
  if (*f->draft != '\0') return store_adopt(s, f->draft, f->row.id, 0, f->fd, size);
  return store_add_large(s, f->row.id, 0, f->fd, size);
}

/* Row and bytes in one transaction, which the loop waits for. */
static data_result add_shared(data_filing *f) {
  store *s = f->all->store;
  date(f);
  store_result result = store_begin(s);
  if (result == STORE_OK) result = store_data_add(s, &f->row);
  if (result == STORE_OK) result = take_over(f);
  return result_of(store_end(s, result));
}

static data_result add_draft(data_filing *f) {
  const bool is_there = f->error == 0 && f->held != NULL;
  const data_result result = is_there ? add_shared(f) : result_of_errno(f->error);
  if (result != DATA_NEW || !is_there) store_drop_draft(f->all->store, f->draft);
  return result;
}

/* The file first, then the row that refers to it. */
static data_result add_row(data_filing *f) {
  const data_store *d = f->all;
  if (f->error != 0) return result_of_errno(f->error);
  date(f);
  const store_result result = f->held != NULL ? store_data_add(d->store, &f->row) : STORE_NONE;
  if (result != STORE_OK) clerk_drop(d->clerk, f->folder, f->row.id);
  return result_of(result);
}

/* ---- Step by step ---- */

/* In the thread. */
static void write_file(void *self) {
  data_filing *f = self;
  const size_t size = (size_t)f->row.size;
  f->error = *f->draft != '\0' ? store_write_draft(f->all->store, f->draft, f->fd, size)
                               : keep_taken(f->folder, f->row.id, &f->fd, size);
}

static void written(void *self) {
  data_filing *f = self;
  f->writes = false;
  end(f, *f->draft != '\0' ? add_draft(f) : add_row(f));
}

/* Its digest is known: what is to become of it. */
static void place(data_filing *f) {
  data_store *d = f->all;
  const data_result known = renew(f);
  if (known == DATA_NEW && find_equal(d, f->row.id, true) != NULL) {
    f->waits = true;
    return;
  }
  const data_result result = known == DATA_NEW ? look_for_room(f) : known;
  const bool is_shared = store_is_shared(d->store);
  if (result != DATA_NEW) {
    end(f, result);
  } else if (is_shared && f->row.size < d->set->aside_bytes) {
    end(f, add_shared(f));
  } else {
    if (is_shared) store_name_draft(d->store, f->draft);
    f->writes = true;
    f->task = (clerk_task){write_file, written, f, NULL};
    clerk_do(d->clerk, &f->task, f->row.size);
  }
}

/* In the thread. */
static void take_digest(void *self) {
  data_filing *f = self;
  const char *label = *f->row.owner != '\0' ? f->row.owner : NULL;
  f->error = digest_file(label, f->fd, (size_t)f->row.size, f->row.id) ? 0 : errno;
}

static void digested(void *self) {
  data_filing *f = self;
  if (f->held == NULL) {
    end(f, DATA_FAILED);
  } else if (f->error != 0) {
    end(f, result_of_errno(f->error));
  } else {
    place(f);
  }
}

/* ---- From outside ---- */

void data_add(data_store *d, const data_order *o, data_filing **filing) {
  data_filing *f = *filing = calloc(1, sizeof *f);
  if (f == NULL) {
    if (o->fd >= 0) close(o->fd);
    o->done(o->self, result_of_errno(ENOMEM), &(data_row){0});
    return;
  }
  *f = (data_filing){.next = d->first,
                     .at = &d->first,
                     .all = d,
                     .held = filing,
                     .done = o->done,
                     .self = o->self,
                     .most = o->owner.bytes,
                     .row = {.size = (int64_t)o->size},
                     .fd = o->fd,
                     .folder = store_data_files(d->store),
                     .task = {take_digest, digested, f, NULL}};
  if (f->next != NULL) f->next->at = &f->next;
  d->first = f;
  snprintf(f->row.type, sizeof f->row.type, "%s", o->type);
  snprintf(f->row.owner, sizeof f->row.owner, "%s", o->owner.name);
  clerk_do(d->clerk, &f->task, f->row.size);
}

void data_forget(data_filing **filing) {
  data_filing *f = *filing;
  if (f == NULL) return;
  *filing = NULL;
  f->held = NULL;
  if (!f->waits && !clerk_take_back(f->all->clerk, &f->task)) return; /* its task is at work */
  f->writes = f->waits = false;
  end(f, DATA_FAILED);
}
