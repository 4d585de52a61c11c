#include "store.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <sqlite3.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include "log.h"

/* ---- Tables and statements ---- */

enum { VERSION = 1 }; /* of the tables below; PRAGMA user_version */

typedef enum { TEXT, INT, LONG, REAL } kind;

typedef struct {
  const char *name;
  kind kind;
  size_t offset, size;
} column;

#define COLUMN(member, kind) \
  { #member, kind, offsetof(job_row, member), sizeof(((job_row *)NULL)->member) }

/* All of a row but its number. */
static const column columns[] = {
    COLUMN(id, TEXT),           COLUMN(process, TEXT),
    COLUMN(submitter, TEXT),    COLUMN(state, INT),
    COLUMN(priority, INT),      COLUMN(attempts, INT),
    COLUMN(progress, INT),      COLUMN(status, INT),
    COLUMN(content, INT),       COLUMN(content_coding, INT),
    COLUMN(size, LONG),         COLUMN(points, LONG),
    COLUMN(estimate, LONG),     COLUMN(result_size, LONG),
    COLUMN(created, REAL),      COLUMN(started, REAL),
    COLUMN(finished, REAL),     COLUMN(updated, REAL),
    COLUMN(expires, REAL),      COLUMN(parent, LONG),
    COLUMN(part, INT),          COLUMN(parts, INT),
    COLUMN(offset, LONG),       COLUMN(reusable, INT),
    COLUMN(result_coding, INT), COLUMN(subscribed, INT),
    COLUMN(message, TEXT),
};

enum { COLUMNS = sizeof columns / sizeof *columns };

static const char *const types[] = {
    [TEXT] = "TEXT", [INT] = "INTEGER", [LONG] = "INTEGER", [REAL] = "REAL"};

/* {columns} is their list, {values} as many parameters, {settings} name = parameter, {definitions}
 * name and type; parameter k is column k, what follows has names. */
static const char schema[] =
    "CREATE TABLE jobs(number INTEGER PRIMARY KEY AUTOINCREMENT, {definitions}, key TEXT, digest "
    "TEXT, success TEXT, running TEXT, failed TEXT, base TEXT, problem BLOB);"
    "CREATE UNIQUE INDEX jobs_id ON jobs(id);"
    "CREATE INDEX jobs_parent ON jobs(parent, part) WHERE parent > 0;"
    "CREATE INDEX jobs_finished ON jobs(parent, finished) WHERE parent > 0;"
    "CREATE INDEX jobs_active ON jobs(number) WHERE state <= 1;"
    "CREATE INDEX jobs_expires ON jobs(expires) WHERE expires > 0;"
    "CREATE INDEX jobs_key ON jobs(submitter, key) WHERE key <> '';"
    "CREATE INDEX jobs_digest ON jobs(digest) WHERE digest <> '';"
    "CREATE TABLE calls(number INTEGER PRIMARY KEY AUTOINCREMENT, job INTEGER, kind INTEGER, "
    "attempts INTEGER, due REAL);"
    "CREATE TABLE small(job INTEGER, kind INTEGER, bytes BLOB, PRIMARY KEY(job, kind)) "
    "WITHOUT ROWID;"
    "CREATE TABLE log(job INTEGER, time REAL, text TEXT);"
    "CREATE INDEX log_job ON log(job);"
    "CREATE TABLE data(id TEXT PRIMARY KEY, type TEXT, size INTEGER, created REAL, expires REAL);"
    "CREATE INDEX data_expires ON data(expires);"
    "CREATE TABLE pins(data TEXT, job INTEGER);"
    "CREATE INDEX pins_data ON pins(data);"
    "CREATE INDEX pins_job ON pins(job);";

typedef enum {
  BEGIN,
  COMMIT,
  ROLLBACK,
  ADD,
  UPDATE,
  SET_PROBLEM,
  JOB,
  JOB_NUMBER,
  PART,
  NEXT_ENDED,
  PROBLEM,
  EXTRA,
  BY_KEY,
  KEY_DIGEST,
  BY_DIGEST,
  REMOVE,
  REMOVE_LOG,
  ACTIVE,
  EXPIRED,
  FIRST_EXPIRY,
  PART_STATES,
  LIST,
  ADD_CALL,
  CALLS,
  UPDATE_CALL,
  REMOVE_CALL,
  REMOVE_CALLS,
  ADD_SMALL,
  SMALL,
  DROP_SMALL,
  REMOVE_SMALL,
  LOG,
  READ_LOG,
  ADD_DATA,
  DATA,
  DATA_BYTES,
  RENEW_DATA,
  DATA_PINNED,
  DATA_EXPIRED,
  DATA_FIRST_EXPIRY,
  REMOVE_DATA,
  PIN,
  UNPIN,
  STATEMENTS
} statement;

static const char *const statements[STATEMENTS] = {
    [BEGIN] = "BEGIN IMMEDIATE",
    [COMMIT] = "COMMIT",
    [ROLLBACK] = "ROLLBACK",
    [ADD] =
        "INSERT INTO jobs({columns}, key, digest, success, running, failed) "
        "VALUES({values}, :key, :digest, :success, :running, :failed)",
    [UPDATE] = "UPDATE jobs SET {settings} WHERE number = :number",
    [SET_PROBLEM] = "UPDATE jobs SET problem = :problem WHERE number = :number",
    [JOB] = "SELECT {columns}, number FROM jobs WHERE id = :id",
    [JOB_NUMBER] = "SELECT {columns}, number FROM jobs WHERE number = :number",
    [PART] =
        "SELECT {columns}, number FROM jobs WHERE parent = :number AND part = :part "
        "AND parent > 0",
    [NEXT_ENDED] =
        "SELECT {columns}, number FROM jobs WHERE parent = :number AND parent > 0 "
        "AND state >= 2 AND finished > :after ORDER BY finished LIMIT 1",
    [PROBLEM] = "SELECT problem FROM jobs WHERE number = :number",
    [EXTRA] = "SELECT key, digest, success, running, failed, base FROM jobs WHERE number = :number",
    [BY_KEY] =
        "SELECT {columns}, number FROM jobs WHERE submitter = :submitter AND key = :key "
        "AND key <> '' ORDER BY number DESC LIMIT 1",
    [KEY_DIGEST] = "SELECT digest FROM jobs WHERE number = :number",
    [BY_DIGEST] =
        "SELECT {columns}, number FROM jobs WHERE digest = :digest AND digest <> '' "
        "AND reusable AND state = 2 AND expires > :until ORDER BY number DESC LIMIT 1",
    [REMOVE] = "DELETE FROM jobs WHERE number = :number OR (parent = :number AND parent > 0)",
    [REMOVE_LOG] = "DELETE FROM log WHERE job = :number",
    [ACTIVE] = "SELECT {columns}, number FROM jobs WHERE state <= 1 ORDER BY number",
    [EXPIRED] =
        "SELECT {columns}, number FROM jobs WHERE expires > 0 AND expires <= :now "
        "LIMIT 100",
    [FIRST_EXPIRY] = "SELECT min(expires) FROM jobs WHERE expires > 0",
    [PART_STATES] =
        "SELECT state, count(*) FROM jobs WHERE parent = :number AND parent > 0 "
        "GROUP BY state",
    [LIST] =
        "SELECT {columns}, number FROM jobs "
        "WHERE (:processes = '' OR instr(:processes, ',' || process || ',') > 0) "
        "AND (:states >> state) & 1 AND created BETWEEN :created_least AND :created_most "
        "AND (NOT :timed OR (started > 0 AND "
        "iif(finished > 0, finished, :now) - started BETWEEN :seconds_least AND :seconds_most)) "
        "AND parent = :parent ORDER BY number DESC LIMIT :limit OFFSET :offset",
    [ADD_CALL] = "INSERT INTO calls(job, kind, attempts, due) VALUES(:number, :kind, 0, :due)",
    [CALLS] = "SELECT number, job, kind, attempts, due FROM calls ORDER BY due LIMIT :limit",
    [UPDATE_CALL] = "UPDATE calls SET attempts = :attempts, due = :due WHERE number = :number",
    [REMOVE_CALL] = "DELETE FROM calls WHERE number = :number",
    [REMOVE_CALLS] = "DELETE FROM calls WHERE job = :number",
    [ADD_SMALL] = "INSERT OR REPLACE INTO small(job, kind, bytes) VALUES(:number, :kind, :bytes)",
    [SMALL] = "SELECT bytes FROM small WHERE job = :number AND kind = :kind",
    [DROP_SMALL] = "DELETE FROM small WHERE job = :number AND (kind = :kind OR :kind < 0)",
    [REMOVE_SMALL] =
        "DELETE FROM small WHERE job = :number OR job IN "
        "(SELECT number FROM jobs WHERE parent = :number AND parent > 0)",
    [LOG] = "INSERT INTO log VALUES(:number, :time, :text)",
    [READ_LOG] =
        "SELECT time, text FROM (SELECT rowid, time, text FROM log WHERE job = :number "
        "ORDER BY rowid DESC LIMIT :limit) ORDER BY rowid",
    [ADD_DATA] = "INSERT INTO data VALUES(:id, :type, :size, :created, :expires)",
    [DATA] = "SELECT type, size, created, expires FROM data WHERE id = :id",
    [DATA_BYTES] = "SELECT total(size) FROM data",
    [RENEW_DATA] = "UPDATE data SET expires = max(expires, :expires) WHERE id = :id",
    [DATA_PINNED] =
        "SELECT 1 FROM pins JOIN jobs ON number = job WHERE data = :id AND state <= 1 LIMIT 1",
    [DATA_EXPIRED] =
        "SELECT id FROM data WHERE expires <= :now AND NOT EXISTS(SELECT 1 FROM pins JOIN "
        "jobs ON number = job WHERE data = data.id AND state <= 1) LIMIT 1",
    [DATA_FIRST_EXPIRY] = "SELECT min(expires) FROM data",
    [REMOVE_DATA] = "DELETE FROM data WHERE id = :id",
    [PIN] = "INSERT INTO pins VALUES(:id, :number)",
    [UNPIN] = "DELETE FROM pins WHERE job = :number",
};

struct store {
  sqlite3 *db;
  sqlite3_stmt *statement[STATEMENTS];
  int directory, files, data, lock;
};

/* ---- SQL from the tables ---- */

typedef struct {
  size_t used;
  char text[4096];
} sql;

static void add(sql *q, const char *format, const char *a, const char *b) {
  const int length = snprintf(q->text + q->used, sizeof q->text - q->used, format, a, b);
  q->used += (size_t)length;
  if (q->used >= sizeof q->text) abort(); /* the tables above outgrew the room */
}

static const struct {
  const char *mark, *format; /* name and type of a column */
} marks[] = {
    {"{columns}", "%s"}, {"{values}", "?"}, {"{settings}", "%s=?"}, {"{definitions}", "%s %s"}};

/* The template with the lists of columns for its marks. */
static void write_sql(const char *template, sql *q) {
  q->used = 0;
  while (*template != '\0') {
    size_t k = 0;
    while (k < 4 && strncmp(template, marks[k].mark, strlen(marks[k].mark)) != 0) k++;
    if (k == 4) {
      add(q, "%.1s", template ++, "");
      continue;
    }
    for (int c = 0; c < COLUMNS; c++) {
      if (c > 0) add(q, ", ", "", "");
      add(q, marks[k].format, columns[c].name, types[columns[c].kind]);
    }
    template += strlen(marks[k].mark);
  }
}

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
static store_result step(store *s, statement k) {
  const int code = sqlite3_step(s->statement[k]);
  if (code == SQLITE_ROW) return STORE_OK;
  if (code == SQLITE_DONE) return STORE_NONE;
  return failure(s, code);
}

static void reset(store *s, statement k) {
  sqlite3_reset(s->statement[k]);
  sqlite3_clear_bindings(s->statement[k]);
}

/* Runs a statement that gives no rows. */
static store_result run(store *s, statement k) {
  store_result result = step(s, k);
  reset(s, k);
  return result == STORE_NONE ? STORE_OK : result;
}

static int place(store *s, statement k, const char *name) {
  return sqlite3_bind_parameter_index(s->statement[k], name);
}

static void bind_text(store *s, statement k, const char *name, const char *text) {
  sqlite3_bind_text(s->statement[k], place(s, k, name), text, -1, SQLITE_STATIC);
}

static void bind_long(store *s, statement k, const char *name, int64_t value) {
  sqlite3_bind_int64(s->statement[k], place(s, k, name), value);
}

static void bind_real(store *s, statement k, const char *name, double value) {
  sqlite3_bind_double(s->statement[k], place(s, k, name), value);
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
  for (int c = 0; c < COLUMNS; c++) {
    kinds[columns[c].kind].put(to, c + 1, (const char *)row + columns[c].offset);
  }
}

static void get_row(sqlite3_stmt *from, job_row *row) {
  *row = (job_row){.number = sqlite3_column_int64(from, COLUMNS)};
  for (int c = 0; c < COLUMNS; c++) {
    kinds[columns[c].kind].get(from, c, (char *)row + columns[c].offset, columns[c].size);
  }
}

/* The one row a bound statement gives. */
static store_result fetch(store *s, statement k, job_row *row) {
  const store_result result = step(s, k);
  if (result == STORE_OK) get_row(s->statement[k], row);
  reset(s, k);
  return result;
}

static store_result visit_all(store *s, statement k, store_visit *visit, void *context) {
  job_row row;
  store_result result;
  while ((result = step(s, k)) == STORE_OK) {
    get_row(s->statement[k], &row);
    if (!visit(context, &row)) break;
  }
  reset(s, k);
  return result == STORE_NONE ? STORE_OK : result;
}

/* ---- Opening ---- */

static bool lock_directory(store *s, const char *path, fault *why) {
  s->directory = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (s->directory < 0) {
    return fault_set(why, "data-dir: cannot open %.200s: %s", path, strerror(errno));
  }
  s->lock = openat(s->directory, "lock", O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (s->lock < 0) return fault_set(why, "data-dir: cannot lock %.200s: %s", path, strerror(errno));
  if (flock(s->lock, LOCK_EX | LOCK_NB) == 0) return true;
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
  sql q, all;
  const int version = version_of(s->db);
  if (version == VERSION) return true;
  if (version != 0) {
    return fault_set(why, "data-dir: its tables are of version %d, needs %d", version, VERSION);
  }
  write_sql(schema, &q);
  snprintf(all.text, sizeof all.text, "BEGIN;%.3900s;PRAGMA user_version=%d;COMMIT", q.text,
           VERSION);
  return sqlite3_exec(s->db, all.text, NULL, NULL, NULL) == SQLITE_OK;
}

static bool prepare(store *s) {
  sql q;
  for (int k = 0; k < STATEMENTS; k++) {
    write_sql(statements[k], &q);
    const int code =
        sqlite3_prepare_v3(s->db, q.text, -1, SQLITE_PREPARE_PERSISTENT, &s->statement[k], NULL);
    if (code != SQLITE_OK) return false;
  }
  return true;
}

static bool open_tables(store *s, const char *path, fault *why) {
  char file[4096];
  static const char settings[] =
      "PRAGMA journal_mode=WAL; PRAGMA synchronous=FULL; PRAGMA locking_mode=EXCLUSIVE;"
      "PRAGMA temp_store=MEMORY";
  snprintf(file, sizeof file, "%s/" STORE_DATABASE, path);
  *why->text = '\0';
  if (sqlite3_open_v2(file, &s->db, SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE, NULL) ==
          SQLITE_OK &&
      sqlite3_exec(s->db, settings, NULL, NULL, NULL) == SQLITE_OK && make_tables(s, why) &&
      prepare(s)) {
    return true;
  }
  if (*why->text == '\0') fault_set(why, "data-dir: %.200s: %s", file, sqlite3_errmsg(s->db));
  return false;
}

store *store_open(const char *directory, fault *why) {
  store *s = calloc(1, sizeof *s);
  if (s == NULL) {
    fault_set(why, "out of memory");
    return NULL;
  }
  s->directory = s->files = s->data = s->lock = -1;
  if (!lock_directory(s, directory, why) || !open_files(s, why) ||
      !open_tables(s, directory, why)) {
    store_close(&s);
  }
  return s;
}

void store_close(store **s) {
  if (*s == NULL) return;
  for (int k = 0; k < STATEMENTS; k++) sqlite3_finalize((*s)->statement[k]);
  sqlite3_close((*s)->db);
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
  return run(s, BEGIN);
}

store_result store_commit(store *s) {
  return run(s, COMMIT);
}

void store_rollback(store *s) {
  if (!sqlite3_get_autocommit(s->db)) (void)run(s, ROLLBACK); /* some failures do so themselves */
}

/* ---- Jobs ---- */

static const char *const uris[] = {":success", ":running", ":failed"};

store_result store_add(store *s, job_row *row, const job_extra *extra) {
  bind_row(s->statement[ADD], row);
  bind_text(s, ADD, ":key", extra->key);
  bind_text(s, ADD, ":digest", extra->digest);
  bind_text(s, ADD, ":base", extra->base);
  for (int k = 0; k < 3; k++) bind_text(s, ADD, uris[k], extra->uri[k]);
  store_result result = run(s, ADD);
  if (result == STORE_OK) row->number = sqlite3_last_insert_rowid(s->db);
  for (int k = 0; k < JOB_PINS && *extra->pin[k] != '\0' && result == STORE_OK; k++) {
    bind_text(s, PIN, ":id", extra->pin[k]);
    bind_long(s, PIN, ":number", row->number);
    result = run(s, PIN);
  }
  return result;
}

store_result store_update(store *s, const job_row *row, const void *problem, size_t size) {
  bind_row(s->statement[UPDATE], row);
  bind_long(s, UPDATE, ":number", row->number);
  const store_result result = run(s, UPDATE);
  if (result != STORE_OK || problem == NULL) return result;
  bind_long(s, SET_PROBLEM, ":number", row->number);
  sqlite3_bind_blob64(s->statement[SET_PROBLEM], place(s, SET_PROBLEM, ":problem"), problem, size,
                      SQLITE_STATIC);
  return run(s, SET_PROBLEM);
}

store_result store_job(store *s, const char *id, job_row *row) {
  bind_text(s, JOB, ":id", id);
  return fetch(s, JOB, row);
}

store_result store_job_number(store *s, int64_t number, job_row *row) {
  bind_long(s, JOB_NUMBER, ":number", number);
  return fetch(s, JOB_NUMBER, row);
}

store_result store_part(store *s, int64_t parent, int part, job_row *row) {
  bind_long(s, PART, ":number", parent);
  bind_long(s, PART, ":part", part);
  return fetch(s, PART, row);
}

store_result store_next_ended(store *s, int64_t parent, double after, job_row *row) {
  bind_long(s, NEXT_ENDED, ":number", parent);
  bind_real(s, NEXT_ENDED, ":after", after);
  return fetch(s, NEXT_ENDED, row);
}

/* The blob of the row a bound statement gives, malloc'ed; never NULL for one of no bytes. */
static void *fetch_blob(store *s, statement k, size_t *size) {
  char *copy = NULL;
  if (step(s, k) == STORE_OK && sqlite3_column_type(s->statement[k], 0) == SQLITE_BLOB) {
    const void *bytes = sqlite3_column_blob(s->statement[k], 0);
    *size = (size_t)sqlite3_column_bytes(s->statement[k], 0);
    copy = malloc(*size + 1);
    if (copy != NULL && *size > 0) memcpy(copy, bytes, *size);
  }
  reset(s, k);
  return copy;
}

void *store_problem(store *s, int64_t number, size_t *size) {
  bind_long(s, PROBLEM, ":number", number);
  return fetch_blob(s, PROBLEM, size);
}

store_result store_extra(store *s, int64_t number, job_extra *extra) {
  bind_long(s, EXTRA, ":number", number);
  const store_result result = step(s, EXTRA);
  if (result == STORE_OK) {
    get_text(s->statement[EXTRA], 0, extra->key, sizeof extra->key);
    get_text(s->statement[EXTRA], 1, extra->digest, sizeof extra->digest);
    for (int k = 0; k < 3; k++) get_text(s->statement[EXTRA], 2 + k, extra->uri[k], JOB_URI);
    get_text(s->statement[EXTRA], 5, extra->base, sizeof extra->base);
  }
  reset(s, EXTRA);
  return result;
}

store_result store_by_key(store *s, const char *submitter, const char *key, job_row *row,
                          char digest[JOB_DIGEST]) {
  bind_text(s, BY_KEY, ":submitter", submitter);
  bind_text(s, BY_KEY, ":key", key);
  store_result result = fetch(s, BY_KEY, row);
  if (result != STORE_OK) return result;
  bind_long(s, KEY_DIGEST, ":number", row->number);
  result = step(s, KEY_DIGEST);
  if (result == STORE_OK) get_text(s->statement[KEY_DIGEST], 0, digest, JOB_DIGEST);
  reset(s, KEY_DIGEST);
  return result;
}

store_result store_by_digest(store *s, const char *digest, double until, job_row *row) {
  bind_text(s, BY_DIGEST, ":digest", digest);
  bind_real(s, BY_DIGEST, ":until", until);
  return fetch(s, BY_DIGEST, row);
}

store_result store_remove(store *s, int64_t number) {
  bind_long(s, REMOVE_SMALL, ":number", number);
  store_result result = run(s, REMOVE_SMALL);
  bind_long(s, REMOVE, ":number", number);
  if (result == STORE_OK) result = run(s, REMOVE);
  if (result != STORE_OK) return result;
  bind_long(s, REMOVE_LOG, ":number", number);
  bind_long(s, REMOVE_CALLS, ":number", number);
  bind_long(s, UNPIN, ":number", number);
  const store_result calls = run(s, REMOVE_CALLS), lines = run(s, REMOVE_LOG);
  const store_result pins = run(s, UNPIN);
  return calls != STORE_OK ? calls : lines != STORE_OK ? lines : pins;
}

store_result store_part_states(store *s, int64_t parent, int64_t count[JOB_STATES]) {
  store_result result;
  memset(count, 0, JOB_STATES * sizeof *count);
  bind_long(s, PART_STATES, ":number", parent);
  while ((result = step(s, PART_STATES)) == STORE_OK) {
    const int state = sqlite3_column_int(s->statement[PART_STATES], 0);
    if (state >= 0 && state < JOB_STATES) {
      count[state] = sqlite3_column_int64(s->statement[PART_STATES], 1);
    }
  }
  reset(s, PART_STATES);
  return result == STORE_NONE ? STORE_OK : result;
}

store_result store_active(store *s, store_visit *visit, void *context) {
  return visit_all(s, ACTIVE, visit, context);
}

store_result store_expired(store *s, double now, store_visit *visit, void *context) {
  bind_real(s, EXPIRED, ":now", now);
  return visit_all(s, EXPIRED, visit, context);
}

double store_first_expiry(store *s) {
  double first = INFINITY;
  if (step(s, FIRST_EXPIRY) == STORE_OK &&
      sqlite3_column_type(s->statement[FIRST_EXPIRY], 0) != SQLITE_NULL) {
    first = sqlite3_column_double(s->statement[FIRST_EXPIRY], 0);
  }
  reset(s, FIRST_EXPIRY);
  return first;
}

store_result store_list(store *s, const store_filter *f, store_visit *visit, void *context) {
  bind_text(s, LIST, ":processes", f->processes);
  bind_long(s, LIST, ":states", f->states);
  bind_real(s, LIST, ":created_least", f->created_least);
  bind_real(s, LIST, ":created_most", f->created_most);
  bind_real(s, LIST, ":seconds_least", f->seconds_least);
  bind_real(s, LIST, ":seconds_most", f->seconds_most);
  bind_long(s, LIST, ":timed", f->timed);
  bind_long(s, LIST, ":parent", f->has_parent ? f->parent : 0);
  bind_real(s, LIST, ":now", f->now);
  bind_long(s, LIST, ":limit", f->limit);
  bind_long(s, LIST, ":offset", f->offset);
  return visit_all(s, LIST, visit, context);
}

/* ---- Calls to subscribers ---- */

store_result store_add_call(store *s, int64_t job, int address, double when) {
  bind_long(s, ADD_CALL, ":number", job);
  bind_long(s, ADD_CALL, ":kind", address);
  bind_real(s, ADD_CALL, ":due", when);
  return run(s, ADD_CALL);
}

store_result store_calls(store *s, int most, store_call *visit, void *context) {
  sqlite3_stmt *from = s->statement[CALLS];
  store_result result;
  bind_long(s, CALLS, ":limit", most);
  while ((result = step(s, CALLS)) == STORE_OK) {
    const job_call call = {sqlite3_column_int64(from, 0), sqlite3_column_int64(from, 1),
                           sqlite3_column_int(from, 2), sqlite3_column_int(from, 3),
                           sqlite3_column_double(from, 4)};
    visit(context, &call);
  }
  reset(s, CALLS);
  return result == STORE_NONE ? STORE_OK : result;
}

store_result store_update_call(store *s, const job_call *call) {
  bind_long(s, UPDATE_CALL, ":number", call->number);
  bind_long(s, UPDATE_CALL, ":attempts", call->attempts);
  bind_real(s, UPDATE_CALL, ":due", call->due);
  return run(s, UPDATE_CALL);
}

store_result store_remove_call(store *s, int64_t number) {
  bind_long(s, REMOVE_CALL, ":number", number);
  return run(s, REMOVE_CALL);
}

/* ---- Small bytes of jobs ---- */

store_result store_add_small(store *s, int64_t job, int which, const void *bytes, size_t size) {
  sqlite3_stmt *to = s->statement[ADD_SMALL];
  bind_long(s, ADD_SMALL, ":number", job);
  bind_long(s, ADD_SMALL, ":kind", which);
  sqlite3_bind_blob64(to, place(s, ADD_SMALL, ":bytes"), bytes, size, SQLITE_STATIC);
  return run(s, ADD_SMALL);
}

void *store_small(store *s, int64_t job, int which, size_t *size) {
  bind_long(s, SMALL, ":number", job);
  bind_long(s, SMALL, ":kind", which);
  return fetch_blob(s, SMALL, size);
}

store_result store_drop_small(store *s, int64_t job, int which) {
  bind_long(s, DROP_SMALL, ":number", job);
  bind_long(s, DROP_SMALL, ":kind", which);
  return run(s, DROP_SMALL);
}

/* ---- Log of a job ---- */

store_result store_log(store *s, int64_t number, double time, const char *text) {
  bind_long(s, LOG, ":number", number);
  bind_real(s, LOG, ":time", time);
  bind_text(s, LOG, ":text", text);
  return run(s, LOG);
}

store_result store_read_log(store *s, int64_t number, int most, store_line *visit, void *context) {
  store_result result;
  bind_long(s, READ_LOG, ":number", number);
  bind_long(s, READ_LOG, ":limit", most);
  while ((result = step(s, READ_LOG)) == STORE_OK) {
    char text[512];
    get_text(s->statement[READ_LOG], 1, text, sizeof text);
    visit(context, sqlite3_column_double(s->statement[READ_LOG], 0), text);
  }
  reset(s, READ_LOG);
  return result == STORE_NONE ? STORE_OK : result;
}

/* ---- Data ---- */

int store_data_files(const store *s) {
  return s->data;
}

store_result store_data_add(store *s, const data_row *row) {
  bind_text(s, ADD_DATA, ":id", row->id);
  bind_text(s, ADD_DATA, ":type", row->type);
  bind_long(s, ADD_DATA, ":size", row->size);
  bind_real(s, ADD_DATA, ":created", row->created);
  bind_real(s, ADD_DATA, ":expires", row->expires);
  return run(s, ADD_DATA);
}

store_result store_data(store *s, const char *id, data_row *row) {
  *row = (data_row){0};
  snprintf(row->id, sizeof row->id, "%s", id);
  bind_text(s, DATA, ":id", id);
  const store_result result = step(s, DATA);
  if (result == STORE_OK) {
    sqlite3_stmt *from = s->statement[DATA];
    get_text(from, 0, row->type, sizeof row->type);
    row->size = sqlite3_column_int64(from, 1);
    row->created = sqlite3_column_double(from, 2);
    row->expires = sqlite3_column_double(from, 3);
  }
  reset(s, DATA);
  return result;
}

/* The one number that a bound statement gives; `otherwise` if it gives none. */
static double number_of(store *s, statement k, double otherwise) {
  double value = otherwise;
  if (step(s, k) == STORE_OK && sqlite3_column_type(s->statement[k], 0) != SQLITE_NULL) {
    value = sqlite3_column_double(s->statement[k], 0);
  }
  reset(s, k);
  return value;
}

int64_t store_data_bytes(store *s) {
  return (int64_t)number_of(s, DATA_BYTES, 0);
}

store_result store_data_renew(store *s, const char *id, double expires) {
  bind_text(s, RENEW_DATA, ":id", id);
  bind_real(s, RENEW_DATA, ":expires", expires);
  return run(s, RENEW_DATA);
}

bool store_data_is_pinned(store *s, const char *id) {
  bind_text(s, DATA_PINNED, ":id", id);
  return number_of(s, DATA_PINNED, 0) > 0;
}

store_result store_data_expired(store *s, double now, char id[DATA_ID]) {
  bind_real(s, DATA_EXPIRED, ":now", now);
  const store_result result = step(s, DATA_EXPIRED);
  if (result == STORE_OK) get_text(s->statement[DATA_EXPIRED], 0, id, DATA_ID);
  reset(s, DATA_EXPIRED);
  return result;
}

double store_data_first_expiry(store *s) {
  return number_of(s, DATA_FIRST_EXPIRY, INFINITY);
}

store_result store_data_remove(store *s, const char *id) {
  bind_text(s, REMOVE_DATA, ":id", id);
  return run(s, REMOVE_DATA);
}
