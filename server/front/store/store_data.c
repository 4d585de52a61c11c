/* Values under /data. */
#include <math.h>
#include <stdio.h>

#include "store_sql.h"

int store_data_files(const store *s) {
  return s->data;
}

store_result store_data_add(store *s, const data_row *row) {
  sql_text(s, ADD_DATA, ":id", row->id);
  sql_text(s, ADD_DATA, ":type", row->type);
  sql_long(s, ADD_DATA, ":size", row->size);
  sql_real(s, ADD_DATA, ":created", row->created);
  sql_real(s, ADD_DATA, ":expires", row->expires);
  sql_text(s, ADD_DATA, ":owner", row->owner);
  return sql_run(s, ADD_DATA);
}

store_result store_data(store *s, const char *id, data_row *row) {
  *row = (data_row){0};
  snprintf(row->id, sizeof row->id, "%s", id);
  sql_text(s, DATA, ":id", id);
  const store_result result = sql_step(s, DATA);
  if (result == STORE_OK) {
    sql_get_text(s, DATA, 0, row->type, sizeof row->type);
    row->size = sql_get_long(s, DATA, 1);
    row->created = sql_get_real(s, DATA, 2);
    row->expires = sql_get_real(s, DATA, 3);
    sql_get_text(s, DATA, 4, row->owner, sizeof row->owner);
  }
  sql_reset(s, DATA);
  return result;
}

int64_t store_data_bytes(store *s, const char *owner) {
  sql_text(s, DATA_BYTES, ":owner", owner);
  return (int64_t)sql_number_of(s, DATA_BYTES, 0, -1);
}

store_result store_data_renew(store *s, const char *id, double expires) {
  sql_text(s, RENEW_DATA, ":id", id);
  sql_real(s, RENEW_DATA, ":expires", expires);
  return sql_run(s, RENEW_DATA);
}

store_result store_data_pinned(store *s, const char *id) {
  sql_text(s, DATA_PINNED, ":id", id);
  const store_result result = sql_step(s, DATA_PINNED);
  sql_reset(s, DATA_PINNED);
  return result;
}

store_result store_data_expired(store *s, double now, char id[DATA_ID]) {
  sql_real(s, DATA_EXPIRED, ":now", now);
  const store_result result = sql_step(s, DATA_EXPIRED);
  if (result == STORE_OK) sql_get_text(s, DATA_EXPIRED, 0, id, DATA_ID);
  sql_reset(s, DATA_EXPIRED);
  return result;
}

double store_data_first_expiry(store *s, double unknown) {
  return sql_number_of(s, DATA_FIRST_EXPIRY, INFINITY, unknown);
}

store_result store_data_remove(store *s, const char *id, double most) {
  sql_text(s, REMOVE_DATA, ":id", id);
  sql_real(s, REMOVE_DATA, ":most", most);
  return sql_change(s, REMOVE_DATA);
}
