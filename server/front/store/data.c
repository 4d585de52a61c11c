#include "data.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "digest.h"
#include "job.h"
#include "keep.h"
#include "log.h"

struct data_store {
  const parameters *set;
  store *store;
  double expiry; /* when to look for old ones, by unix_now */
};

static const double patience = 60;      /* (s) until what could not be dropped is tried again */
static const double look_seconds = 600; /* what daemons that have ended left is found after this */

/* ---- Expiry ---- */

/* Row and bytes go together: the same bytes may be coming again by way of another daemon. */
static store_result forget_shared(data_store *d, const char *id, double most) {
  store_result result = store_begin(d->store);
  if (result == STORE_OK) result = store_data_remove(d->store, id, most);
  if (result == STORE_OK) result = store_drop_large(d->store, id, 0, 0);
  if (result == STORE_OK) result = store_commit(d->store);
  if (result != STORE_OK) store_rollback(d->store);
  return result;
}

/* Forgets an object that expires at `most`. */
static store_result forget(data_store *d, const char *id, double most) {
  if (store_is_shared(d->store)) return forget_shared(d, id, most);
  const store_result result = store_data_remove(d->store, id, most);
  if (result == STORE_OK) keep_drop(store_data_files(d->store), id);
  return result;
}

static double due(void *self) {
  const data_store *d = self;
  return loop_now() + (d->expiry - unix_now());
}

/* Drops one that is old; the rest has its turn when the loop comes round. */
static void run(void *self) {
  data_store *d = self;
  char id[DATA_ID];
  const double now = unix_now();
  if (now < d->expiry) return;
  if (store_data_expired(d->store, now, id) == STORE_OK && forget(d, id, now) == STORE_OK) {
    log_say(LOG_DEBUG, "expired", "data %s", id);
    return;
  }
  d->expiry = fmax(now + patience, store_data_first_expiry(d->store, now + patience));
  if (store_is_shared(d->store)) d->expiry = fmin(d->expiry, now + look_seconds);
}

void data_shift(data_store *d, double by) {
  d->expiry += by;
}

/* ---- The whole ---- */

static bool is_wanted(void *context, const char *name) {
  data_store *d = context;
  data_row row;
  return store_data(d->store, name, &row) != STORE_NONE; /* what cannot be known is kept */
}

data_store *data_new(loop *l, const parameters *set, store *s) {
  data_store *d = calloc(1, sizeof *d);
  if (d == NULL) return NULL;
  *d = (data_store){.set = set, .store = s, .expiry = store_data_first_expiry(s, 0)};
  if (!store_is_shared(s)) keep_sweep(store_data_files(s), is_wanted, d);
  loop_add(l, (loop_chore){due, run, d});
  return d;
}

void data_free(data_store **d) {
  free(*d);
  *d = NULL;
}

/* ---- Objects ---- */

/* Without an owner there are no tokens: all is everybody's. */
static bool is_for(const char *owner, const data_row *row) {
  return *owner == '\0' || strcmp(owner, row->owner) == 0;
}

store_result data_find(data_store *d, const char *owner, const char *id, data_row *row) {
  const bool is_id = strlen(id) == DATA_ID - 1 && strspn(id, "0123456789abcdef") == DATA_ID - 1;
  const store_result result = is_id ? store_data(d->store, id, row) : STORE_NONE;
  const bool is_over =
      result == STORE_OK && row->expires <= unix_now() && !store_data_is_pinned(d->store, id);
  return is_over || (result == STORE_OK && !is_for(owner, row)) ? STORE_NONE : result;
}

static data_result result_of(store_result result) {
  return result == STORE_OK     ? DATA_NEW
         : result == STORE_FULL ? DATA_FULL
         : result == STORE_DOWN ? DATA_DOWN
                                : DATA_FAILED;
}

static data_result renew(data_store *d, const char *type, data_row *row) {
  const double expires = unix_now() + d->set->data_seconds;
  if (strcmp(row->type, type) != 0) return DATA_OTHER;
  const store_result result = store_data_renew(d->store, row->id, expires);
  if (result != STORE_OK) return result_of(result);
  row->expires = fmax(row->expires, expires);
  return DATA_KNOWN;
}

static data_result failure(void) {
  if (errno == ENOSPC || errno == EDQUOT) return DATA_FULL;
  if (errno == ENOMEM) return DATA_DOWN;
  log_say(LOG_ERROR, "data", "%s", strerror(errno));
  return DATA_FAILED;
}

static data_result write_shared(data_store *d, int fd, const data_row *row) {
  store_result result = store_begin(d->store);
  if (result == STORE_OK) result = store_data_add(d->store, row);
  if (result == STORE_OK) result = store_add_large(d->store, row->id, 0, fd, (size_t)row->size);
  if (result == STORE_OK) result = store_commit(d->store);
  if (result != STORE_OK) store_rollback(d->store);
  return result_of(result);
}

/* The file first, then the row that refers to it. */
static data_result write_own(data_store *d, int fd, const data_row *row) {
  const int at = store_data_files(d->store);
  if (!keep_file(at, row->id, fd, (size_t)row->size)) return failure();
  const store_result result = store_data_add(d->store, row);
  if (result != STORE_OK) keep_drop(at, row->id);
  return result_of(result);
}

static data_result write_new(data_store *d, int64_t most, int fd, const data_row *row) {
  const int64_t all = store_data_bytes(d->store, ""), own = store_data_bytes(d->store, row->owner);
  if (all < 0 || own < 0) return DATA_DOWN;
  if (all + row->size > d->set->data_bytes || own + row->size > most) return DATA_QUOTA;
  d->expiry = fmin(d->expiry, row->expires);
  return store_is_shared(d->store) ? write_shared(d, fd, row) : write_own(d, fd, row);
}

data_result data_add(data_store *d, data_owner owner, const char *type, int fd, size_t size,
                     data_row *row) {
  char id[DIGEST_TEXT];
  const char *label = *owner.name != '\0' ? owner.name : NULL;
  if (!digest_file(label, fd, size, id)) return failure();
  const store_result known = store_data(d->store, id, row);
  if (known == STORE_OK) return renew(d, type, row);
  if (known != STORE_NONE) return result_of(known);
  *row = (data_row){.size = (int64_t)size, .created = unix_now()};
  row->expires = row->created + d->set->data_seconds;
  snprintf(row->id, sizeof row->id, "%s", id);
  snprintf(row->type, sizeof row->type, "%s", type);
  snprintf(row->owner, sizeof row->owner, "%s", owner.name);
  return write_new(d, owner.bytes, fd, row);
}

int data_open(data_store *d, const data_row *row) {
  if (store_is_shared(d->store)) return store_open_large(d->store, row->id, 0);
  return keep_open(store_data_files(d->store), row->id);
}

store_result data_drop(data_store *d, const data_row *row) {
  return store_data_is_pinned(d->store, row->id) ? STORE_FULL : forget(d, row->id, INFINITY);
}
