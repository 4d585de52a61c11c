/* What belongs to a job beside its row: calls to subscribers, small bytes, log. */
#include "store_sql.h"

/* ---- Calls to subscribers ---- */

store_result store_add_call(store *s, int64_t job, int address, double when) {
  sql_long(s, ADD_CALL, ":number", job);
  sql_long(s, ADD_CALL, ":kind", address);
  sql_real(s, ADD_CALL, ":due", when);
  return sql_run(s, ADD_CALL);
}

store_result store_calls(store *s, int most, store_call *visit, void *context) {
  store_result result;
  sql_long(s, CALLS, ":limit", most);
  while ((result = sql_step(s, CALLS)) == STORE_OK) {
    const job_call call = {sql_get_long(s, CALLS, 0), sql_get_long(s, CALLS, 1),
                           (int)sql_get_long(s, CALLS, 2), (int)sql_get_long(s, CALLS, 3),
                           sql_get_real(s, CALLS, 4)};
    visit(context, &call);
  }
  sql_reset(s, CALLS);
  return result == STORE_NONE ? STORE_OK : result;
}

store_result store_update_call(store *s, const job_call *call) {
  sql_long(s, UPDATE_CALL, ":number", call->number);
  sql_long(s, UPDATE_CALL, ":attempts", call->attempts);
  sql_real(s, UPDATE_CALL, ":due", call->due);
  return sql_run(s, UPDATE_CALL);
}

store_result store_remove_call(store *s, int64_t number) {
  sql_long(s, REMOVE_CALL, ":number", number);
  return sql_run(s, REMOVE_CALL);
}

/* ---- Small bytes of jobs ---- */

store_result store_add_small(store *s, int64_t job, int which, const void *bytes, size_t size) {
  sql_long(s, ADD_SMALL, ":number", job);
  sql_long(s, ADD_SMALL, ":kind", which);
  sql_blob(s, ADD_SMALL, ":bytes", bytes, size);
  return sql_run(s, ADD_SMALL);
}

void *store_small(store *s, int64_t job, int which, size_t *size) {
  sql_long(s, SMALL, ":number", job);
  sql_long(s, SMALL, ":kind", which);
  return sql_fetch_blob(s, SMALL, size);
}

store_result store_drop_small(store *s, int64_t job, int which) {
  sql_long(s, DROP_SMALL, ":number", job);
  sql_long(s, DROP_SMALL, ":kind", which);
  return sql_run(s, DROP_SMALL);
}

/* ---- Log of a job ---- */

store_result store_log(store *s, int64_t number, double time, const char *text) {
  sql_long(s, LOG, ":number", number);
  sql_real(s, LOG, ":time", time);
  sql_text(s, LOG, ":text", text);
  return sql_run(s, LOG);
}

store_result store_read_log(store *s, int64_t number, int most, store_line *visit, void *context) {
  store_result result;
  sql_long(s, READ_LOG, ":number", number);
  sql_long(s, READ_LOG, ":limit", most);
  while ((result = sql_step(s, READ_LOG)) == STORE_OK) {
    char text[512];
    sql_get_text(s, READ_LOG, 1, text, sizeof text);
    visit(context, sql_get_real(s, READ_LOG, 0), text);
  }
  sql_reset(s, READ_LOG);
  return result == STORE_NONE ? STORE_OK : result;
}
