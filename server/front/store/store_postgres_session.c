/* A session: made at the start, which waits for it; when the database has been away made anew, step
 * by step and waiting for nothing. */
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "loop.h"
#include "store_postgres.h"

static const double connecting = 10; /* (s) for one attempt */

void postgres_name(statement k, char name[16]) {
  snprintf(name, 16, "s%d", (int)k);
}

/* ---- A session ---- */

static int version_of(postgres *b) {
  int version = -1;
  if (PQsendQuery(b->link, "SELECT version FROM scatterd") == 0) return -1;
  PGresult *result = postgres_await(b);
  if (PQresultStatus(result) == PGRES_TUPLES_OK && PQntuples(result) == 1) {
    version = (int)strtol(PQgetvalue(result, 0, 0), NULL, 10);
  }
  PQclear(result);
  return version;
}

static bool become(store *s, const char *text, int version) {
  char set[64];
  snprintf(set, sizeof set, "UPDATE scatterd SET version = %d", version);
  return postgres_run_text(postgres_of(s), text) == STORE_OK &&
         postgres_run_text(postgres_of(s), set) == STORE_OK;
}

/* Within a transaction that holds the lock: daemons may start at the same time. */
static bool make_tables(store *s, fault *why) {
  static const char start[] =
      "CREATE TABLE IF NOT EXISTS scatterd(version INTEGER);"
      "INSERT INTO scatterd SELECT 0 WHERE NOT EXISTS(SELECT 1 FROM scatterd)";
  postgres *b = postgres_of(s);
  return postgres_run_text(b, start) == STORE_OK && sql_make_tables(s, version_of(b), become, why);
}

static bool prepare_all(postgres *b) {
  store_text q;
  char name[16];
  for (int k = 0; k < STATEMENTS; k++) {
    PGresult *result = NULL;
    postgres_name((statement)k, name);
    store_write_statement(DIALECT_POSTGRES, (statement)k, &q);
    if (PQsendPrepare(b->link, name, q.text, 0, NULL) == 0) return false;
    if (postgres_read(b, &result) != STORE_OK) return false;
    PQclear(result);
  }
  return true;
}

static void note_notice(void *context, const char *text) {
  (void)context;
  log_say(LOG_DEBUG, "store", "%s", text);
}

static bool begin_session(store *s, fault *why) {
  postgres *b = postgres_of(s);
  char settings[400];
  snprintf(settings, sizeof settings,
           "SET statement_timeout = %.0f; SET idle_in_transaction_session_timeout = %.0f;"
           "SET application_name = 'scatterd'; SET client_min_messages = warning;"
           "SELECT set_config('synchronous_commit', 'on', false) WHERE "
           "current_setting('synchronous_commit') = 'off'%s",
           900 * POSTGRES_PATIENCE, 4000 * POSTGRES_PATIENCE,
           s->url == NULL ? "; LISTEN scatterd" : ""); /* a writer hears nothing */
  PQsetNoticeProcessor(b->link, note_notice, NULL);
  snprintf(why->text, sizeof why->text, "store: the tables cannot be made; the log knows more");
  const bool good =
      PQsetnonblocking(b->link, 1) == 0 && postgres_run_text(b, settings) == STORE_OK &&
      postgres_run_text(b, "BEGIN; SELECT pg_advisory_xact_lock(84808480)") == STORE_OK &&
      make_tables(s, why) && postgres_run_text(b, "COMMIT") == STORE_OK && prepare_all(b);
  if (!good) return false;
  b->state = POSTGRES_UP;
  b->generation++;
  return true;
}

bool postgres_open(store *s, const char *where, fault *why) {
  postgres *b = s->base = calloc(1, sizeof *b);
  if (b == NULL || (b->url = strdup(where)) == NULL) return fault_set(why, "out of memory");
  b->last = &b->first;
  const char *const keys[] = {"connect_timeout", "dbname", NULL};
  const char *const values[] = {"10", where, NULL}; /* the URL may say otherwise */
  b->link = PQconnectdbParams(keys, values, 1);
  if (PQstatus(b->link) == CONNECTION_OK) return begin_session(s, why);
  return fault_set(why, "store: %.400s", PQerrorMessage(b->link));
}

void postgres_close(store *s) {
  postgres *b = s->base;
  for (int k = 0; k < STATEMENTS; k++) PQclear(b->result[k]);
  postgres_unbind(b);
  postgres_forget_news(b);
  PQfinish(b->link);
  free(b->url);
  free(b);
}

/* ---- Connecting again ---- */

static void begin_connecting(postgres *b) {
  b->until = loop_now() + connecting;
  b->wish = PGRES_POLLING_WRITING;
  b->link = PQconnectStart(b->url);
  b->state = POSTGRES_CONNECTING;
  if (PQstatus(b->link) == CONNECTION_BAD) postgres_give_up(b, "");
}

static void go_on_connecting(store *s) {
  postgres *b = postgres_of(s);
  fault why;
  struct pollfd p = {.fd = PQsocket(b->link),
                     .events = b->wish == PGRES_POLLING_READING ? POLLIN : POLLOUT};
  if (poll(&p, 1, 0) > 0) b->wish = PQconnectPoll(b->link);
  const bool good = b->wish == PGRES_POLLING_OK && begin_session(s, &why);
  if (good) {
    log_say(LOG_INFO, "store", "the database answers again");
  } else if (b->link != NULL && (b->wish == PGRES_POLLING_FAILED || b->wish == PGRES_POLLING_OK ||
                                 loop_now() > b->until)) {
    log_say(LOG_DEBUG, "store", "%s", PQerrorMessage(b->link));
    postgres_give_up(b, "");
  }
}

bool postgres_tend(store *s) {
  postgres *b = postgres_of(s);
  if (b->state == POSTGRES_DOWN && loop_now() >= b->until) begin_connecting(b);
  if (b->state == POSTGRES_CONNECTING) go_on_connecting(s);
  return b->state == POSTGRES_UP;
}

int postgres_descriptor(const store *s, int *generation) {
  const postgres *b = postgres_of(s);
  *generation = b->generation;
  return b->state == POSTGRES_UP ? PQsocket(b->link) : -1;
}
