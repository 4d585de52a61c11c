/* decode_csv.c - lines of numbers between commas. */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "doc.h"
#include "doc_tree.h"
#include "grow.h"
#include "number_text.h"

typedef struct {
  const char *at, *end;
  const char *first; /* of the body, for offsets */
  const doc_limits *limits;
  doc_error *error;
  double *numbers;
  size_t count, capacity;
  int64_t rows, columns; /* columns: 0 before the first row */
} csv;

static bool fail(csv *f, const char *format, ...) __attribute__((format(printf, 2, 3)));
static bool fail(csv *f, const char *format, ...) {
  va_list list;
  va_start(list, format);
  int used = snprintf(f->error->text, sizeof f->error->text, "row %" PRId64 ": ", f->rows);
  vsnprintf(f->error->text + used, sizeof f->error->text - (size_t)used, format, list);
  va_end(list);
  snprintf(f->error->pointer, sizeof f->error->pointer, "/%" PRId64, f->rows);
  f->error->offset = f->at - f->first;
  return false;
}

static const char *skip_blanks(const char *at, const char *end) {
  while (at < end && (*at == ' ' || *at == '\t')) at++;
  return at;
}

/* Names for numbers JSON has none for. */
static const char *parse_word(const char *at, const char *end, double *value) {
  static const struct {
    const char *word;
    double value;
  } words[] = {{"nan", NAN}, {"inf", INFINITY}, {"-inf", -INFINITY}};
  for (size_t k = 0; k < sizeof words / sizeof *words; k++) {
    const size_t length = strlen(words[k].word);
    if ((size_t)(end - at) < length || strncasecmp(at, words[k].word, length) != 0) continue;
    *value = words[k].value;
    return at + length;
  }
  return NULL;
}

/* A number and the blanks around it; NULL if none stands there. */
static const char *parse_number(const char *at, const char *end, double *value) {
  at = skip_blanks(at, end);
  if (at < end && *at == '+') at++;
  const char *after = number_parse(at, end, value);
  if (after == NULL) after = parse_word(at, end, value);
  return after != NULL ? skip_blanks(after, end) : NULL;
}

/* Where the line ends, before its CR LF or LF. */
static const char *line_end(const csv *f, const char **next) {
  const char *lf = memchr(f->at, '\n', (size_t)(f->end - f->at));
  const char *end = lf != NULL ? lf : f->end;
  *next = lf != NULL ? lf + 1 : f->end;
  return end > f->at && end[-1] == '\r' ? end - 1 : end;
}

static bool is_all_numbers(const char *at, const char *end) {
  double ignored;
  while ((at = parse_number(at, end, &ignored)) != NULL) {
    if (at == end) return true;
    if (*at++ != ',') return false;
  }
  return false;
}

/* A first line without numbers. One that begins like a number is a row, if a bad one: taken for a
 * header, it would be lost without a word. */
static bool is_header(const char *at, const char *end) {
  const char *first = skip_blanks(at, end);
  bool begins_number = first < end && memchr("+-.0123456789", *first, 13) != NULL;
  return !begins_number && !is_all_numbers(at, end);
}

static bool add_number(csv *f, double value) {
  if ((int64_t)f->count >= f->limits->numbers) {
    f->error->too_large = true;
    return fail(f, "more than %" PRId64 " numbers", f->limits->numbers);
  }
  double *larger = grow(f->numbers, &f->capacity, f->count + 1, sizeof *larger);
  if (larger == NULL) {
    doc_no_memory(f->error);
    return false;
  }
  f->numbers = larger;
  f->numbers[f->count++] = value;
  return true;
}

static bool read_row(csv *f, const char *end) {
  int64_t columns = 0;
  double value;
  for (;;) {
    const char *after = parse_number(f->at, end, &value);
    if (after == NULL || (after < end && *after != ',')) {
      return fail(f, "column %" PRId64 " is no number", columns);
    }
    if (!add_number(f, value)) return false;
    columns++;
    f->at = after;
    if (after == end) break;
    f->at++;
  }
  if (f->columns == 0) f->columns = columns;
  if (columns != f->columns) {
    return fail(f, "got %" PRId64 " columns, needs %" PRId64 " like the first", columns,
                f->columns);
  }
  f->rows++;
  return true;
}

static bool read_rows(csv *f) {
  const char *next;
  if (f->end - f->at >= 3 && memcmp(f->at, "\xEF\xBB\xBF", 3) == 0) f->at += 3;
  if (f->at < f->end) {
    const char *end = line_end(f, &next);
    if (is_header(f->at, end)) f->at = next;
  }
  while (f->at < f->end) {
    const char *end = line_end(f, &next);
    if (!read_row(f, end)) return false;
    f->at = next;
  }
  return true;
}

static doc *make(csv *f, doc_arena *arena) {
  doc *d = doc_arena_take(arena, sizeof *d);
  double *numbers = f->numbers;
  if (d == NULL) return NULL;
  f->numbers = NULL; /* the arena's from here on */
  if (numbers != NULL && !doc_arena_keep(arena, numbers)) return NULL;
  *d = (doc){.kind = DOC_NUMBERS,
             .count = (int64_t)f->count,
             .data = numbers,
             .rank = f->columns > 1 ? 2 : 1,
             .shape = {f->rows, f->columns > 1 ? f->columns : 0}};
  return d;
}

const doc *doc_from_csv(const char *body, size_t size, const doc_limits *limits, doc_arena **arena,
                        doc_error *error) {
  csv f = {.at = body, .first = body, .end = body + size, .limits = limits, .error = error};
  const doc *d = NULL;
  *error = (doc_error){0};
  *arena = doc_arena_new();
  if (*arena == NULL) {
    doc_no_memory(error);
  } else if (read_rows(&f)) {
    d = make(&f, *arena);
    if (d == NULL) doc_no_memory(error);
  }
  free(f.numbers);
  return d;
}
