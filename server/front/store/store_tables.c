#include "store_tables.h"

#include <stdarg.h>
#include <stdbool.h>
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
    COLUMN(message, TEXT),      COLUMN(holder, TEXT),
    COLUMN(phase, TEXT),        COLUMN(residual, REAL),
};

_Static_assert(sizeof store_columns / sizeof *store_columns == STORE_COLUMNS, "all of them");

static const char *const types[DIALECTS][4] = {
    [DIALECT_SQLITE] = {[TEXT] = "TEXT", [INT] = "INTEGER", [LONG] = "INTEGER", [REAL] = "REAL"},
    [DIALECT_POSTGRES] = {
        [TEXT] = "TEXT", [INT] = "INTEGER", [LONG] = "BIGINT", [REAL] = "DOUBLE PRECISION"}};

/* Words that the dialects do not share. */
static const struct {
  const char *mark, *word[DIALECTS];
} words[] = {
    {"{begin}", {"BEGIN IMMEDIATE", "BEGIN"}},
    {"{number}",
     {"number INTEGER PRIMARY KEY AUTOINCREMENT",
      "number BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY"}},
    {"{line}", {"rowid", "number"}}, /* the order in which lines of a log came */
    {"{line definition}", {"", "number BIGINT GENERATED ALWAYS AS IDENTITY, "}},
    {"{compact}", {" WITHOUT ROWID", ""}},
    {"{long}", {"INTEGER", "BIGINT"}},
    {"{real}", {"REAL", "DOUBLE PRECISION"}},
    {"{bytes}", {"BLOB", "BYTEA"}},
    {"{place in}", {"instr", "strpos"}},
    {"{greater of}", {"max", "greatest"}},
    {"{waiting}", {"", "state = 0 AND holder = '' AND parts = 0"}},
    {"{alive}",
     {"",
      "EXISTS(SELECT 1 FROM daemons WHERE id = holder AND beat {within a lease}) "
      "OR pg_postmaster_start_time() BETWEEN clock_timestamp() - make_interval(secs => :lease) "
      "AND clock_timestamp()"}},
    {"{within a lease}", /* both ways: the server's clock may have been set back */
     {"",
      "BETWEEN clock_timestamp() - make_interval(secs => :lease) "
      "AND clock_timestamp() + make_interval(secs => :lease)"}},
    {"{no wait for the disk}", {"", "set_config('synchronous_commit', 'off', true)"}},
};

/* {columns} is their list, {values} as many parameters, {settings} name = parameter, {definitions}
 * name and type; parameter k is column k, what follows has names. */
static const char schema[] =
    "CREATE TABLE jobs({number}, {definitions}, key TEXT, digest TEXT, success TEXT, running TEXT, "
    "failed TEXT, base TEXT, problem {bytes});"
    "CREATE UNIQUE INDEX jobs_id ON jobs(id);"
    "CREATE INDEX jobs_parent ON jobs(parent, part) WHERE parent > 0;"
    "CREATE INDEX jobs_finished ON jobs(parent, finished) WHERE parent > 0;"
    "CREATE INDEX jobs_active ON jobs(number) WHERE state <= 1;"
    "CREATE INDEX jobs_expires ON jobs(expires) WHERE expires > 0;"
    "CREATE INDEX jobs_digest ON jobs(digest) WHERE digest <> '';"
    "CREATE TABLE calls({number}, job {long}, kind INTEGER, attempts INTEGER, due {real}, holder "
    "TEXT DEFAULT '');"
    "CREATE TABLE small(job {long}, kind INTEGER, bytes {bytes}, PRIMARY KEY(job, kind)){compact};"
    "CREATE TABLE log({line definition}job {long}, time {real}, text TEXT);"
    "CREATE INDEX log_job ON log(job);"
    "CREATE TABLE data(id TEXT PRIMARY KEY, type TEXT, size {long}, created {real}, expires "
    "{real}, owner TEXT DEFAULT '');"
    "CREATE INDEX data_expires ON data(expires);"
    "CREATE TABLE pins(data TEXT, job {long});"
    "CREATE INDEX pins_data ON pins(data);"
    "CREATE INDEX pins_job ON pins(job);";

/* What only several daemons on one database need: there a key is unique because it must be. */
static const char *const more_schema[DIALECTS] = {
    [DIALECT_SQLITE] = "CREATE INDEX jobs_key ON jobs(submitter, key) WHERE key <> '';",
    [DIALECT_POSTGRES] =
        "CREATE UNIQUE INDEX jobs_key ON jobs(submitter, key) WHERE key <> '';"
        "CREATE INDEX jobs_waiting ON jobs(priority, submitter, number) WHERE {waiting};"
        "CREATE INDEX jobs_held ON jobs(holder) WHERE holder <> '';"
        "CREATE INDEX jobs_batches ON jobs(number) WHERE parts > 0 AND state <= 1;"
        "CREATE INDEX jobs_parts ON jobs(parent) WHERE parent > 0 AND state <= 1;"
        "CREATE TABLE daemons(id TEXT PRIMARY KEY, beat TIMESTAMPTZ);"
        "CREATE TABLE turns(submitter TEXT PRIMARY KEY, last TIMESTAMPTZ);"
        "CREATE TABLE large(owner TEXT, kind INTEGER, chunk INTEGER, bytes BYTEA, "
        "PRIMARY KEY(owner, kind, chunk));"
        "ALTER TABLE large ALTER bytes SET STORAGE EXTERNAL;",
};

/* Step k makes version k + 1 of version k. */
static const char *const steps[STORE_VERSION] = {
    [1] =
        "ALTER TABLE jobs ADD COLUMN holder TEXT DEFAULT '';"
        "ALTER TABLE calls ADD COLUMN holder TEXT DEFAULT '';"
        "ALTER TABLE jobs ADD COLUMN phase TEXT DEFAULT '';"
        "ALTER TABLE jobs ADD COLUMN residual {real} DEFAULT 0;"
        "ALTER TABLE data ADD COLUMN owner TEXT DEFAULT '';",
};

static const char *const statements[STATEMENTS] = {
    [BEGIN] = "{begin}",
    [COMMIT] = "COMMIT",
    [ROLLBACK] = "ROLLBACK",
    [ADD] =
        "INSERT INTO jobs({columns}, key, digest, success, running, failed, base) "
        "VALUES({values}, :key, :digest, :success, :running, :failed, :base) RETURNING number",
    [UPDATE] = "UPDATE jobs SET {settings} WHERE number = :number AND holder = :held",
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
        "AND reusable = 1 AND state = 2 AND expires > :until AND (:owner = '' OR submitter = "
        ":owner) "
        "ORDER BY number DESC LIMIT 1",
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
    [JOB_BYTES] =
        "SELECT CAST(coalesce(sum(CASE WHEN state <= 1 AND parent = 0 THEN size WHEN state = 2 "
        "THEN "
        "result_size ELSE 0 END), 0) AS {long}) FROM jobs WHERE :owner = '' OR submitter = :owner",
    [LIST] =
        "SELECT {columns}, number FROM jobs "
        "WHERE (:processes = '' OR {place in}(:processes, ',' || process || ',') > 0) "
        "AND (CAST(:states AS {long}) >> state) & 1 = 1 AND created BETWEEN :created_least AND "
        ":created_most "
        "AND (:timed = 0 OR (started > 0 AND "
        "CASE WHEN finished > 0 THEN finished ELSE :now END - started BETWEEN :seconds_least AND "
        ":seconds_most)) "
        "AND parent = :parent AND (:owner = '' OR submitter = :owner) "
        "ORDER BY number DESC LIMIT :limit OFFSET :offset",
    [ADD_CALL] = "INSERT INTO calls(job, kind, attempts, due) VALUES(:number, :kind, 0, :due)",
    [CALLS] = "SELECT number, job, kind, attempts, due FROM calls ORDER BY due LIMIT :limit",
    [UPDATE_CALL] =
        "UPDATE calls SET attempts = :attempts, due = :due, holder = '' WHERE number = :number",
    [REMOVE_CALL] = "DELETE FROM calls WHERE number = :number",
    [REMOVE_CALLS] = "DELETE FROM calls WHERE job = :number",
    [ADD_SMALL] =
        "INSERT INTO small(job, kind, bytes) VALUES(:number, :kind, :bytes) "
        "ON CONFLICT(job, kind) DO UPDATE SET bytes = excluded.bytes",
    [SMALL] = "SELECT bytes FROM small WHERE job = :number AND kind = :kind",
    [DROP_SMALL] = "DELETE FROM small WHERE job = :number AND (kind = :kind OR :kind < 0)",
    [REMOVE_SMALL] =
        "DELETE FROM small WHERE job = :number OR job IN "
        "(SELECT number FROM jobs WHERE parent = :number AND parent > 0)",
    [LOG] = "INSERT INTO log(job, time, text) VALUES(:number, :time, :text)",
    [READ_LOG] =
        "SELECT time, text FROM (SELECT {line} AS line, time, text FROM log WHERE job = :number "
        "ORDER BY {line} DESC LIMIT :limit) AS last ORDER BY line",
    [ADD_DATA] =
        "INSERT INTO data(id, type, size, created, expires, owner) VALUES(:id, :type, :size, "
        ":created, :expires, :owner) ON CONFLICT(id) DO UPDATE SET expires = {greater "
        "of}(data.expires, "
        "excluded.expires)",
    [DATA] = "SELECT type, size, created, expires, owner FROM data WHERE id = :id",
    [DATA_BYTES] =
        "SELECT CAST(coalesce(sum(size), 0) AS {long}) FROM data WHERE :owner = '' OR owner = "
        ":owner",
    [RENEW_DATA] = "UPDATE data SET expires = {greater of}(expires, :expires) WHERE id = :id",
    [DATA_PINNED] =
        "SELECT 1 FROM pins JOIN jobs ON number = job WHERE pins.data = :id AND state <= 1 LIMIT 1",
    [DATA_EXPIRED] =
        "SELECT id FROM data WHERE expires <= :now AND NOT EXISTS(SELECT 1 FROM pins JOIN "
        "jobs ON number = job WHERE pins.data = data.id AND state <= 1) LIMIT 1",
    [DATA_FIRST_EXPIRY] = "SELECT min(expires) FROM data",
    [REMOVE_DATA] = "DELETE FROM data WHERE id = :id AND expires <= :most",
    [PIN] = "INSERT INTO pins(data, job) VALUES(:id, :number)",
    [UNPIN] = "DELETE FROM pins WHERE job = :number",
    [SHIFT_JOBS] = "UPDATE jobs SET expires = expires + :by WHERE expires > 0",
    [SHIFT_CALLS] = "UPDATE calls SET due = due + :by",
    [SHIFT_DATA] = "UPDATE data SET expires = expires + :by",
    [BEAT] =
        "INSERT INTO daemons(id, beat) VALUES(:holder, clock_timestamp()) ON CONFLICT(id) DO "
        "UPDATE SET beat = excluded.beat RETURNING CAST(extract(epoch FROM beat) AS {real}), "
        "{no wait for the disk}",
    [CLOCK] = "SELECT CAST(extract(epoch FROM clock_timestamp()) AS {real})",
    [LEAVE] = "DELETE FROM daemons WHERE id = :holder",
    [RELEASE] = "UPDATE jobs SET holder = '' WHERE holder = :holder AND state = 0",
    /* Lanes are the pairs of priority and submitter that wait, found by skipping through an index;
     * of the lane whose turn it is, the oldest job that nobody else is just taking. */
    [TAKE] =
        "WITH RECURSIVE lane(priority, submitter) AS ("
        "(SELECT priority, submitter FROM jobs WHERE {waiting} "
        "ORDER BY priority DESC, submitter DESC LIMIT 1) UNION ALL "
        "SELECT n.priority, n.submitter FROM lane, LATERAL (SELECT priority, submitter FROM jobs "
        "WHERE {waiting} AND (priority, submitter) < (lane.priority, lane.submitter) "
        "ORDER BY priority DESC, submitter DESC LIMIT 1) AS n), "
        "in_turn AS (SELECT priority, submitter FROM lane LEFT JOIN turns USING (submitter) "
        "ORDER BY priority DESC, CASE WHEN last <= clock_timestamp() THEN last END NULLS FIRST), "
        "taken AS (SELECT j.number, t.submitter FROM in_turn AS t, LATERAL (SELECT number FROM "
        "jobs WHERE {waiting} AND priority = t.priority AND submitter = t.submitter "
        "AND (estimate <= :room OR created < :old) ORDER BY number LIMIT 1 "
        "FOR UPDATE SKIP LOCKED) AS j LIMIT 1), "
        "turn AS (INSERT INTO turns(submitter, last) SELECT submitter, clock_timestamp() FROM "
        "taken ON CONFLICT(submitter) DO UPDATE SET last = excluded.last) "
        "UPDATE jobs SET holder = :holder WHERE number = (SELECT number FROM taken) "
        "RETURNING {columns}, number, {no wait for the disk}",
    [WAITING] = "SELECT count(*) FROM jobs WHERE {waiting}",
    [ACTIVE_OF] =
        "SELECT count(*) FROM jobs WHERE state <= 1 AND parts = 0 AND submitter = :submitter",
    [LOCK_JOBS] =
        "SELECT set_config('lock_timeout', '1s', true), "
        "pg_advisory_xact_lock(hashtextextended('scatterd jobs of ' || :submitter, 0))",
    [HELD] = "SELECT {columns}, number FROM jobs WHERE holder = :holder",
    [RELEASE_DEAD] =
        "UPDATE jobs SET holder = '' WHERE holder <> '' AND (state <> 1 OR parts > 0) "
        "AND NOT ({alive})",
    [CLAIM_DEAD] =
        "UPDATE jobs SET holder = :holder WHERE holder <> '' AND state = 1 AND parts = 0 "
        "AND NOT ({alive})",
    [FREE_CALLS] =
        "UPDATE calls SET due = extract(epoch FROM clock_timestamp()), holder = '' "
        "WHERE holder <> '' AND NOT ({alive})",
    [FORGET_DEAD] = "DELETE FROM daemons WHERE NOT (beat {within a lease})",
    [FORGET_TURNS] = "DELETE FROM turns WHERE last < clock_timestamp() - interval '1 day'",
    [CLAIM] =
        "UPDATE jobs SET holder = :holder WHERE number = :number AND holder = '' "
        "AND state = :state",
    [DONE_BATCHES] =
        "SELECT {columns}, number FROM jobs AS b WHERE parts > 0 AND state <= 1 AND holder = '' "
        "AND NOT EXISTS(SELECT 1 FROM jobs AS p WHERE p.parent = b.number AND p.parent > 0 "
        "AND p.state <= 1) LIMIT 20",
    [PART_ACTIVE] =
        "SELECT 1 FROM jobs WHERE parent = :number AND parent > 0 AND state <= 1 LIMIT 1",
    [PART_PROGRESS] =
        "SELECT CAST(avg(CASE WHEN state >= 2 THEN 100 ELSE progress END) AS {real}) FROM jobs "
        "WHERE parent = :number AND parent > 0",
    [PROGRESS] =
        "UPDATE jobs SET progress = :progress, message = :message, phase = :phase, "
        "residual = :residual, updated = :updated WHERE number = :number AND holder = :holder "
        "AND state = 1 RETURNING {no wait for the disk}",
    [DISMISS_PARTS] =
        "UPDATE jobs SET state = 4, holder = '', message = 'dismissed with its batch', "
        "updated = :now, finished = :now WHERE parent = :number AND parent > 0 AND state <= 1",
    [TELL] = "SELECT pg_notify('scatterd', :text)",
    [RELAX] = "SELECT {no wait for the disk}",
    [CLAIM_CALL] =
        "UPDATE calls SET attempts = :attempts, due = :due, holder = :holder WHERE number = "
        ":number "
        "AND attempts = :attempts - 1",
    [ADD_LARGE] =
        "INSERT INTO large(owner, kind, chunk, bytes) VALUES(:owner, :kind, :chunk, :bytes) "
        "ON CONFLICT(owner, kind, chunk) DO UPDATE SET bytes = excluded.bytes",
    [LARGE] = "SELECT bytes FROM large WHERE owner = :owner AND kind = :kind AND chunk = :chunk",
    [DROP_LARGE] = "DELETE FROM large WHERE owner = :owner AND kind BETWEEN :least AND :most",
    [REMOVE_LARGE] =
        "DELETE FROM large WHERE owner IN (SELECT id FROM jobs WHERE number = :number OR "
        "(parent = :number AND parent > 0))",
    [ADOPT_LARGE] =
        "UPDATE large SET owner = :owner, kind = :kind WHERE owner = :draft AND kind = -1",
    [FORGET_DRAFTS] =
        "DELETE FROM large WHERE kind = -1 AND owner IN (SELECT owner FROM (SELECT owner, "
        "split_part(owner, '.', 1) AS holder FROM large WHERE kind = -1) AS draft "
        "WHERE NOT ({alive}))",
};

static void add(store_text *q, const char *format, ...) __attribute__((format(printf, 2, 3)));
static void add(store_text *q, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  q->used += (size_t)vsnprintf(q->text + q->used, sizeof q->text - q->used, format, arguments);
  va_end(arguments);
  if (q->used >= sizeof q->text) abort(); /* the tables above outgrew the room */
}

/* ---- Parameters: numbered as they come ---- */

static void add_place(dialect d, store_text *q, int place) {
  add(q, d == DIALECT_SQLITE ? "?%d" : "$%d", place);
}

static bool is_name(const char *name, const char *text, size_t length) {
  return strncmp(name, text, length) == 0 && name[length] == '\0';
}

static size_t add_name(dialect d, store_text *q, const char *text) {
  store_names *n = &q->names;
  const size_t length = 1 + strspn(text + 1, "abcdefghijklmnopqrstuvwxyz_");
  int k = 0;
  while (k < n->count && !is_name(n->named[k].name, text, length)) k++;
  if (k == n->count) {
    if (k == STORE_NAMES || length >= STORE_NAME) abort(); /* as above */
    memcpy(n->named[k].name, text, length);
    n->named[k].place = ++n->parameters;
    n->count++;
  }
  add_place(d, q, n->named[k].place);
  return length;
}

/* ---- Marks ---- */

/* One column in a list of all of them. */
typedef void writer(dialect d, store_text *q, const column *c);

static void write_column(dialect d, store_text *q, const column *c) {
  (void)d;
  add(q, "\"%s\"", c->name);
}

static void write_value(dialect d, store_text *q, const column *c) {
  (void)c;
  add_place(d, q, ++q->names.parameters);
}

static void write_setting(dialect d, store_text *q, const column *c) {
  add(q, "\"%s\"=", c->name);
  add_place(d, q, ++q->names.parameters);
}

static void write_definition(dialect d, store_text *q, const column *c) {
  add(q, "\"%s\" %s", c->name, types[d][c->kind]);
}

static const struct {
  const char *mark;
  writer *write;
} lists[] = {{"{columns}", write_column},
             {"{values}", write_value},
             {"{settings}", write_setting},
             {"{definitions}", write_definition}};

static bool is_mark(const char *text, const char *mark) {
  return strncmp(text, mark, strlen(mark)) == 0;
}

static void add_sql(dialect d, const char *template, store_text *q);

/* What stands for the mark at `text`; its length, 0 if there is none. */
static size_t add_mark(dialect d, store_text *q, const char *text) {
  for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
    if (!is_mark(text, words[k].mark)) continue;
    add_sql(d, words[k].word[d], q);
    return strlen(words[k].mark);
  }
  for (size_t k = 0; k < sizeof lists / sizeof *lists; k++) {
    if (!is_mark(text, lists[k].mark)) continue;
    for (int c = 0; c < STORE_COLUMNS; c++) {
      if (c > 0) add(q, ", ");
      lists[k].write(d, q, &store_columns[c]);
    }
    return strlen(lists[k].mark);
  }
  return 0;
}

/* The template in a dialect. */
static void add_sql(dialect d, const char *template, store_text *q) {
  while (*template != '\0') {
    const size_t length = *template == ':' ? add_name(d, q, template) : add_mark(d, q, template);
    if (length == 0) add(q, "%c", *template);
    template += length > 0 ? length : 1;
  }
}

static void write_sql(dialect d, const char *template, store_text *q) {
  q->used = 0;
  q->names = (store_names){0};
  add_sql(d, template, q);
}

void store_write_schema(dialect d, store_text *q) {
  write_sql(d, schema, q);
  add_sql(d, more_schema[d], q);
}

void store_write_step(dialect d, int from, store_text *q) {
  write_sql(d, steps[from], q);
}

void store_write_statement(dialect d, statement k, store_text *q) {
  write_sql(d, statements[k], q);
}
