/* store_sql.h - the only door to SQLite: a database with its statements, as the files of the store
 * use it. Parameters have names, columns numbers from 0. Test: unit.store.
 */
#ifndef SCATTERD_STORE_SQL_H
#define SCATTERD_STORE_SQL_H

#include "store.h"
#include "store_tables.h"

struct store {
  struct sqlite3 *db;
  struct sqlite3_stmt *statement[STATEMENTS];
  int directory, files, data, lock; /* descriptors */
};

bool sql_open(store *s, const char *path, fault *why);
void sql_close(store *s);

void sql_text(store *s, statement k, const char *name, const char *text);
void sql_long(store *s, statement k, const char *name, int64_t value);
void sql_real(store *s, statement k, const char *name, double value);
void sql_blob(store *s, statement k, const char *name, const void *bytes, size_t size);
void sql_row(store *s, statement k, const job_row *row); /* all store_columns, first of all */

/* One step: STORE_OK with a row, STORE_NONE at the end; after it sql_reset. */
store_result sql_step(store *s, statement k);
void sql_reset(store *s, statement k);

/* A statement that gives no rows, with the reset. */
store_result sql_run(store *s, statement k);

void sql_get_text(store *s, statement k, int c, char *room, size_t size);
int64_t sql_get_long(store *s, statement k, int c);
double sql_get_real(store *s, statement k, int c);

/* The one job, every job, the blob (malloc'ed), the number that a statement gives; with the reset.
 */
store_result sql_fetch(store *s, statement k, job_row *row);
store_result sql_visit(store *s, statement k, store_visit *visit, void *context);
void *sql_fetch_blob(store *s, statement k, size_t *size);
double sql_number_of(store *s, statement k, double otherwise);

int64_t sql_last_number(const store *s); /* of the row added last */
bool sql_is_open(const store *s);        /* is there a transaction? */

#endif
