/* The only door to libpq.
 *
 * Statements are waited for, each within `patience`: over a socket on the same machine they take
 * 0.1 ms, in a transaction the time of one fsync, which is what they take in SQLite as well. A
 * database that does not answer in time is given up at once, and from then on statements fail
 * without any waiting, until the connection is made anew, which happens step by step and never
 * waits. */
#include <endian.h>
#include <libpq-fe.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "loop.h"
#include "store_shared.h"
#include "store_sql.h"
#include "utf8.h"

enum { PARAMETERS = 48, NEWS = 1000 };
static const double patience = 5;      /* (s) for a statement; the server gives up a bit earlier */
static const double pause_seconds = 1; /* between attempts to connect */
static const double connecting = 10;   /* (s) for one attempt */

typedef enum { DOWN, CONNECTING, UP } link_state;

typedef struct news {
  struct news *next;
  char text[];
} news;

typedef struct {
  char *url;
  PGconn *link;
  link_state state;
  int generation;                 /* connections made so far */
  double until;                   /* DOWN: when to try again; CONNECTING: when to give up */
  PostgresPollingStatusType wish; /* CONNECTING: what it waits for */
  /* a transaction: its statements are sent as they come, results are read when one is needed */
  bool is_open;
  int pending;         /* sent, not read */
  store_result broken; /* the first failure of those read */
  PGresult *result[STATEMENTS];
  int row[STATEMENTS];
  /* of the statement being bound */
  char number[PARAMETERS][32];
  const char *value[PARAMETERS];
  char *clean[PARAMETERS]; /* copies of texts that were not UTF-8 */
  int length[PARAMETERS], is_bytes[PARAMETERS];
  /* told by other daemons */
  news *first, **last;
  int count;
} base;

static base *base_of(const store *s) {
  return s->base;
}

/* ---- The connection ---- */

static void give_up(base *b, const char *why) {
  if (b->state == UP) log_say(LOG_ERROR, "store", "the database does not answer: %s", why);
  PQfinish(b->link);
  b->link = NULL;
  b->is_open = false;
  b->pending = 0;
  b->broken = STORE_OK;
  b->state = DOWN;
  b->until = loop_now() + pause_seconds;
}

/* What other daemons said, kept until somebody asks; what is too much is "*", which is all. */
static void take_news(base *b) {
  for (PGnotify *n; (n = PQnotifies(b->link)) != NULL; PQfreemem(n)) {
    if (n->be_pid == PQbackendPID(b->link)) continue;
    const char *text = b->count < NEWS ? n->extra : "*";
    const size_t size = strlen(text) + 1;
    news *item = b->count > NEWS ? NULL : malloc(sizeof *item + size);
    if (item == NULL) continue;
    memcpy(item->text, text, size);
    item->next = NULL;
    *b->last = item;
    b->last = &item->next;
    b->count++;
  }
}

static bool wait_for(base *b, short events, double until) {
  struct pollfd p = {.fd = PQsocket(b->link), .events = events};
  const double left = until - loop_now();
  return left > 0 && poll(&p, 1, (int)ceil(1e3 * left)) > 0;
}

/* Hands over all that is to be sent. */
static bool flush_sent(base *b) {
  const double until = loop_now() + patience;
  for (int left; (left = PQflush(b->link)) != 0;) {
    if (left < 0 || !wait_for(b, POLLIN | POLLOUT, until) || PQconsumeInput(b->link) == 0) {
      return false;
    }
  }
  return true;
}

static bool wait_for_result(base *b) {
  const double until = loop_now() + patience;
  while (PQisBusy(b->link)) {
    if (!wait_for(b, POLLIN, until) || PQconsumeInput(b->link) == 0) return false;
  }
  return true;
}

/* The result of the first statement that was sent and not read; NULL when it does not come in time.
 */
static PGresult *await(base *b) {
  PGresult *result = NULL, *next = NULL;
  if (!flush_sent(b)) return NULL;
  do {
    if (!wait_for_result(b)) {
      PQclear(result);
      return NULL;
    }
    next = PQgetResult(b->link);
    if (next == NULL) break;
    PQclear(result);
    result = next;
  } while (PQresultStatus(next) != PGRES_PIPELINE_SYNC);
  take_news(b);
  return result;
}

/* ---- Results ---- */

static const struct {
  const char *state; /* SQLSTATE, or how it begins */
  store_result result;
} failures[] = {
    {"23505", STORE_TAKEN}, /* unique_violation */
    {"55P03", STORE_BUSY},  /* lock_not_available */
    {"53100", STORE_FULL},  /* disk_full */
    {"08", STORE_DOWN},     /* connections */
    {"57", STORE_DOWN},     /* the operator intervenes, or the time is over */
    {"53", STORE_DOWN},     /* resources */
    {"25006", STORE_DOWN},  /* it has become a copy that can only be read */
};

static store_result failure(base *b, const PGresult *result) {
  if (PQresultStatus(result) == PGRES_PIPELINE_ABORTED) return STORE_FAILED; /* after another one */
  const char *state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const char *text = result != NULL ? PQresultErrorMessage(result) : PQerrorMessage(b->link);
  if (state == NULL || PQstatus(b->link) != CONNECTION_OK) {
    give_up(b, *text != '\0' ? text : "it takes too long");
    return STORE_DOWN;
  }
  for (size_t k = 0; k < sizeof failures / sizeof *failures; k++) {
    if (strncmp(state, failures[k].state, strlen(failures[k].state)) != 0) continue;
    if (failures[k].result == STORE_DOWN) give_up(b, text);
    return failures[k].result;
  }
  log_say(LOG_ERROR, "store", "%s", text);
  return STORE_FAILED;
}

static bool is_good(const PGresult *result) {
  const ExecStatusType status = PQresultStatus(result);
  return status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
}

/* Plain text, any number of statements. */
static store_result run_text(base *b, const char *text) {
  if (PQsendQuery(b->link, text) == 0) return failure(b, NULL);
  PGresult *result = await(b);
  const store_result end = is_good(result) ? STORE_OK : failure(b, result);
  PQclear(result);
  return end;
}

/* ---- Statements ---- */

static void unbind(base *b) {
  for (int p = 0; p < PARAMETERS; p++) {
    free(b->clean[p]);
    b->clean[p] = NULL;
    b->value[p] = NULL;
    b->length[p] = b->is_bytes[p] = 0;
  }
}

static void name_statement(statement k, char name[16]) {
  snprintf(name, 16, "s%d", (int)k);
}

static bool send_bound(store *s, statement k) {
  base *b = base_of(s);
  char name[16];
  name_statement(k, name);
  const int sent = PQsendQueryPrepared(b->link, name, s->names[k].parameters, b->value, b->length,
                                       b->is_bytes, 1);
  unbind(b);
  return sent == 1;
}

/* Reads one result, which has to be good. */
static store_result read_result(base *b, PGresult **result) {
  *result = await(b);
  if (is_good(*result)) return STORE_OK;
  const store_result end = failure(b, *result);
  PQclear(*result);
  *result = NULL;
  return end;
}

/* Reads the results of all that was sent before; the first failure. */
static store_result read_pending(base *b) {
  while (b->pending > 0) {
    PGresult *result;
    b->pending--;
    const store_result end = read_result(b, &result);
    PQclear(result);
    if (end != STORE_OK && b->broken == STORE_OK) b->broken = end;
  }
  return b->broken;
}

static store_result execute(store *s, statement k) {
  base *b = base_of(s);
  if (b->state != UP) return STORE_DOWN;
  if (!send_bound(s, k) || (b->is_open && PQsendFlushRequest(b->link) == 0)) {
    return failure(b, NULL);
  }
  const store_result before = read_pending(b);
  if (b->state != UP) return STORE_DOWN;
  const store_result end = read_result(b, &b->result[k]);
  b->row[k] = -1;
  if (before != STORE_OK) {
    PQclear(b->result[k]);
    b->result[k] = NULL;
    return before;
  }
  if (end != STORE_OK && b->is_open) b->broken = end;
  return end;
}

static store_result step(store *s, statement k) {
  base *b = base_of(s);
  if (b->result[k] == NULL) {
    const store_result end = execute(s, k);
    unbind(b);
    if (end != STORE_OK) return end;
  }
  return ++b->row[k] < PQntuples(b->result[k]) ? STORE_OK : STORE_NONE;
}

static void reset(store *s, statement k) {
  base *b = base_of(s);
  PQclear(b->result[k]);
  b->result[k] = NULL;
}

/* ---- Transactions ---- */

static store_result begin(base *b) {
  b->broken = STORE_OK;
  b->pending = 0;
  b->is_open = PQenterPipelineMode(b->link) == 1;
  return b->is_open ? STORE_OK : failure(b, NULL);
}

/* Reads all there is, until nothing is on its way. */
static store_result end_pipeline(base *b) {
  PGresult *sync = NULL;
  if (PQpipelineSync(b->link) == 0) return failure(b, NULL);
  const store_result end = read_pending(b);
  if (b->state != UP) return STORE_DOWN;
  sync = await(b);
  const bool is_synced = PQresultStatus(sync) == PGRES_PIPELINE_SYNC;
  PQclear(sync);
  if (is_synced && PQexitPipelineMode(b->link) == 1) return end;
  return failure(b, NULL);
}

/* A transaction that has failed is not ended by COMMIT, but still there after it. */
static store_result end_transaction(base *b) {
  const store_result end = end_pipeline(b);
  b->is_open = b->state == UP && PQtransactionStatus(b->link) != PQTRANS_IDLE;
  if (!b->is_open) b->broken = STORE_OK;
  return end == STORE_OK && b->is_open ? STORE_FAILED : end;
}

static store_result undo(base *b) {
  if (PQpipelineStatus(b->link) != PQ_PIPELINE_OFF) (void)end_pipeline(b);
  const store_result end = b->state == UP ? run_text(b, "ROLLBACK") : STORE_DOWN;
  b->is_open = false;
  b->broken = STORE_OK;
  return end;
}

static store_result run(store *s, statement k) {
  enum { LARGE_PIECE = 65536 };
  base *b = base_of(s);
  size_t size = 0;
  if (b->state != UP) {
    unbind(b);
    return STORE_DOWN;
  }
  if (k == ROLLBACK) return undo(b);
  if (k == BEGIN && begin(b) != STORE_OK) return STORE_DOWN;
  if (!b->is_open) {
    const store_result end = step(s, k);
    reset(s, k);
    return end == STORE_NONE ? STORE_OK : end;
  }
  for (int p = 0; p < PARAMETERS; p++) size += (size_t)b->length[p];
  if (!send_bound(s, k) || (size > LARGE_PIECE && !flush_sent(b))) return failure(b, NULL);
  b->pending++;
  return k == COMMIT ? end_transaction(b) : STORE_OK;
}

/* ---- Parameters ---- */

/* A copy with what is no UTF-8 as '?': the database takes nothing else. */
static char *cleaned(const char *text) {
  char *copy = strdup(text);
  for (char *at = copy, *end = copy != NULL ? copy + strlen(copy) : NULL; at < end;) {
    const size_t step_size = utf8_step(at, end);
    if (step_size == 0) *at = '?';
    at += step_size > 0 ? step_size : 1;
  }
  return copy;
}

static void bind_text(store *s, statement k, int place, const char *text) {
  base *b = base_of(s);
  const size_t length = strlen(text);
  (void)k;
  if (utf8_prefix(text, length) < length) text = b->clean[place - 1] = cleaned(text);
  b->value[place - 1] = text;
}

static void bind_long(store *s, statement k, int place, int64_t value) {
  base *b = base_of(s);
  (void)k;
  snprintf(b->number[place - 1], sizeof *b->number, "%lld", (long long)value);
  b->value[place - 1] = b->number[place - 1];
}

static void bind_real(store *s, statement k, int place, double value) {
  base *b = base_of(s);
  (void)k;
  snprintf(b->number[place - 1], sizeof *b->number, isinf(value) ? "%finity" : "%.17g", value);
  b->value[place - 1] = b->number[place - 1];
}

static void bind_bytes(store *s, statement k, int place, const void *bytes, size_t size) {
  base *b = base_of(s);
  (void)k;
  b->value[place - 1] = size > 0 ? bytes : "";
  b->length[place - 1] = (int)size;
  b->is_bytes[place - 1] = 1;
}

/* ---- Columns: numbers are big-endian, of 4 or 8 bytes ---- */

static int64_t changes(store *s, statement k) {
  return strtoll(PQcmdTuples(base_of(s)->result[k]), NULL, 10);
}

static bool is_null(store *s, statement k, int c) {
  const base *b = base_of(s);
  return PQgetisnull(b->result[k], b->row[k], c) != 0;
}

static uint64_t bits(const base *b, statement k, int c) {
  const char *at = PQgetvalue(b->result[k], b->row[k], c);
  uint32_t four = 0;
  uint64_t eight = 0;
  if (PQgetlength(b->result[k], b->row[k], c) == 8) {
    memcpy(&eight, at, sizeof eight);
    return be64toh(eight);
  }
  if (PQgetlength(b->result[k], b->row[k], c) == 4) memcpy(&four, at, sizeof four);
  return (uint64_t)(int32_t)be32toh(four);
}

static int64_t get_long(store *s, statement k, int c) {
  return (int64_t)bits(base_of(s), k, c);
}

static double get_real(store *s, statement k, int c) {
  enum { FLOAT8 = 701 }; /* its number in every PostgreSQL */
  const base *b = base_of(s);
  const uint64_t raw = bits(b, k, c);
  double value;
  if (PQftype(b->result[k], c) != FLOAT8) return (double)(int64_t)raw;
  memcpy(&value, &raw, sizeof value);
  return value;
}

static const void *get_bytes(store *s, statement k, int c, size_t *size) {
  const base *b = base_of(s);
  *size = (size_t)PQgetlength(b->result[k], b->row[k], c);
  return PQgetvalue(b->result[k], b->row[k], c);
}

static bool is_open(const store *s) {
  return base_of(s)->is_open;
}

/* ---- A session ---- */

static int version_of(base *b) {
  int version = -1;
  if (PQsendQuery(b->link, "SELECT version FROM scatterd") == 0) return -1;
  PGresult *result = await(b);
  if (PQresultStatus(result) == PGRES_TUPLES_OK && PQntuples(result) == 1) {
    version = (int)strtol(PQgetvalue(result, 0, 0), NULL, 10);
  }
  PQclear(result);
  return version;
}

static bool set_version(base *b, int version) {
  char text[64];
  snprintf(text, sizeof text, "UPDATE scatterd SET version = %d", version);
  return run_text(b, text) == STORE_OK;
}

/* Within a transaction that holds the lock: daemons may start at the same time. */
static bool make_tables(base *b, fault *why) {
  store_text q;
  if (run_text(b,
               "CREATE TABLE IF NOT EXISTS scatterd(version INTEGER);"
               "INSERT INTO scatterd SELECT 0 WHERE NOT EXISTS(SELECT 1 FROM scatterd)") !=
      STORE_OK) {
    return false;
  }
  int version = version_of(b);
  if (version < 0 || version > STORE_VERSION) {
    return fault_set(why, "store: its tables are of version %d, needs at most %d", version,
                     STORE_VERSION);
  }
  if (version == 0) {
    store_write_schema(DIALECT_POSTGRES, &q);
    version = STORE_VERSION;
    if (run_text(b, q.text) != STORE_OK) return false;
  }
  for (; version < STORE_VERSION; version++) {
    store_write_step(DIALECT_POSTGRES, version, &q);
    if (run_text(b, q.text) != STORE_OK) return false;
  }
  return set_version(b, STORE_VERSION);
}

static bool prepare_all(base *b) {
  store_text q;
  char name[16];
  for (int k = 0; k < STATEMENTS; k++) {
    PGresult *result = NULL;
    name_statement((statement)k, name);
    store_write_statement(DIALECT_POSTGRES, (statement)k, &q);
    if (PQsendPrepare(b->link, name, q.text, 0, NULL) == 0) return false;
    if (read_result(b, &result) != STORE_OK) return false;
    PQclear(result);
  }
  return true;
}

static void note_notice(void *context, const char *text) {
  (void)context;
  log_say(LOG_DEBUG, "store", "%s", text);
}

static bool begin_session(base *b, fault *why) {
  char settings[400];
  snprintf(settings, sizeof settings,
           "SET statement_timeout = %.0f; SET idle_in_transaction_session_timeout = %.0f;"
           "SET application_name = 'scatterd'; SET client_min_messages = warning;"
           "SELECT set_config('synchronous_commit', 'on', false) WHERE "
           "current_setting('synchronous_commit') = 'off'; LISTEN scatterd",
           900 * patience, 4000 * patience);
  PQsetNoticeProcessor(b->link, note_notice, NULL);
  snprintf(why->text, sizeof why->text, "store: the tables cannot be made; the log knows more");
  const bool good = PQsetnonblocking(b->link, 1) == 0 && run_text(b, settings) == STORE_OK &&
                    run_text(b, "BEGIN; SELECT pg_advisory_xact_lock(84808480)") == STORE_OK &&
                    make_tables(b, why) && run_text(b, "COMMIT") == STORE_OK && prepare_all(b);
  if (!good) return false;
  b->state = UP;
  b->generation++;
  return true;
}

static bool open_base(store *s, const char *where, fault *why) {
  base *b = s->base = calloc(1, sizeof *b);
  if (b == NULL || (b->url = strdup(where)) == NULL) return fault_set(why, "out of memory");
  b->last = &b->first;
  const char *const keys[] = {"connect_timeout", "dbname", NULL};
  const char *const values[] = {"10", where, NULL}; /* the URL may say otherwise */
  b->link = PQconnectdbParams(keys, values, 1);
  if (PQstatus(b->link) == CONNECTION_OK) return begin_session(b, why);
  return fault_set(why, "store: %.400s", PQerrorMessage(b->link));
}

static void forget_news(base *b) {
  while (b->first != NULL) {
    news *item = b->first;
    b->first = item->next;
    free(item);
  }
  b->last = &b->first;
  b->count = 0;
}

static void close_base(store *s) {
  base *b = s->base;
  if (b == NULL) return;
  for (int k = 0; k < STATEMENTS; k++) PQclear(b->result[k]);
  unbind(b);
  forget_news(b);
  PQfinish(b->link);
  free(b->url);
  free(b);
}

/* ---- Connecting again ---- */

static void begin_connecting(base *b) {
  b->until = loop_now() + connecting;
  b->wish = PGRES_POLLING_WRITING;
  b->link = PQconnectStart(b->url);
  b->state = CONNECTING;
  if (PQstatus(b->link) == CONNECTION_BAD) give_up(b, "");
}

static void go_on_connecting(base *b) {
  fault why;
  struct pollfd p = {.fd = PQsocket(b->link),
                     .events = b->wish == PGRES_POLLING_READING ? POLLIN : POLLOUT};
  if (poll(&p, 1, 0) > 0) b->wish = PQconnectPoll(b->link);
  const bool good = b->wish == PGRES_POLLING_OK && begin_session(b, &why);
  if (good) {
    log_say(LOG_INFO, "store", "the database answers again");
  } else if (b->link != NULL && (b->wish == PGRES_POLLING_FAILED || b->wish == PGRES_POLLING_OK ||
                                 loop_now() > b->until)) {
    log_say(LOG_DEBUG, "store", "%s", PQerrorMessage(b->link));
    give_up(b, "");
  }
}

static bool tend(store *s) {
  base *b = base_of(s);
  if (b->state == DOWN && loop_now() >= b->until) begin_connecting(b);
  if (b->state == CONNECTING) go_on_connecting(b);
  return b->state == UP;
}

static int descriptor(const store *s, int *generation) {
  const base *b = base_of(s);
  *generation = b->generation;
  return b->state == UP ? PQsocket(b->link) : -1;
}

static char *hear(store *s) {
  base *b = base_of(s);
  if (b->state == UP && b->first == NULL) {
    if (PQconsumeInput(b->link) == 0) {
      give_up(b, PQerrorMessage(b->link));
    } else {
      take_news(b);
    }
  }
  news *item = b->first;
  if (item == NULL) return NULL;
  b->first = item->next;
  if (b->first == NULL) b->last = &b->first;
  b->count--;
  char *text = strdup(item->text);
  free(item);
  return text;
}

static bool has_news(const store *s) {
  return base_of(s)->first != NULL;
}

const store_door store_postgres = {
    .dialect = DIALECT_POSTGRES,
    .shared = true,
    .open = open_base,
    .close = close_base,
    .bind_text = bind_text,
    .bind_long = bind_long,
    .bind_real = bind_real,
    .bind_bytes = bind_bytes,
    .step = step,
    .run = run,
    .reset = reset,
    .changes = changes,
    .is_null = is_null,
    .get_long = get_long,
    .get_real = get_real,
    .get_bytes = get_bytes,
    .is_open = is_open,
    .tend = tend,
    .descriptor = descriptor,
    .hear = hear,
    .has_news = has_news,
};
