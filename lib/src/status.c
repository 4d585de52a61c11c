#include "scatter/status.h"

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

int sct_work_threads(const sct_work *work) {
  return work != NULL && work->threads > 1 ? work->threads : 1;
}

sct_status sct_work_report(const sct_work *work, const char *phase, double fraction,
                           sct_error *err) {
  if (work == NULL || work->report == NULL || work->report(work->context, phase, fraction)) {
    return SCT_OK;
  }
  return sct_fail(err, SCT_E_CANCELLED, -1, "cancelled in phase %s", phase);
}
