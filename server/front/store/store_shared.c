#include "store_shared.h"

#include "store_sql.h"

/* ---- The connection ---- */

bool store_is_shared(const store *s) {
  return s->door->shared;
}

bool store_is_up(const store *s) {
  int generation;
  return !s->door->shared || s->door->descriptor(s, &generation) >= 0;
}

bool store_tend(store *s) {
  return s->door->tend(s);
}

int store_descriptor(const store *s, int *generation) {
  return s->door->descriptor(s, generation);
}

char *store_hear(store *s) {
  return s->door->hear(s);
}

bool store_has_news(const store *s) {
  return s->door->has_news(s);
}

/* A statement that gives one row of no interest. */
static store_result run_one(store *s, statement k) {
  const store_result result = sql_step(s, k);
  sql_reset(s, k);
  return result;
}

store_result store_tell(store *s, const char *text) {
  sql_text(s, TELL, ":text", text);
  return sql_run(s, TELL);
}

store_result store_relax(store *s) {
  return sql_run(s, RELAX);
}

/* ---- Daemons ---- */

store_result store_beat(store *s, const char *holder, double *now) {
  sql_text(s, BEAT, ":holder", holder);
  const store_result result = sql_step(s, BEAT);
  if (result == STORE_OK) *now = sql_get_real(s, BEAT, 0);
  sql_reset(s, BEAT);
  return result;
}

store_result store_clock(store *s, double *now) {
  const store_result result = sql_step(s, CLOCK);
  if (result == STORE_OK) *now = sql_get_real(s, CLOCK, 0);
  sql_reset(s, CLOCK);
  return result;
}

void store_leave(store *s, const char *holder) {
  sql_text(s, RELEASE, ":holder", holder);
  (void)sql_run(s, RELEASE);
  sql_text(s, LEAVE, ":holder", holder);
  (void)sql_run(s, LEAVE);
}

store_result store_bury(store *s, const char *holder, double lease) {
  static const statement in_order[] = {RELEASE_DEAD, FREE_CALLS, CLAIM_DEAD, FORGET_DRAFTS,
                                       FORGET_DEAD};
  store_result result = STORE_OK;
  for (size_t k = 0; k < sizeof in_order / sizeof *in_order && result == STORE_OK; k++) {
    sql_real(s, in_order[k], ":lease", lease);
    if (in_order[k] == CLAIM_DEAD) sql_text(s, CLAIM_DEAD, ":holder", holder);
    result = sql_run(s, in_order[k]);
  }
  return result == STORE_OK ? sql_run(s, FORGET_TURNS) : result;
}

/* ---- Jobs ---- */

store_result store_take(store *s, const char *holder, int64_t room, double old, job_row *row) {
  sql_text(s, TAKE, ":holder", holder);
  sql_long(s, TAKE, ":room", room);
  sql_real(s, TAKE, ":old", old);
  return sql_fetch(s, TAKE, row);
}

store_result store_claim(store *s, const char *holder, const job_row *row) {
  sql_text(s, CLAIM, ":holder", holder);
  sql_long(s, CLAIM, ":number", row->number);
  sql_long(s, CLAIM, ":state", row->state);
  return sql_change(s, CLAIM);
}

store_result store_held(store *s, const char *holder, store_visit *visit, void *context) {
  sql_text(s, HELD, ":holder", holder);
  return sql_visit(s, HELD, visit, context);
}

int64_t store_waiting(store *s) {
  return (int64_t)sql_number_of(s, WAITING, -1, -1);
}

int64_t store_active_of(store *s, const char *submitter) {
  sql_text(s, ACTIVE_OF, ":submitter", submitter);
  return (int64_t)sql_number_of(s, ACTIVE_OF, 0, 0);
}

store_result store_lock_jobs(store *s, const char *submitter) {
  sql_text(s, LOCK_JOBS, ":submitter", submitter);
  return sql_run(s, LOCK_JOBS);
}

store_result store_progress(store *s, const job_row *row) {
  sql_long(s, PROGRESS, ":progress", row->progress);
  sql_text(s, PROGRESS, ":message", row->message);
  sql_text(s, PROGRESS, ":phase", row->phase);
  sql_real(s, PROGRESS, ":residual", row->residual);
  sql_real(s, PROGRESS, ":updated", row->updated);
  sql_long(s, PROGRESS, ":number", row->number);
  sql_text(s, PROGRESS, ":holder", row->holder);
  return run_one(s, PROGRESS);
}

/* ---- Batches ---- */

bool store_has_active_part(store *s, int64_t parent) {
  sql_long(s, PART_ACTIVE, ":number", parent);
  return sql_number_of(s, PART_ACTIVE, 1, 1) > 0; /* if it cannot be read: perhaps */
}

double store_part_progress(store *s, int64_t parent) {
  sql_long(s, PART_PROGRESS, ":number", parent);
  return sql_number_of(s, PART_PROGRESS, 0, 0);
}

store_result store_done_batches(store *s, store_visit *visit, void *context) {
  return sql_visit(s, DONE_BATCHES, visit, context);
}

store_result store_dismiss_parts(store *s, int64_t parent, double now) {
  sql_long(s, DISMISS_PARTS, ":number", parent);
  sql_real(s, DISMISS_PARTS, ":now", now);
  return sql_run(s, DISMISS_PARTS);
}

/* ---- Calls to subscribers ---- */

store_result store_claim_call(store *s, const char *holder, const job_call *call) {
  sql_text(s, CLAIM_CALL, ":holder", holder);
  sql_long(s, CLAIM_CALL, ":number", call->number);
  sql_long(s, CLAIM_CALL, ":attempts", call->attempts);
  sql_real(s, CLAIM_CALL, ":due", call->due);
  return sql_change(s, CLAIM_CALL);
}
