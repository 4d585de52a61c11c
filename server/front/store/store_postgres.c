/* The only door to libpq.
 *
 * Statements are waited for, each within POSTGRES_PATIENCE: over a socket on the same machine they
 * take 0.1 ms, in a transaction the time of one fsync, which is what they take in SQLite as well. A
 * database that does not answer in time is given up at once, and from then on statements fail
 * without any waiting, until the connection is made anew. */
#include "store_postgres.h"

/* ---- Statements ---- */

static bool send_bound(store *s, statement k) {
  postgres *b = postgres_of(s);
  char name[16];
  postgres_name(k, name);
  const int sent = PQsendQueryPrepared(b->link, name, s->names[k].parameters, b->value, b->length,
                                       b->is_bytes, 1);
  postgres_unbind(b);
  return sent == 1;
}

/* Reads the results of all that was sent before; the first failure. */
static store_result read_pending(postgres *b) {
  while (b->pending > 0) {
    PGresult *result;
    b->pending--;
    const store_result end = postgres_read(b, &result);
    PQclear(result);
    if (end != STORE_OK && b->broken == STORE_OK) b->broken = end;
  }
  return b->broken;
}

static store_result execute(store *s, statement k) {
  postgres *b = postgres_of(s);
  if (b->state != POSTGRES_UP) return STORE_DOWN;
  if (!send_bound(s, k) || (b->is_open && PQsendFlushRequest(b->link) == 0)) {
    return postgres_failure(b, NULL);
  }
  const store_result before = read_pending(b);
  if (b->state != POSTGRES_UP) return STORE_DOWN;
  const store_result end = postgres_read(b, &b->result[k]);
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
  postgres *b = postgres_of(s);
  if (b->result[k] == NULL) {
    const store_result end = execute(s, k);
    postgres_unbind(b);
    if (end != STORE_OK) return end;
  }
  return ++b->row[k] < PQntuples(b->result[k]) ? STORE_OK : STORE_NONE;
}

static void reset(store *s, statement k) {
  postgres *b = postgres_of(s);
  PQclear(b->result[k]);
  b->result[k] = NULL;
}

/* ---- Transactions ---- */

static store_result begin(postgres *b) {
  b->broken = STORE_OK;
  b->pending = 0;
  b->is_open = PQenterPipelineMode(b->link) == 1;
  return b->is_open ? STORE_OK : postgres_failure(b, NULL);
}

/* Reads all there is, until nothing is on its way. */
static store_result end_pipeline(postgres *b) {
  PGresult *sync = NULL;
  if (PQpipelineSync(b->link) == 0) return postgres_failure(b, NULL);
  const store_result end = read_pending(b);
  if (b->state != POSTGRES_UP) return STORE_DOWN;
  sync = postgres_await(b);
  const bool is_synced = PQresultStatus(sync) == PGRES_PIPELINE_SYNC;
  PQclear(sync);
  if (is_synced && PQexitPipelineMode(b->link) == 1) return end;
  return postgres_failure(b, NULL);
}

/* A transaction that has failed is not ended by COMMIT, but still there after it. */
static store_result end_transaction(postgres *b) {
  const store_result end = end_pipeline(b);
  b->is_open = b->state == POSTGRES_UP && PQtransactionStatus(b->link) != PQTRANS_IDLE;
  if (!b->is_open) b->broken = STORE_OK;
  return end == STORE_OK && b->is_open ? STORE_FAILED : end;
}

static store_result undo(postgres *b) {
  if (PQpipelineStatus(b->link) != PQ_PIPELINE_OFF) (void)end_pipeline(b);
  const store_result end = b->state == POSTGRES_UP ? postgres_run_text(b, "ROLLBACK") : STORE_DOWN;
  b->is_open = false;
  b->broken = STORE_OK;
  return end;
}

static store_result run(store *s, statement k) {
  enum { LARGE_PIECE = 65536 };
  postgres *b = postgres_of(s);
  size_t size = 0;
  if (b->state != POSTGRES_UP) {
    postgres_unbind(b);
    return STORE_DOWN;
  }
  if (k == ROLLBACK) return undo(b);
  if (k == BEGIN && begin(b) != STORE_OK) return STORE_DOWN;
  if (!b->is_open) {
    const store_result end = step(s, k);
    reset(s, k);
    return end == STORE_NONE ? STORE_OK : end;
  }
  for (int p = 0; p < POSTGRES_PARAMETERS; p++) size += (size_t)b->length[p];
  if (!send_bound(s, k) || (size > LARGE_PIECE && !postgres_flush(b)))
    return postgres_failure(b, NULL);
  b->pending++;
  return k == COMMIT ? end_transaction(b) : STORE_OK;
}

static bool is_open(const store *s) {
  return postgres_of(s)->is_open;
}

const store_door store_postgres = {
    .dialect = DIALECT_POSTGRES,
    .shared = true,
    .open = postgres_open,
    .close = postgres_close,
    .bind_text = postgres_bind_text,
    .bind_long = postgres_bind_long,
    .bind_real = postgres_bind_real,
    .bind_bytes = postgres_bind_bytes,
    .step = step,
    .run = run,
    .reset = reset,
    .changes = postgres_changes,
    .is_null = postgres_is_null,
    .get_long = postgres_get_long,
    .get_real = postgres_get_real,
    .get_bytes = postgres_get_bytes,
    .is_open = is_open,
    .tend = postgres_tend,
    .descriptor = postgres_descriptor,
    .hear = postgres_hear,
    .has_news = postgres_has_news,
};
