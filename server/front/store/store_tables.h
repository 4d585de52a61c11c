/* store_tables.h - the tables of the store and all statements on them, as text. Test: unit.store.
 */
#ifndef SCATTERD_STORE_TABLES_H
#define SCATTERD_STORE_TABLES_H

#include <stddef.h>

enum { STORE_VERSION = 1 }; /* of the tables; PRAGMA user_version */

typedef enum { TEXT, INT, LONG, REAL } kind;

typedef struct {
  const char *name;
  kind kind;
  size_t offset, size;
} column;

/* All of a job_row but its number, in the order in which statements name them. */
enum { STORE_COLUMNS = 27 };
extern const column store_columns[STORE_COLUMNS];

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
  SHIFT_JOBS,
  SHIFT_CALLS,
  SHIFT_DATA,
  STATEMENTS
} statement;

typedef struct {
  size_t used;
  char text[4096];
} store_text;

/* What makes the tables; a statement. */
void store_write_schema(store_text *q);
void store_write_statement(statement k, store_text *q);

#endif
