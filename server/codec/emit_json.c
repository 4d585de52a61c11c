/* JSON as RFC 8259 writes it, no white space. */
#include <math.h>
#include <string.h>

#include "emit_back.h"
#include "number_text.h"
#include "utf8.h"

static void json_open(emit *e, bool object) {
  emit_raw(e, object ? "{" : "[", 1);
}

static void json_close(emit *e, bool object) {
  emit_raw(e, object ? "}" : "]", 1);
}

static void json_null(emit *e) {
  emit_raw(e, "null", 4);
}

static void json_bool(emit *e, bool value) {
  emit_raw(e, value ? "true" : "false", value ? 4 : 5);
}

/* ---- numbers ---- */

static char *print_double(char *to, double value) {
  if (isfinite(value)) return number_print(to, value);
  return (char *)memcpy(to, "null", 4) + 4;  // NOLINT(bugprone-not-null-terminated-result): no end
}

static void json_number(emit *e, double value) {
  char *room = emit_room(e, NUMBER_TEXT_MAX);
  if (room != NULL) emit_used(e, print_double(room, value));
}

static void json_integer(emit *e, int64_t value) {
  char *room = emit_room(e, NUMBER_TEXT_MAX);
  if (room != NULL) emit_used(e, number_print_integer(room, value));
}

/* "[a,b,c]" in pieces, so that the room asked for stays near what is used. */
#define JSON_ROW(name, type, print)                                            \
  static void name(emit *e, const type *data, int64_t n) {                     \
    enum { PIECE = 512 };                                                      \
    int64_t k = 0;                                                             \
    do {                                                                       \
      int64_t stop = n - k < PIECE ? n : k + PIECE;                            \
      char *to = emit_room(e, (size_t)(stop - k + 1) * (NUMBER_TEXT_MAX + 1)); \
      if (to == NULL) return;                                                  \
      if (k == 0) *to++ = '[';                                                 \
      for (; k < stop; k++) {                                                  \
        to = print(to, data[k]);                                               \
        *to++ = ',';                                                           \
      }                                                                        \
      if (k == n && n > 0) to--;                                               \
      if (k == n) *to++ = ']';                                                 \
      emit_used(e, to);                                                        \
    } while (k < n);                                                           \
  }

/* An array is a row, or arrays of one dimension less within brackets. */
#define JSON_ARRAY(name, type, row)                                             \
  static void name(emit *e, const type *data, int rank, const int64_t *shape) { \
    if (rank == 1) {                                                            \
      row(e, data, shape[0]);                                                   \
      return;                                                                   \
    }                                                                           \
    int64_t step = emit_count(rank - 1, shape + 1);                             \
    emit_raw(e, "[", 1);                                                        \
    for (int64_t k = 0; k < shape[0] && !e->failed; k++) {                      \
      if (k > 0) emit_raw(e, ",", 1);                                           \
      name(e, data + k * step, rank - 1, shape + 1);                            \
    }                                                                           \
    emit_raw(e, "]", 1);                                                        \
  }

JSON_ROW(row_of_doubles, double, print_double)
JSON_ROW(row_of_int32s, int32_t, number_print_integer)
JSON_ARRAY(json_doubles, double, row_of_doubles)
JSON_ARRAY(json_int32s, int32_t, row_of_int32s)

/* ---- text ---- */

/* Must be escaped: '"', '\' and control characters. */
static bool is_plain(unsigned char c) {
  return c >= 0x20 && c < 0x80 && c != '"' && c != '\\';
}

static void escape(emit *e, unsigned char c) {
  static const char hex[] = "0123456789abcdef", codes[] = "\"\\\b\f\n\r\t", names[] = "\"\\bfnrt";
  const char *code = c == 0 ? NULL : strchr(codes, c);
  char text[6] = {'\\', 'u', '0', '0', hex[c >> 4], hex[c & 15]};
  if (code != NULL) text[1] = names[code - codes];
  emit_raw(e, text, code == NULL ? 6 : 2);
}

/* Writes the character at p, U+FFFD for a byte that is no UTF-8 (a message cut short may end in
 * one). Returns where the next one begins. */
static const char *character(emit *e, const char *p, const char *end) {
  size_t step = utf8_step(p, end);
  if (step == 1) escape(e, (unsigned char)*p);
  if (step == 0) emit_raw(e, "\xEF\xBF\xBD", 3);
  if (step > 1) emit_raw(e, p, step);
  return p + (step == 0 ? 1 : step);
}

static void json_text(emit *e, const char *text, size_t length) {
  const char *p = text, *end = text + length;
  emit_raw(e, "\"", 1);
  while (p < end) {
    const char *run = p;
    while (p < end && is_plain((unsigned char)*p)) p++;
    emit_raw(e, run, (size_t)(p - run));
    if (p < end) p = character(e, p, end);
  }
  emit_raw(e, "\"", 1);
}

static void json_key(emit *e, const char *key, size_t length) {
  json_text(e, key, length);
  emit_raw(e, ":", 1);
}

const emit_back emit_back_json = {
    .separates = true,
    .open = json_open,
    .close = json_close,
    .key = json_key,
    .null = json_null,
    .boolean = json_bool,
    .number = json_number,
    .integer = json_integer,
    .text = json_text,
    .doubles = json_doubles,
    .int32s = json_int32s,
};
