#include "store_tables.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "job_row.h"

#define COLUMN(member, kind) \
  { #member, kind, offsetof(job_row, member), sizeof(((job_row *)NULL)->member) }

/* All of a row but its number. */
const column store_columns[] = {
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

_Static_assert(sizeof store_columns / sizeof *store_columns == STORE_COLUMNS, "all of them");

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
    [SHIFT_JOBS] = "UPDATE jobs SET expires = expires + :by WHERE expires > 0",
    [SHIFT_CALLS] = "UPDATE calls SET due = due + :by",
    [SHIFT_DATA] = "UPDATE data SET expires = expires + :by",
};

static void add(store_text *q, const char *format, const char *a, const char *b) {
  const int length = snprintf(q->text + q->used, sizeof q->text - q->used, format, a, b);
  q->used += (size_t)length;
  if (q->used >= sizeof q->text) abort(); /* the tables above outgrew the room */
}

static const struct {
  const char *mark, *format; /* name and type of a column */
} marks[] = {
    {"{columns}", "%s"}, {"{values}", "?"}, {"{settings}", "%s=?"}, {"{definitions}", "%s %s"}};

/* The template with the lists of columns for its marks. */
static void write_sql(const char *template, store_text *q) {
  q->used = 0;
  while (*template != '\0') {
    size_t k = 0;
    while (k < 4 && strncmp(template, marks[k].mark, strlen(marks[k].mark)) != 0) k++;
    if (k == 4) {
      add(q, "%.1s", template ++, "");
      continue;
    }
    for (int c = 0; c < STORE_COLUMNS; c++) {
      if (c > 0) add(q, ", ", "", "");
      add(q, marks[k].format, store_columns[c].name, types[store_columns[c].kind]);
    }
    template += strlen(marks[k].mark);
  }
}

void store_write_schema(store_text *q) {
  write_sql(schema, q);
}

void store_write_statement(statement k, store_text *q) {
  write_sql(statements[k], q);
}
