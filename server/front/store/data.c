#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "data_inner.h"
#include "keep.h"
#include "log.h"

static const double patience = 60;      /* (s) until what could not be dropped is tried again */
static const double look_seconds = 600; /* what daemons that have ended left is found after this */

/* ---- Expiry ---- */

/* Row and bytes go together: the same bytes may be coming again by way of another daemon. */
static store_result forget_shared(data_store *d, const char *id, double most) {
  store_result result = store_begin(d->store);
  if (result == STORE_OK) result = store_data_remove(d->store, id, most);
  if (result == STORE_OK) result = store_drop_large(d->store, id, 0, 0);
  return store_end(d->store, result);
}

/* Forgets an object that expires at `most`. */
static store_result forget(data_store *d, const char *id, double most) {
  if (store_is_shared(d->store)) return forget_shared(d, id, most);
  const store_result result = store_data_remove(d->store, id, most);
  if (result == STORE_OK) clerk_drop(d->clerk, store_data_files(d->store), id);
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

data_store *data_new(loop *l, const parameters *set, store *s, clerk *k) {
  data_store *d = calloc(1, sizeof *d);
  if (d == NULL) return NULL;
  *d = (data_store){.set = set, .store = s, .clerk = k, .expiry = store_data_first_expiry(s, 0)};
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
  const bool is_over = result == STORE_OK && row->expires <= unix_now() &&
                       store_data_pinned(d->store, id) == STORE_NONE;
  return is_over || (result == STORE_OK && !is_for(owner, row)) ? STORE_NONE : result;
}

int data_open(data_store *d, const data_row *row) {
  if (store_is_shared(d->store)) return store_open_large(d->store, row->id, 0);
  return keep_open(store_data_files(d->store), row->id);
}

store_result data_drop(data_store *d, const data_row *row) {
  const store_result pinned = store_data_pinned(d->store, row->id);
  if (pinned == STORE_NONE) return forget(d, row->id, INFINITY);
  return pinned == STORE_OK ? STORE_FULL : pinned;
}
