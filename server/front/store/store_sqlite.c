/* The only door to SQLite. */
#include <errno.h>
#include <fcntl.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "log.h"
#include "store_sql.h"

typedef struct {
  sqlite3 *db;
  sqlite3_stmt *statement[STATEMENTS_OF_ONE];
} base;

static base *base_of(const store *s) {
  return s->base;
}

static sqlite3_stmt *at(const store *s, statement k) {
  return base_of(s)->statement[k];
}

/* ---- Using statements ---- */

static store_result failure(sqlite3 *db, int code) {
  if ((code & 0xff) == SQLITE_FULL) return STORE_FULL;
  if (store_result_of(sqlite3_system_errno(db)) == STORE_FULL) return STORE_FULL;
  log_say(LOG_ERROR, "store", "%s", sqlite3_errmsg(db));
  return (code & 0xff) == SQLITE_NOMEM ? STORE_DOWN : STORE_FAILED; /* it passes */
}

static store_result step(store *s, statement k) {
  const int code = sqlite3_step(at(s, k));
  if (code == SQLITE_ROW) return STORE_OK;
  if (code == SQLITE_DONE) return STORE_NONE;
  return failure(base_of(s)->db, code);
}

static void reset(store *s, statement k) {
  sqlite3_reset(at(s, k));
  sqlite3_clear_bindings(at(s, k));
}

static void bind_text(store *s, statement k, int place, const char *text) {
  sqlite3_bind_text(at(s, k), place, text, -1, SQLITE_STATIC);
}

static void bind_long(store *s, statement k, int place, int64_t value) {
  sqlite3_bind_int64(at(s, k), place, value);
}

static void bind_real(store *s, statement k, int place, double value) {
  sqlite3_bind_double(at(s, k), place, value);
}

static void bind_bytes(store *s, statement k, int place, const void *bytes, size_t size) {
  sqlite3_bind_blob64(at(s, k), place, bytes, size, SQLITE_STATIC);
}

static int64_t changes(store *s, statement k) {
  (void)k;
  return sqlite3_changes64(base_of(s)->db);
}

static bool is_null(store *s, statement k, int c) {
  return sqlite3_column_type(at(s, k), c) == SQLITE_NULL;
}

static int64_t get_long(store *s, statement k, int c) {
  return sqlite3_column_int64(at(s, k), c);
}

static double get_real(store *s, statement k, int c) {
  return sqlite3_column_double(at(s, k), c);
}

static const void *get_bytes(store *s, statement k, int c, size_t *size) {
  const void *bytes = sqlite3_column_blob(at(s, k), c);
  *size = (size_t)sqlite3_column_bytes(at(s, k), c);
  return bytes;
}

static bool is_open(const store *s) {
  return !sqlite3_get_autocommit(base_of(s)->db);
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

static bool become(store *s, const char *text, int version) {
  char *all = sqlite3_mprintf("BEGIN;%s;PRAGMA user_version=%d;COMMIT", text, version);
  const bool good = all != NULL && sqlite3_exec(base_of(s)->db, all, NULL, NULL, NULL) == SQLITE_OK;
  sqlite3_free(all);
  return good;
}

static bool prepare(base *b) {
  store_text q;
  for (int k = 0; k < STATEMENTS_OF_ONE; k++) {
    store_write_statement(DIALECT_SQLITE, (statement)k, &q);
    const int code =
        sqlite3_prepare_v3(b->db, q.text, -1, SQLITE_PREPARE_PERSISTENT, &b->statement[k], NULL);
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

static bool open_base(store *s, const char *where, fault *why) {
  char file[4096];
  static const char settings[] = /* not locked for itself: a backup may read */
      "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA temp_store=MEMORY";
  base *b = s->base = calloc(1, sizeof *b);
  if (b == NULL) return fault_set(why, "out of memory");
  snprintf(file, sizeof file, "%s/" STORE_DATABASE, where);
  *why->text = '\0';
  if (!make_private(s)) return fault_set(why, "data-dir: %.200s: %s", file, strerror(errno));
  if (sqlite3_open_v2(file, &b->db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, NULL) ==
          SQLITE_OK &&
      sqlite3_exec(b->db, settings, NULL, NULL, NULL) == SQLITE_OK &&
      sql_make_tables(s, version_of(b->db), become, why) && prepare(b)) {
    return true;
  }
  if (*why->text == '\0') fault_set(why, "data-dir: %.200s: %s", file, sqlite3_errmsg(b->db));
  return false;
}

static void close_base(store *s) {
  base *b = s->base;
  for (int k = 0; k < STATEMENTS_OF_ONE; k++) sqlite3_finalize(b->statement[k]);
  sqlite3_close(b->db);
  free(b);
}

const store_door store_sqlite = {
    .dialect = DIALECT_SQLITE,
    .shared = false,
    .open = open_base,
    .close = close_base,
    .bind_text = bind_text,
    .bind_long = bind_long,
    .bind_real = bind_real,
    .bind_bytes = bind_bytes,
    .step = step,
    .reset = reset,
    .changes = changes,
    .is_null = is_null,
    .get_long = get_long,
    .get_real = get_real,
    .get_bytes = get_bytes,
    .is_open = is_open,
};
