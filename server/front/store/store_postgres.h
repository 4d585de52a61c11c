/* store_postgres.h - what the files of the door to PostgreSQL share: store_postgres.c runs
 * statements, _values.c binds their parameters and reads their columns, _link.c sends and waits,
 * _session.c connects, also again. Test: unit.store.postgres, http.daemons.
 */
#ifndef SCATTERD_STORE_POSTGRES_H
#define SCATTERD_STORE_POSTGRES_H

#include <libpq-fe.h>

#include "store_sql.h"

enum { POSTGRES_PARAMETERS = 48 }; /* of one statement, at most */

#define POSTGRES_PATIENCE 5.0 /* (s) for a statement; the server gives up a bit earlier */

typedef struct postgres_news postgres_news;

typedef struct {
  char *url;
  PGconn *link;
  enum { POSTGRES_DOWN, POSTGRES_CONNECTING, POSTGRES_UP } state;
  int generation;                 /* connections made so far */
  double until;                   /* down: when to try again; connecting: when to give up */
  PostgresPollingStatusType wish; /* connecting: what it waits for */
  /* a transaction: its statements are sent as they come, results are read when one is needed */
  bool is_open;
  int pending;         /* sent, not read */
  store_result broken; /* the first failure of those read */
  PGresult *result[STATEMENTS];
  int row[STATEMENTS];
  /* of the statement being bound */
  char number[POSTGRES_PARAMETERS][32];
  const char *value[POSTGRES_PARAMETERS];
  char *clean[POSTGRES_PARAMETERS]; /* copies of texts that were not UTF-8 */
  int length[POSTGRES_PARAMETERS], is_bytes[POSTGRES_PARAMETERS];
  /* told by other daemons */
  postgres_news *first, **last;
  int count;
} postgres;

static inline postgres *postgres_of(const store *s) {
  return s->base;
}

/* ---- store_postgres_link.c ---- */

/* Closes the connection; it is down for a while. Said in the log if it was up. */
void postgres_give_up(postgres *b, const char *why);

/* Hands over all that is to be sent. */
bool postgres_flush(postgres *b);

/* The result of the first statement that was sent and not read; NULL when it does not come in time.
 */
PGresult *postgres_await(postgres *b);

/* What a result that is not good (NULL: none came) means; logged, and given up if that is the
 * connection. */
store_result postgres_failure(postgres *b, const PGresult *result);

/* Reads one result, which has to be good; NULL if it is not. */
store_result postgres_read(postgres *b, PGresult **result);

/* Plain text, any number of statements. */
store_result postgres_run_text(postgres *b, const char *text);

/* store_hear, store_has_news; drops what was told. */
char *postgres_hear(store *s);
bool postgres_has_news(const store *s);
void postgres_forget_news(postgres *b);

/* ---- store_postgres_session.c: as in store_door ---- */

bool postgres_open(store *s, const char *where, fault *why);
void postgres_close(store *s);
bool postgres_tend(store *s);
int postgres_descriptor(const store *s, int *generation);

/* By which the server knows a statement. */
void postgres_name(statement k, char name[16]);

/* ---- store_postgres_values.c: as in store_door ---- */

void postgres_bind_text(store *s, statement k, int place, const char *text);
void postgres_bind_long(store *s, statement k, int place, int64_t value);
void postgres_bind_real(store *s, statement k, int place, double value);
void postgres_bind_bytes(store *s, statement k, int place, const void *bytes, size_t size);
void postgres_unbind(postgres *b);

int64_t postgres_changes(store *s, statement k);
bool postgres_is_null(store *s, statement k, int c);
int64_t postgres_get_long(store *s, statement k, int c);
double postgres_get_real(store *s, statement k, int c);
const void *postgres_get_bytes(store *s, statement k, int c, size_t *size);

#endif
