/* store_tables.h - the tables of the store and all statements on them, as text: one table of them,
 * written in the words of SQLite or of PostgreSQL. Test: unit.store, unit.store.postgres.
 */
#ifndef SCATTERD_STORE_TABLES_H
#define SCATTERD_STORE_TABLES_H

#include <stddef.h>

enum { STORE_VERSION = 2 }; /* of the tables */

typedef enum { DIALECT_SQLITE, DIALECT_POSTGRES, DIALECTS } dialect;

typedef enum { TEXT, INT, LONG, REAL } kind;

typedef struct {
  const char *name;
  kind kind;
  size_t offset, size;
} column;

/* All of a job_row but its number, in the order in which statements name them. */
enum { STORE_COLUMNS = 30 };
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
  JOB_BYTES,
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
  STATEMENTS_OF_ONE, /* those up to here are all that a single daemon needs */
  BEAT = STATEMENTS_OF_ONE,
  CLOCK,
  LEAVE,
  RELEASE,
  TAKE,
  WAITING,
  ACTIVE_OF,
  LOCK_JOBS,
  HELD,
  RELEASE_DEAD,
  CLAIM_DEAD,
  FREE_CALLS,
  FORGET_DEAD,
  FORGET_TURNS,
  CLAIM,
  DONE_BATCHES,
  PART_ACTIVE,
  PART_PROGRESS,
  PROGRESS,
  DISMISS_PARTS,
  TELL,
  RELAX,
  CLAIM_CALL,
  ADD_LARGE,
  LARGE,
  DROP_LARGE,
  REMOVE_LARGE,
  ADOPT_LARGE,
  FORGET_DRAFTS,
  STATEMENTS
} statement;

enum { STORE_NAMES = 14, STORE_NAME = 20 };

/* The parameters of a statement: numbered from 1, those of a row first; some have names. */
typedef struct {
  int parameters, count;
  struct {
    char name[STORE_NAME]; /* with its colon */
    int place;
  } named[STORE_NAMES];
} store_names;

typedef struct {
  size_t used;
  char text[8192];
  store_names names;
} store_text;

/* What makes the tables of STORE_VERSION; what makes version `from` + 1 of version `from`. */
void store_write_schema(dialect d, store_text *q);
void store_write_step(dialect d, int from, store_text *q);

void store_write_statement(dialect d, statement k, store_text *q);

#endif
