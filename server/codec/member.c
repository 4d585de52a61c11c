#include "member.h"

#include <math.h>

void member_number(emit *e, const char *key, double value) {
  if (!isfinite(value)) return;
  emit_key(e, key);
  emit_number(e, value);
}

void member_integer(emit *e, const char *key, int64_t value) {
  emit_key(e, key);
  emit_integer(e, value);
}

void member_text(emit *e, const char *key, const char *value) {
  if (!value) return;
  emit_key(e, key);
  emit_text(e, value);
}

void member_bool(emit *e, const char *key, bool value) {
  emit_key(e, key);
  emit_bool(e, value);
}

void member_object(emit *e, const char *key) {
  emit_key(e, key);
  emit_object(e);
}

void member_doubles(emit *e, const char *key, const double *value, int64_t n) {
  emit_key(e, key);
  emit_array(e, value, n);
}

void emit_array(emit *e, const double *value, int64_t n) {
  emit_doubles(e, value, 1, &n);
}

void emit_rows(emit *e, const double *value, int64_t n, int components) {
  const int64_t shape[2] = {n, components};
  emit_doubles(e, value, 2, shape);
}
