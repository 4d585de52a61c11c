#include "scan_json.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "lift.h"
#include "number_text.h"
#include "utf8.h"

typedef struct {
  const char *start, *at, *end;
  bool fresh; /* a container has just been opened */
  lift lift;
  doc_arena *arena;
  scan_result *out;
} scan;

/* ---- the reduced text ---- */

static bool write_bytes(scan_result *out, const char *bytes, size_t n) {
  char *room = grow_room(&out->text, n);
  if (room == NULL) return false;
  memcpy(room, bytes, n);
  out->text.size += n;
  return true;
}

/* A comma stands between two elements: after anything but a bracket, a colon or the start. */
static bool write_element(scan_result *out, const char *bytes, size_t n) {
  char last = out->text.size == 0 ? '[' : out->text.data[out->text.size - 1];
  bool first = last == '[' || last == '{' || last == ':';
  return (first || write_bytes(out, ",", 1)) && write_bytes(out, bytes, n);
}

static bool sink_open(void *sink, doc_kind kind) {
  return write_element(sink, kind == DOC_OBJECT ? "{" : "[", 1);
}

static bool sink_close(void *sink, doc_kind kind) {
  return write_bytes(sink, kind == DOC_OBJECT ? "}" : "]", 1);
}

static bool sink_number(void *sink) {
  return write_element(sink, "0", 1);
}

static bool sink_numbers(void *sink, int rank, const int64_t *shape) {
  scan_result *out = sink;
  static const char mark[] = {'"', (char)SCAN_ARRAY, '"'};
  scan_shape *shapes =
      grow(out->shapes, &out->shape_capacity, out->shape_count + 1, sizeof *shapes);
  if (shapes == NULL) return false;
  out->shapes = shapes;
  shapes[out->shape_count].rank = rank;
  memcpy(shapes[out->shape_count++].shape, shape, (size_t)rank * sizeof *shape);
  return write_element(out, mark, sizeof mark);
}

static const lift_sink reduced = {sink_open, sink_close, sink_number, sink_numbers};

/* ---- what stands at the cursor ---- */

static bool is_space(char c) {
  return c == ' ' || c == '\n' || c == '\r' || c == '\t';
}

/* The next byte that is no white space, -1 at the end. */
static int peek(scan *s) {
  while (s->at < s->end && is_space(*s->at)) s->at++;
  return s->at < s->end ? (unsigned char)*s->at : -1;
}

static const char *show(const scan *s, char room[16]) {
  if (s->at >= s->end) return "the end of the body";
  unsigned char c = (unsigned char)*s->at;
  snprintf(room, 16, c > 0x20 && c < 0x7F ? "'%c'" : "byte 0x%02X", c);
  return room;
}

static bool wrong(scan *s, bool inside, const char *needed) {
  char room[16];
  return lift_fail(&s->lift, inside, "got %s, needed %s", show(s, room), needed);
}

/* ---- strings ---- */

static int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  c = (char)(c | 0x20);
  return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* \uXXXX at p: its 16 bits, or -1. */
static int32_t unit(const char *p, const char *end) {
  if (end - p < 6 || p[0] != '\\' || p[1] != 'u') return -1;
  int32_t value = 0;
  for (int k = 2; k < 6; k++) {
    int digit = hex_digit(p[k]);
    if (digit < 0) return -1;
    value = value * 16 + digit;
  }
  return value;
}

/* The escape at p: its code point and length, length 0 if it is none. */
static size_t escape(const char *p, const char *end, uint32_t *code) {
  static const char names[] = "\"\\/bfnrt", codes[] = "\"\\/\b\f\n\r\t";
  const char *name = end - p < 2 || p[1] == '\0' ? NULL : strchr(names, p[1]);
  if (name != NULL) {
    *code = (unsigned char)codes[name - names];
    return 2;
  }
  int32_t high = unit(p, end);
  if (high < 0 || (high >= 0xDC00 && high <= 0xDFFF)) return 0;
  *code = (uint32_t)high;
  if (high < 0xD800 || high > 0xDBFF) return 6;
  int32_t low = unit(p + 6, end);
  if (low < 0xDC00 || low > 0xDFFF) return 0;
  *code = 0x10000 + ((uint32_t)(high - 0xD800) << 10) + (uint32_t)(low - 0xDC00);
  return 12;
}

static bool wrong_in_string(scan *s) {
  unsigned char c = s->at < s->end ? (unsigned char)*s->at : ' ';
  if (c < 0x20) {
    return lift_fail(&s->lift, true, "got byte 0x%02X in a string, needed an escape", c);
  }
  if (c >= 0x80) return lift_fail(&s->lift, true, "got byte 0x%02X, needed UTF-8", c);
  return c == '\\' ? lift_fail(&s->lift, true, "got an unknown escape or half a surrogate pair")
                   : wrong(s, true, "the '\"' that ends a string");
}

/* Bytes of the character or escape at the cursor, 0 if it ends the string or is wrong. */
static size_t string_step(const scan *s, uint32_t *code) {
  *code = 1;
  if (s->at == s->end) return 0;
  unsigned char c = (unsigned char)*s->at;
  if (c == '\\') return escape(s->at, s->end, code);
  if (c >= 0x80) return utf8_step(s->at, s->end);
  return c >= 0x20 && c != '"';
}

/* Checks a string and moves behind it; *plain: without escapes. */
static bool skip_string(scan *s, bool *plain) {
  uint32_t code;
  *plain = true;
  s->at++;
  for (size_t step; (step = string_step(s, &code)) > 0; s->at += step) {
    *plain = *plain && *s->at != '\\';
  }
  if (s->at == s->end || *s->at != '"') return wrong_in_string(s);
  s->at++;
  return true;
}

/* A checked string with escapes, from quote to quote: every NUL becomes SCAN_NUL. */
static bool write_escaped(scan *s, const char *from, const char *to) {
  static const char nul = (char)SCAN_NUL;
  for (const char *p = from; p < to;) {
    const char *back = memchr(p, '\\', (size_t)(to - p));
    const char *stop = back == NULL ? to : back;
    if (!write_bytes(s->out, p, (size_t)(stop - p))) return false;
    if (back == NULL) break;
    uint32_t code = 0;
    size_t step = escape(back, to, &code);
    if (!(code == 0 ? write_bytes(s->out, &nul, 1) : write_bytes(s->out, back, step))) return false;
    p = back + step;
  }
  return true;
}

static bool write_string(scan *s, const char *from, const char *to, bool plain) {
  if (!write_element(s->out, from, plain ? (size_t)(to - from) : 1))
    return lift_no_memory(&s->lift);
  return plain || write_escaped(s, from + 1, to) || lift_no_memory(&s->lift);
}

static bool text(scan *s) {
  const char *from = s->at;
  bool plain;
  return skip_string(s, &plain) && lift_other(&s->lift) && write_string(s, from, s->at, plain);
}

/* ---- other values ---- */

static bool word(scan *s, const char *name) {
  size_t n = strlen(name);
  if ((size_t)(s->end - s->at) < n || memcmp(s->at, name, n) != 0) return false;
  s->at += n;
  return true;
}

static bool literal(scan *s) {
  static const char *const names[] = {"true", "false", "null"};
  for (size_t k = 0; k < sizeof names / sizeof names[0]; k++) {
    if (!word(s, names[k])) continue;
    return lift_other(&s->lift) &&
           (write_element(s->out, names[k], strlen(names[k])) || lift_no_memory(&s->lift));
  }
  return wrong(s, true, "a value");
}

static bool not_finite(scan *s) {
  if (word(s, "NaN")) return lift_number(&s->lift, (double)NAN);
  if (word(s, "Infinity")) return lift_number(&s->lift, HUGE_VAL);
  return wrong(s, true, "a value");
}

static bool minus_infinity(scan *s) {
  if (word(s, "-Infinity")) return lift_number(&s->lift, -HUGE_VAL);
  return lift_fail(&s->lift, true, "got a number that is not as JSON writes it");
}

/* Within an array: moves to the number behind the next comma, if that is what comes. */
static bool another_number(scan *s) {
  const char *p = s->at;
  if (p == s->end || *p != ',' || lift_top(&s->lift)->kind != DOC_LIST) return false;
  for (p++; p < s->end && is_space(*p); p++) continue;
  if (p == s->end || !(*p == '-' || (*p >= '0' && *p <= '9'))) return false;
  s->at = p;
  return true;
}

/* One number, and all that follow it in an array: the same as one by one, but faster. */
static bool numbers(scan *s) {
  do {
    double value;
    const char *behind = number_parse(s->at, s->end, &value);
    if (behind == NULL) return minus_infinity(s);
    s->at = behind;
    if (!lift_number(&s->lift, value)) return false;
  } while (another_number(s));
  return true;
}

static bool open_object(scan *s) {
  s->at++;
  s->fresh = true;
  return lift_open(&s->lift, DOC_OBJECT);
}

static bool open_array(scan *s) {
  s->at++;
  s->fresh = true;
  return lift_open(&s->lift, DOC_LIST);
}

typedef bool reader(scan *s);

/* By the first byte. */
static reader *const readers[256] = {
    ['{'] = open_object, ['['] = open_array, ['"'] = text,       ['t'] = literal, ['f'] = literal,
    ['n'] = literal,     ['N'] = not_finite, ['I'] = not_finite, ['-'] = numbers, ['0'] = numbers,
    ['1'] = numbers,     ['2'] = numbers,    ['3'] = numbers,    ['4'] = numbers, ['5'] = numbers,
    ['6'] = numbers,     ['7'] = numbers,    ['8'] = numbers,    ['9'] = numbers,
};

/* Reads a value, or only opens it if it is a container. */
static bool value(scan *s) {
  int c = peek(s);
  reader *read = c < 0 ? NULL : readers[c];
  return read == NULL ? wrong(s, true, "a value") : read(s);
}

/* ---- containers ---- */

/* The key between two quotes, decoded into the arena if it has escapes. */
static bool key_text(scan *s, const char **key, size_t *length, bool plain) {
  if (plain) return true;
  char *copy = doc_arena_take(s->arena, *length), *to = copy;
  if (copy == NULL) return lift_no_memory(&s->lift);
  const char *end = *key + *length;
  for (const char *p = *key; p < end;) {
    uint32_t code;
    size_t step = *p == '\\' ? escape(p, end, &code) : 0;
    if (step == 0) {
      *to++ = *p++;
    } else {
      to += utf8_put(code, to);
      p += step;
    }
  }
  *key = copy;
  *length = (size_t)(to - copy);
  return true;
}

static bool member_key(scan *s) {
  lift_top(&s->lift)->key = NULL;
  if (peek(s) != '"') return wrong(s, false, "a key in '\"'");
  const char *from = s->at, *key = from + 1;
  bool plain;
  if (!skip_string(s, &plain)) return false;
  size_t length = (size_t)(s->at - key) - 1;
  if (!key_text(s, &key, &length, plain)) return false;
  if (!lift_key(&s->lift, key, length, from - s->start)) return false;
  if (!write_string(s, from, s->at, plain)) return false;
  if (peek(s) != ':') return wrong(s, true, "':'");
  s->at++;
  return write_bytes(s->out, ":", 1) || lift_no_memory(&s->lift);
}

/* Within a container: the next element, or its end. */
static bool element(scan *s) {
  bool object = lift_top(&s->lift)->kind == DOC_OBJECT, fresh = s->fresh;
  int c = peek(s);
  s->fresh = false;
  if (c == (object ? '}' : ']')) {
    s->at++;
    return lift_close(&s->lift);
  }
  if (!fresh && c != ',') return wrong(s, false, object ? "',' or '}'" : "',' or ']'");
  if (!fresh) s->at++;
  return (!object || member_key(s)) && value(s);
}

static bool whole(scan *s) {
  if (s->end - s->at >= 3 && memcmp(s->at, "\xEF\xBB\xBF", 3) == 0) {
    return lift_fail(&s->lift, true, "got a byte order mark, needed a value");
  }
  if (!value(s)) return false;
  while (s->lift.depth > 0) {
    if (!element(s)) return false;
  }
  return peek(s) < 0 || wrong(s, true, "the end of the body");
}

/* Where it went wrong as line and column, which count from 1; columns count characters. */
static void locate(const scan *s, doc_error *error) {
  if (error->offset < 0) error->offset = s->at - s->start;
  int64_t line = 1, column = 1;
  for (const char *p = s->start; p < s->start + error->offset; p++) {
    bool end = *p == '\n';
    line += end;
    column = end ? 1 : column + ((*p & 0xC0) != 0x80);
  }
  char text[sizeof error->text];
  memcpy(text, error->text, sizeof text);
  int used = snprintf(error->text, sizeof error->text, "line %" PRId64 ", column %" PRId64 ": ",
                      line, column);
  snprintf(error->text + used, sizeof error->text - (size_t)used, "%s", text);
}

bool scan_json(const char *body, size_t size, const doc_limits *limits, doc_arena *arena,
               scan_result *result, doc_error *error) {
  *result = (scan_result){0};
  scan s = {.start = body, .at = body, .end = body + size, .arena = arena, .out = result};
  bool fine = lift_start(&s.lift, limits, &reduced, result, error) && whole(&s);
  if (fine) result->values = lift_take_values(&s.lift);
  if (!fine) locate(&s, error);
  lift_stop(&s.lift);
  return fine;
}

void scan_result_free(scan_result *result) {
  free(result->text.data);
  free(result->shapes);
  free(result->values);
  *result = (scan_result){0};
}
