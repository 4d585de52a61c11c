#include "store_sql.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- Parameters ---- */

/* Number of the parameter of that name. */
static int place_of(const store *s, statement k, const char *name) {
  const store_names *n = &s->names[k];
  for (int p = 0; p < n->count; p++) {
    if (strcmp(n->named[p].name, name) == 0) return n->named[p].place;
  }
  abort(); /* the statement has no such parameter */
}

void sql_text(store *s, statement k, const char *name, const char *text) {
  s->door->bind_text(s, k, place_of(s, k, name), text);
}

void sql_long(store *s, statement k, const char *name, int64_t value) {
  s->door->bind_long(s, k, place_of(s, k, name), value);
}

void sql_real(store *s, statement k, const char *name, double value) {
  s->door->bind_real(s, k, place_of(s, k, name), value);
}

void sql_blob(store *s, statement k, const char *name, const void *bytes, size_t size) {
  s->door->bind_bytes(s, k, place_of(s, k, name), bytes, size);
}

/* ---- Steps ---- */

store_result sql_step(store *s, statement k) {
  return s->door->step(s, k);
}

void sql_reset(store *s, statement k) {
  s->door->reset(s, k);
}

store_result sql_run(store *s, statement k) {
  if (s->door->run != NULL) return s->door->run(s, k);
  const store_result result = sql_step(s, k);
  sql_reset(s, k);
  return result == STORE_NONE ? STORE_OK : result;
}

store_result sql_change(store *s, statement k) {
  store_result result = sql_step(s, k);
  if (result == STORE_NONE && s->door->changes(s, k) > 0) result = STORE_OK;
  sql_reset(s, k);
  return result;
}

void sql_get_text(store *s, statement k, int c, char *room, size_t size) {
  size_t length = 0;
  const void *text = s->door->get_bytes(s, k, c, &length);
  snprintf(room, size, "%.*s", (int)length, text != NULL ? (const char *)text : "");
}

int64_t sql_get_long(store *s, statement k, int c) {
  return s->door->get_long(s, k, c);
}

double sql_get_real(store *s, statement k, int c) {
  return s->door->get_real(s, k, c);
}

bool sql_is_open(const store *s) {
  return s->door->is_open(s);
}

/* ---- Columns: one writer and one reader per kind ---- */

static void put_text(store *s, statement k, int place, const void *at) {
  s->door->bind_text(s, k, place, at);
}

static void put_int(store *s, statement k, int place, const void *at) {
  s->door->bind_long(s, k, place, *(const int *)at);
}

static void put_long(store *s, statement k, int place, const void *at) {
  s->door->bind_long(s, k, place, *(const int64_t *)at);
}

static void put_real(store *s, statement k, int place, const void *at) {
  s->door->bind_real(s, k, place, *(const double *)at);
}

static void get_int(store *s, statement k, int c, void *room, size_t size) {
  (void)size;
  *(int *)room = (int)sql_get_long(s, k, c);
}

static void get_long(store *s, statement k, int c, void *room, size_t size) {
  (void)size;
  *(int64_t *)room = sql_get_long(s, k, c);
}

static void get_real(store *s, statement k, int c, void *room, size_t size) {
  (void)size;
  *(double *)room = sql_get_real(s, k, c);
}

static void get_text(store *s, statement k, int c, void *room, size_t size) {
  sql_get_text(s, k, c, room, size);
}

static const struct {
  void (*put)(store *s, statement k, int place, const void *at);
  void (*get)(store *s, statement k, int c, void *room, size_t size);
} kinds[] = {[TEXT] = {put_text, get_text},
             [INT] = {put_int, get_int},
             [LONG] = {put_long, get_long},
             [REAL] = {put_real, get_real}};

void sql_row(store *s, statement k, const job_row *row) {
  for (int c = 0; c < STORE_COLUMNS; c++) {
    kinds[store_columns[c].kind].put(s, k, c + 1, (const char *)row + store_columns[c].offset);
  }
}

static void get_row(store *s, statement k, job_row *row) {
  *row = (job_row){.number = sql_get_long(s, k, STORE_COLUMNS)};
  for (int c = 0; c < STORE_COLUMNS; c++) {
    kinds[store_columns[c].kind].get(s, k, c, (char *)row + store_columns[c].offset,
                                     store_columns[c].size);
  }
}

/* ---- What a statement gives ---- */

store_result sql_fetch(store *s, statement k, job_row *row) {
  const store_result result = sql_step(s, k);
  if (result == STORE_OK) get_row(s, k, row);
  sql_reset(s, k);
  return result;
}

store_result sql_visit(store *s, statement k, store_visit *visit, void *context) {
  job_row row;
  store_result result;
  while ((result = sql_step(s, k)) == STORE_OK) {
    get_row(s, k, &row);
    if (!visit(context, &row)) break;
  }
  sql_reset(s, k);
  return result == STORE_NONE ? STORE_OK : result;
}

/* The blob of the row a bound statement gives, malloc'ed, also one of no bytes; NULL with errno. */
void *sql_fetch_blob(store *s, statement k, size_t *size) {
  char *copy = NULL;
  const store_result result = sql_step(s, k);
  errno = store_errno(result == STORE_OK ? STORE_NONE : result);
  if (result == STORE_OK && !s->door->is_null(s, k, 0)) {
    const void *bytes = s->door->get_bytes(s, k, 0, size);
    copy = malloc(*size + 1);
    if (copy != NULL && *size > 0) memcpy(copy, bytes, *size);
  }
  sql_reset(s, k);
  return copy;
}

double sql_number_of(store *s, statement k, double none, double unknown) {
  const store_result result = sql_step(s, k);
  double value = result == STORE_OK || result == STORE_NONE ? none : unknown;
  if (result == STORE_OK && !s->door->is_null(s, k, 0)) value = sql_get_real(s, k, 0);
  sql_reset(s, k);
  return value;
}

/* ---- Opening ---- */

bool sql_open(store *s, const char *where, fault *why) {
  store_text q;
  for (int k = 0; k < STATEMENTS; k++) {
    store_write_statement(s->door->dialect, (statement)k, &q);
    s->names[k] = q.names;
  }
  return s->door->open(s, where, why);
}

bool sql_make_tables(store *s, int version, bool (*become)(store *s, const char *text, int version),
                     fault *why) {
  const dialect d = s->door->dialect;
  store_text q;
  if (version < 0 || version > STORE_VERSION) {
    return fault_set(why, "%s: its tables are of version %d, needs at most %d",
                     s->door->shared ? "store" : "data-dir", version, STORE_VERSION);
  }
  if (version == 0) {
    store_write_schema(d, &q);
    return become(s, q.text, STORE_VERSION);
  }
  for (; version < STORE_VERSION; version++) {
    store_write_step(d, version, &q);
    if (!become(s, q.text, version + 1)) return false;
  }
  return true;
}

void sql_close(store *s) {
  if (s->base != NULL) s->door->close(s);
  s->base = NULL;
}
