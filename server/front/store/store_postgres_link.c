/* What goes over the connection: statements are sent, results waited for, news taken. */
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>

#include "log.h"
#include "loop.h"
#include "store_postgres.h"

enum { NEWS = 1000 };
static const double pause_seconds = 1; /* between attempts to connect */

struct postgres_news {
  postgres_news *next;
  char text[];
};

/* ---- News: what other daemons said, kept until somebody asks ---- */

/* What is too much is "*", which is all. */
static void take_news(postgres *b) {
  for (PGnotify *n; (n = PQnotifies(b->link)) != NULL; PQfreemem(n)) {
    if (n->be_pid == PQbackendPID(b->link)) continue;
    const char *text = b->count < NEWS ? n->extra : "*";
    const size_t size = strlen(text) + 1;
    postgres_news *item = b->count > NEWS ? NULL : malloc(sizeof *item + size);
    if (item == NULL) continue;
    memcpy(item->text, text, size);
    item->next = NULL;
    *b->last = item;
    b->last = &item->next;
    b->count++;
  }
}

char *postgres_hear(store *s) {
  postgres *b = postgres_of(s);
  if (b->state == POSTGRES_UP && b->first == NULL) {
    if (PQconsumeInput(b->link) == 0) {
      postgres_give_up(b, PQerrorMessage(b->link));
    } else {
      take_news(b);
    }
  }
  postgres_news *item = b->first;
  if (item == NULL) return NULL;
  b->first = item->next;
  if (b->first == NULL) b->last = &b->first;
  b->count--;
  char *text = strdup(item->text);
  free(item);
  return text;
}

bool postgres_has_news(const store *s) {
  return postgres_of(s)->first != NULL;
}

void postgres_forget_news(postgres *b) {
  while (b->first != NULL) {
    postgres_news *item = b->first;
    b->first = item->next;
    free(item);
  }
  b->last = &b->first;
  b->count = 0;
}

/* ---- The connection ---- */

void postgres_give_up(postgres *b, const char *why) {
  if (b->state == POSTGRES_UP) log_say(LOG_ERROR, "store", "the database does not answer: %s", why);
  PQfinish(b->link);
  b->link = NULL;
  b->is_open = false;
  b->pending = 0;
  b->broken = STORE_OK;
  b->state = POSTGRES_DOWN;
  b->until = loop_now() + pause_seconds;
}

static bool wait_for(postgres *b, short events, double until) {
  struct pollfd p = {.fd = PQsocket(b->link), .events = events};
  const double left = until - loop_now();
  return left > 0 && poll(&p, 1, (int)ceil(1e3 * left)) > 0;
}

bool postgres_flush(postgres *b) {
  const double until = loop_now() + POSTGRES_PATIENCE;
  for (int left; (left = PQflush(b->link)) != 0;) {
    if (left < 0 || !wait_for(b, POLLIN | POLLOUT, until) || PQconsumeInput(b->link) == 0) {
      return false;
    }
  }
  return true;
}

static bool wait_for_result(postgres *b) {
  const double until = loop_now() + POSTGRES_PATIENCE;
  while (PQisBusy(b->link)) {
    if (!wait_for(b, POLLIN, until) || PQconsumeInput(b->link) == 0) return false;
  }
  return true;
}

PGresult *postgres_await(postgres *b) {
  PGresult *result = NULL, *next = NULL;
  if (!postgres_flush(b)) return NULL;
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

store_result postgres_failure(postgres *b, const PGresult *result) {
  if (PQresultStatus(result) == PGRES_PIPELINE_ABORTED) return STORE_FAILED; /* after another one */
  const char *state = PQresultErrorField(result, PG_DIAG_SQLSTATE);
  const char *text = result != NULL ? PQresultErrorMessage(result) : PQerrorMessage(b->link);
  if (state == NULL || PQstatus(b->link) != CONNECTION_OK) {
    postgres_give_up(b, *text != '\0' ? text : "it takes too long");
    return STORE_DOWN;
  }
  for (size_t k = 0; k < sizeof failures / sizeof *failures; k++) {
    if (strncmp(state, failures[k].state, strlen(failures[k].state)) != 0) continue;
    if (failures[k].result == STORE_DOWN) postgres_give_up(b, text);
    return failures[k].result;
  }
  log_say(LOG_ERROR, "store", "%s", text);
  return STORE_FAILED;
}

static bool is_good(const PGresult *result) {
  const ExecStatusType status = PQresultStatus(result);
  return status == PGRES_COMMAND_OK || status == PGRES_TUPLES_OK;
}

store_result postgres_run_text(postgres *b, const char *text) {
  if (PQsendQuery(b->link, text) == 0) return postgres_failure(b, NULL);
  PGresult *result = postgres_await(b);
  const store_result end = is_good(result) ? STORE_OK : postgres_failure(b, result);
  PQclear(result);
  return end;
}

store_result postgres_read(postgres *b, PGresult **result) {
  *result = postgres_await(b);
  if (is_good(*result)) return STORE_OK;
  const store_result end = postgres_failure(b, *result);
  PQclear(*result);
  *result = NULL;
  return end;
}
