/* store_sql.h - a database with its statements, as the files of the store use it, and the doors to
 * the databases there are. Parameters have names, columns numbers from 0.
 * Test: unit.store, unit.store.postgres.
 */
#ifndef SCATTERD_STORE_SQL_H
#define SCATTERD_STORE_SQL_H

#include "store.h"
#include "store_tables.h"

/* One kind of database. Texts and bytes that are bound must stay until the step. */
typedef struct {
  dialect dialect;
  bool shared; /* by several daemons */
  /* `where` is a directory or a URL; what was opened is closed in any case. */
  bool (*open)(store *s, const char *where, fault *why);
  void (*close)(store *s);
  void (*bind_text)(store *s, statement k, int place, const char *text);
  void (*bind_long)(store *s, statement k, int place, int64_t value);
  void (*bind_real)(store *s, statement k, int place, double value);
  void (*bind_bytes)(store *s, statement k, int place, const void *bytes, size_t size);
  store_result (*step)(store *s, statement k); /* as sql_step */
  /* As sql_run; a failure within a transaction may be told by a later statement of it. NULL: by
   * step and reset. */
  store_result (*run)(store *s, statement k);
  void (*reset)(store *s, statement k);
  int64_t (*changes)(store *s, statement k); /* rows that its last step changed */
  bool (*is_null)(store *s, statement k, int c);
  int64_t (*get_long)(store *s, statement k, int c);
  double (*get_real)(store *s, statement k, int c);
  const void *(*get_bytes)(store *s, statement k, int c, size_t *size); /* text, too */
  bool (*is_open)(const store *s); /* is there a transaction? */
  /* if shared; as store_tend, store_descriptor, store_hear, store_has_news */
  bool (*tend)(store *s);
  int (*descriptor)(const store *s, int *generation);
  char *(*hear)(store *s);
  bool (*has_news)(const store *s);
} store_door;

extern const store_door store_sqlite, store_postgres;

struct store {
  const store_door *door;
  void *base;                       /* the door's */
  store_names names[STATEMENTS];    /* parameters of each */
  int directory, files, data, lock; /* descriptors */
  /* of a shared one, store_draft.c: */
  store *writer; /* another connection to the same database, the clerk's */
  char *url;     /* of a writer; NULL: it is none */
  double until;  /* of a writer: it does not connect before */
  char holder[JOB_HOLDER];
  int64_t drafts; /* names given so far */
};

/* What a store has for drafts; NULL when out of memory. */
store *store_writer_new(const store *s, const char *url);
void store_writer_free(store **w);

/* `where`: the directory, or the URL of the database. */
bool sql_open(store *s, const char *where, fault *why);
void sql_close(store *s);

/* For the doors: makes the tables as they are now of those of `version`, 0 if there are none, -1 if
 * that cannot be told. `become` runs a text and writes the version it leads to, both or none. False
 * with *why for a version that is not known, else when `become` fails. */
bool sql_make_tables(store *s, int version, bool (*become)(store *s, const char *text, int version),
                     fault *why);

void sql_text(store *s, statement k, const char *name, const char *text);
void sql_long(store *s, statement k, const char *name, int64_t value);
void sql_real(store *s, statement k, const char *name, double value);
void sql_blob(store *s, statement k, const char *name, const void *bytes, size_t size);
void sql_row(store *s, statement k, const job_row *row); /* all store_columns, first of all */

/* One step: STORE_OK with a row, STORE_NONE at the end; after it sql_reset. */
store_result sql_step(store *s, statement k);
void sql_reset(store *s, statement k);

/* A statement that gives no rows, with the reset; the second says STORE_NONE if it changed none. */
store_result sql_run(store *s, statement k);
store_result sql_change(store *s, statement k);

void sql_get_text(store *s, statement k, int c, char *room, size_t size);
int64_t sql_get_long(store *s, statement k, int c);
double sql_get_real(store *s, statement k, int c);

/* The one job, every job, the blob (malloc'ed), the number that a statement gives (`none` if it
 * gives none, `unknown` if it fails); with the reset. */
store_result sql_fetch(store *s, statement k, job_row *row);
store_result sql_visit(store *s, statement k, store_visit *visit, void *context);
void *sql_fetch_blob(store *s, statement k, size_t *size);
double sql_number_of(store *s, statement k, double none, double unknown);

bool sql_is_open(const store *s); /* is there a transaction? */

#endif
