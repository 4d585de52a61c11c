#include "problem.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "emit.h"
#include "utf8.h"

#define OGC "http://www.opengis.net/def/exceptions/ogcapi-processes-1/1.0/"

static const struct {
  const char *uri, *title;
} types[PROBLEM_TYPES] = {
    [PROBLEM_BLANK] = {"about:blank", NULL},
    [PROBLEM_NO_SUCH_PROCESS] = {OGC "no-such-process", "No such process"},
    [PROBLEM_NO_SUCH_JOB] = {OGC "no-such-job", "No such job"},
    [PROBLEM_RESULT_NOT_READY] = {OGC "result-not-ready", "Result not ready"},
};

static const struct {
  int status;
  const char *phrase;
} phrases[] = {
    {200, "OK"},
    {201, "Created"},
    {204, "No Content"},
    {400, "Bad Request"},
    {401, "Unauthorized"},
    {403, "Forbidden"},
    {404, "Not Found"},
    {405, "Method Not Allowed"},
    {406, "Not Acceptable"},
    {408, "Request Timeout"},
    {409, "Conflict"},
    {410, "Gone"},
    {411, "Length Required"},
    {413, "Content Too Large"},
    {414, "URI Too Long"},
    {415, "Unsupported Media Type"},
    {416, "Range Not Satisfiable"},
    {421, "Misdirected Request"},
    {422, "Unprocessable Content"},
    {429, "Too Many Requests"},
    {431, "Request Header Fields Too Large"},
    {500, "Internal Server Error"},
    {501, "Not Implemented"},
    {503, "Service Unavailable"},
    {504, "Gateway Timeout"},
    {507, "Insufficient Storage"},
};

const char *problem_phrase(int status) {
  for (size_t k = 0; k < sizeof phrases / sizeof *phrases; k++) {
    if (phrases[k].status == status) return phrases[k].phrase;
  }
  return "Error";
}

/* Makes `text` valid UTF-8 in place. If it was cut, a broken character at its end goes. */
static void make_utf8(char *text, bool cut) {
  size_t length = strlen(text);
  for (size_t good; (good = utf8_prefix(text, length)) < length; text += good, length -= good) {
    if (cut && length - good < 4) {
      text[good] = '\0';
      return;
    }
    text[good] = '?';
  }
}

static void write_text(char *text, size_t room, const char *format, va_list arguments) {
  const int length = vsnprintf(text, room, format, arguments);
  if (length < 0) *text = '\0';
  make_utf8(text, length >= 0 && (size_t)length >= room);
}

static void begin(problem *p, problem_type type, int status, const char *format,
                  va_list arguments) {
  p->status = status;
  p->type = type;
  p->count = p->found = 0;
  write_text(p->detail, sizeof p->detail, format, arguments);
}

void problem_begin(problem *p, int status, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  begin(p, PROBLEM_BLANK, status, format, arguments);
  va_end(arguments);
}

void problem_begin_type(problem *p, problem_type type, int status, const char *format, ...) {
  va_list arguments;
  va_start(arguments, format);
  begin(p, type, status, format, arguments);
  va_end(arguments);
}

void problem_add(problem *p, const char *pointer, const char *format, ...) {
  if (p->found++ >= PROBLEM_ERRORS_MAX) return;
  const int k = p->count++;
  const int length = snprintf(p->errors[k].pointer, PROBLEM_POINTER, "%s", pointer);
  make_utf8(p->errors[k].pointer, length >= PROBLEM_POINTER);
  va_list arguments;
  va_start(arguments, format);
  write_text(p->errors[k].detail, PROBLEM_TEXT, format, arguments);
  va_end(arguments);
}

void problem_shorten(const problem *p, char *room, size_t size) {
  static const char mark[] = " ...";
  if (snprintf(room, size, "%s", p->detail) < (int)size) return;
  const size_t most = utf8_prefix(room, size - sizeof mark);
  size_t end = most;
  while (end > 0 && room[end] != ' ') end--;
  memcpy(room + (end > 0 ? end : most), mark, sizeof mark);
}

static void emit_member(emit *e, const char *key, const char *text) {
  emit_key(e, key);
  emit_text(e, text);
}

static void emit_errors(emit *e, const problem *p) {
  emit_key(e, "errors");
  emit_list(e);
  for (int k = 0; k < p->count; k++) {
    emit_object(e);
    emit_member(e, "pointer", p->errors[k].pointer);
    emit_member(e, "detail", p->errors[k].detail);
    emit_end(e);
  }
  emit_end(e);
}

static void emit_problem(emit *e, const problem *p) {
  const char *title = types[p->type].title;
  emit_object(e);
  emit_member(e, "type", types[p->type].uri);
  emit_member(e, "title", title != NULL ? title : problem_phrase(p->status));
  emit_key(e, "status");
  emit_integer(e, p->status);
  emit_member(e, "detail", p->detail);
  if (p->count > 0) emit_errors(e, p);
  emit_end(e);
}

char *problem_bytes(const problem *p, size_t *size) {
  emit *e = emit_new(EMIT_JSON);
  if (e == NULL) return NULL;
  emit_problem(e, p);
  char *text = emit_take_text(e, size);
  emit_free(&e);
  return text;
}
