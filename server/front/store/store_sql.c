#include "store_sql.h"

#include <errno.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "log.h"

/* ---- Using statements ---- */

static store_result failure(store *s, int code) {
  if ((code & 0xff) == SQLITE_FULL) return STORE_FULL;
  if (sqlite3_system_errno(s->db) == ENOSPC || sqlite3_system_errno(s->db) == EDQUOT) {
    return STORE_FULL;
  }
  log_say(LOG_ERROR, "store", "%s", sqlite3_errmsg(s->db));
  return STORE_FAILED;
}

/* One step; STORE_OK with a row, STORE_NONE at the end. */
store_result sql_step(store *s, statement k) {
  const int code = sqlite3_step(s->statement[k]);
  if (code == SQLITE_ROW) return STORE_OK;
  if (code == SQLITE_DONE) return STORE_NONE;
  return failure(s, code);
}

void sql_reset(store *s, statement k) {
  sqlite3_reset(s->statement[k]);
  sqlite3_clear_bindings(s->statement[k]);
}

/* Runs a statement that gives no rows. */
store_result sql_run(store *s, statement k) {
  store_result result = sql_step(s, k);
  sql_reset(s, k);
  return result == STORE_NONE ? STORE_OK : result;
}

static int place(store *s, statement k, const char *name) {
  return sqlite3_bind_parameter_index(s->statement[k], name);
}

void sql_text(store *s, statement k, const char *name, const char *text) {
  sqlite3_bind_text(s->statement[k], place(s, k, name), text, -1, SQLITE_STATIC);
}

void sql_long(store *s, statement k, const char *name, int64_t value) {
  sqlite3_bind_int64(s->statement[k], place(s, k, name), value);
}

void sql_real(store *s, statement k, const char *name, double value) {
  sqlite3_bind_double(s->statement[k], place(s, k, name), value);
}

void sql_blob(store *s, statement k, const char *name, const void *bytes, size_t size) {
  sqlite3_bind_blob64(s->statement[k], place(s, k, name), bytes, size, SQLITE_STATIC);
}

/* ---- Columns: one writer and one reader per kind ---- */

static void put_text(sqlite3_stmt *to, int place_of, const void *at) {
  sqlite3_bind_text(to, place_of, at, -1, SQLITE_STATIC);
}

static void put_int(sqlite3_stmt *to, int place_of, const void *at) {
  sqlite3_bind_int(to, place_of, *(const int *)at);
}

static void put_long(sqlite3_stmt *to, int place_of, const void *at) {
  sqlite3_bind_int64(to, place_of, *(const int64_t *)at);
}

static void put_real(sqlite3_stmt *to, int place_of, const void *at) {
  sqlite3_bind_double(to, place_of, *(const double *)at);
}

static void get_text(sqlite3_stmt *from, int c, void *room, size_t size) {
  const unsigned char *text = sqlite3_column_text(from, c);
  snprintf(room, size, "%s", text != NULL ? (const char *)text : "");
}

static void get_int(sqlite3_stmt *from, int c, void *room, size_t size) {
  (void)size;
  *(int *)room = sqlite3_column_int(from, c);
}

static void get_long(sqlite3_stmt *from, int c, void *room, size_t size) {
  (void)size;
  *(int64_t *)room = sqlite3_column_int64(from, c);
}

static void get_real(sqlite3_stmt *from, int c, void *room, size_t size) {
  (void)size;
  *(double *)room = sqlite3_column_double(from, c);
}

static const struct {
  void (*put)(sqlite3_stmt *to, int place_of, const void *at);
  void (*get)(sqlite3_stmt *from, int c, void *room, size_t size);
} kinds[] = {[TEXT] = {put_text, get_text},
             [INT] = {put_int, get_int},
             [LONG] = {put_long, get_long},
             [REAL] = {put_real, get_real}};

static void bind_row(sqlite3_stmt *to, const job_row *row) {
  for (int c = 0; c < STORE_COLUMNS; c++) {
    kinds[store_columns[c].kind].put(to, c + 1, (const char *)row + store_columns[c].offset);
  }
}

static void get_row(sqlite3_stmt *from, job_row *row) {
  *row = (job_row){.number = sqlite3_column_int64(from, STORE_COLUMNS)};
  for (int c = 0; c < STORE_COLUMNS; c++) {
    kinds[store_columns[c].kind].get(from, c, (char *)row + store_columns[c].offset,
                                     store_columns[c].size);
  }
}

/* The one row a bound statement gives. */
store_result sql_fetch(store *s, statement k, job_row *row) {
  const store_result result = sql_step(s, k);
  if (result == STORE_OK) get_row(s->statement[k], row);
  sql_reset(s, k);
  return result;
}

store_result sql_visit(store *s, statement k, store_visit *visit, void *context) {
  job_row row;
  store_result result;
  while ((result = sql_step(s, k)) == STORE_OK) {
    get_row(s->statement[k], &row);
    if (!visit(context, &row)) break;
  }
  sql_reset(s, k);
  return result == STORE_NONE ? STORE_OK : result;
}

void sql_get_text(store *s, statement k, int c, char *room, size_t size) {
  get_text(s->statement[k], c, room, size);
}

int64_t sql_get_long(store *s, statement k, int c) {
  return sqlite3_column_int64(s->statement[k], c);
}

double sql_get_real(store *s, statement k, int c) {
  return sqlite3_column_double(s->statement[k], c);
}

int64_t sql_last_number(const store *s) {
  return sqlite3_last_insert_rowid(s->db);
}

bool sql_is_open(const store *s) {
  return !sqlite3_get_autocommit(s->db);
}

/* The blob of the row a bound statement gives, malloc'ed; never NULL for one of no bytes. */
void *sql_fetch_blob(store *s, statement k, size_t *size) {
  char *copy = NULL;
  if (sql_step(s, k) == STORE_OK && sqlite3_column_type(s->statement[k], 0) == SQLITE_BLOB) {
    const void *bytes = sqlite3_column_blob(s->statement[k], 0);
    *size = (size_t)sqlite3_column_bytes(s->statement[k], 0);
    copy = malloc(*size + 1);
    if (copy != NULL && *size > 0) memcpy(copy, bytes, *size);
  }
  sql_reset(s, k);
  return copy;
}

/* The one number that a bound statement gives; `otherwise` if it gives none. */
double sql_number_of(store *s, statement k, double otherwise) {
  double value = otherwise;
  if (sql_step(s, k) == STORE_OK && sqlite3_column_type(s->statement[k], 0) != SQLITE_NULL) {
    value = sqlite3_column_double(s->statement[k], 0);
  }
  sql_reset(s, k);
  return value;
}

void sql_row(store *s, statement k, const job_row *row) {
  bind_row(s->statement[k], row);
}

/* ---- Opening ---- */

static int version_of(sqlite3 *db) {
  sqlite3_stmt *ask = NULL;
  int version = -1;
  if (sqlite3_prepare_v2(db, "PRAGMA user_version", -1, &ask, NULL) == SQLITE_OK &&
      sqlite3_step(ask) == SQLITE_ROW) {
    version = sqlite3_column_int(ask, 0);
  }
  sqlite3_finalize(ask);
  return version;
}

static bool make_tables(store *s, fault *why) {
  store_text q, all;
  const int version = version_of(s->db);
  if (version == STORE_VERSION) return true;
  if (version != 0) {
    return fault_set(why, "data-dir: its tables are of version %d, needs %d", version,
                     STORE_VERSION);
  }
  store_write_schema(&q);
  snprintf(all.text, sizeof all.text, "BEGIN;%.3900s;PRAGMA user_version=%d;COMMIT", q.text,
           STORE_VERSION);
  return sqlite3_exec(s->db, all.text, NULL, NULL, NULL) == SQLITE_OK;
}

static bool prepare(store *s) {
  store_text q;
  for (int k = 0; k < STATEMENTS; k++) {
    store_write_statement((statement)k, &q);
    const int code =
        sqlite3_prepare_v3(s->db, q.text, -1, SQLITE_PREPARE_PERSISTENT, &s->statement[k], NULL);
    if (code != SQLITE_OK) return false;
  }
  return true;
}

/* Nobody else's to read; its log and index take over its mode. */
static bool make_private(const store *s) {
  const int file = openat(s->directory, STORE_DATABASE, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const bool good = file >= 0 && fchmod(file, 0600) == 0;
  if (file >= 0) close(file);
  return good;
}

bool sql_open(store *s, const char *path, fault *why) {
  char file[4096];
  static const char settings[] = /* not locked for itself: a backup may read */
      "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA temp_store=MEMORY";
  snprintf(file, sizeof file, "%s/" STORE_DATABASE, path);
  *why->text = '\0';
  if (!make_private(s)) return fault_set(why, "data-dir: %.200s: %s", file, strerror(errno));
  if (sqlite3_open_v2(file, &s->db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, NULL) ==
          SQLITE_OK &&
      sqlite3_exec(s->db, settings, NULL, NULL, NULL) == SQLITE_OK && make_tables(s, why) &&
      prepare(s)) {
    return true;
  }
  if (*why->text == '\0') fault_set(why, "data-dir: %.200s: %s", file, sqlite3_errmsg(s->db));
  return false;
}

void sql_close(store *s) {
  for (int k = 0; k < STATEMENTS; k++) sqlite3_finalize(s->statement[k]);
  sqlite3_close(s->db);
}
