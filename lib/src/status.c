#include "scatter/status.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const struct {
  const char *name, *text;
} table[] = {
#define ROW(code, name, text) {name, text},
    SCT_STATUS_LIST(ROW)
#undef ROW
};

const char *sct_status_name(sct_status code) {
  return (unsigned)code < SCT_STATUS_COUNT ? table[code].name : "unknown";
}

const char *sct_status_text(sct_status code) {
  return (unsigned)code < SCT_STATUS_COUNT ? table[code].text : "unknown status";
}

sct_status sct_fail(sct_error *err, sct_status code, int64_t point, const char *format, ...) {
  if (err == NULL) return code;
  memset(err, 0, sizeof *err);
  err->code = code;
  err->point = point;
  if (point >= 0) sct_error_add_point(err, point);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(err->text, sizeof err->text, format, arguments);
  va_end(arguments);
  return code;
}

void sct_error_add_point(sct_error *err, int64_t point) {
  if (err == NULL) return;
  if (err->count < SCT_ERROR_POINTS) err->points[err->count] = point;
  err->count++;
}

void sct_error_merge(sct_error *into, const sct_error *from) {
  if (into == NULL) return;
  if (into->code == SCT_OK) {
    *into = *from;
    return;
  }
  const int64_t kept = from->count < SCT_ERROR_POINTS ? from->count : SCT_ERROR_POINTS;
  for (int64_t k = 0; k < kept; k++) sct_error_add_point(into, from->points[k]);
  into->count += from->count - kept;
}

/* Appends to room, which stays terminated whatever its size. */
static SCT_PRINTF(3, 4) void append(char *room, size_t size, const char *format, ...) {
  const size_t used = strlen(room);
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(room + used, size - used, format, arguments);
  va_end(arguments);
}

const char *sct_error_message(const sct_error *err, char *room, size_t size) {
  const int64_t listed = err->count < SCT_ERROR_POINTS ? err->count : SCT_ERROR_POINTS;
  if (size == 0) return room;
  room[0] = '\0';
  if (err->point >= 0) append(room, size, "point %" PRId64 " ", err->point);
  append(room, size, "%s", err->text);
  if (err->point < 0 || err->count < 2) return room;
  append(room, size, " (and %" PRId64 " more points:", err->count - 1);
  for (int64_t k = 1; k < listed; k++) {
    append(room, size, "%s %" PRId64, k > 1 ? "," : "", err->points[k]);
  }
  append(room, size, "%s)", listed < err->count ? ", ..." : "");
  return room;
}

int sct_work_threads(const sct_work *work) {
  return work != NULL && work->threads > 1 ? work->threads : 1;
}

void sct_work_residual(const sct_work *work, double value) {
  if (work != NULL && work->residual != NULL) work->residual(work->context, value);
}

sct_status sct_work_report(const sct_work *work, const char *phase, double fraction,
                           sct_error *err) {
  if (work == NULL || work->report == NULL || work->report(work->context, phase, fraction)) {
    return SCT_OK;
  }
  return sct_fail(err, SCT_E_CANCELLED, -1, "cancelled in phase %s", phase);
}
