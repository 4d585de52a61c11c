/* decode_npy.c - an .npy file: magic, version, length, a header that is a Python literal of a
 * dictionary, then the numbers. The header is read by what numpy writes, with blanks allowed
 * wherever Python allows them. */
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "doc.h"
#include "doc_tree.h"
#include "typed_array.h"

typedef struct {
  const unsigned char *bytes;
  size_t size;
  size_t at, end; /* of the header that is being read */
  doc_error *error;
  const typed_array *type;
  bool has_type, has_order, has_shape;
  bool is_fortran;
  int rank;
  int64_t shape[DOC_RANK_MAX];
  int64_t count;
} npy;

static bool fail(npy *f, const char *format, ...) __attribute__((format(printf, 2, 3)));
static bool fail(npy *f, const char *format, ...) {
  va_list list;
  va_start(list, format);
  int used = snprintf(f->error->text, sizeof f->error->text, "byte %zu: ", f->at);
  vsnprintf(f->error->text + used, sizeof f->error->text - (size_t)used, format, list);
  va_end(list);
  f->error->offset = (int64_t)f->at;
  return false;
}

/* The literal */

static void skip_blanks(npy *f) {
  while (f->at < f->end && strchr(" \t\n", f->bytes[f->at]) && f->bytes[f->at]) f->at++;
}

static bool take(npy *f, const char *token) {
  const size_t length = strlen(token);
  skip_blanks(f);
  if (f->end - f->at < length || memcmp(f->bytes + f->at, token, length) != 0) return false;
  f->at += length;
  return true;
}

static bool need(npy *f, const char *token) {
  return take(f, token) || fail(f, "the header needs %s here", token);
}

/* A string between quotes of either kind, without escapes. */
static bool read_string(npy *f, char room[32]) {
  size_t length = 0;
  skip_blanks(f);
  const char quote = f->at < f->end ? (char)f->bytes[f->at] : 0;
  if (quote != '\'' && quote != '"') return fail(f, "the header needs a string here");
  for (f->at++; f->at < f->end && f->bytes[f->at] != (unsigned char)quote; f->at++) {
    if (length == 31) return fail(f, "a string in the header is too long");
    room[length++] = (char)f->bytes[f->at];
  }
  room[length] = '\0';
  return need(f, (char[]){quote, '\0'});
}

/* "<f8": byte order, kind, width (numpy.dtype.str); as the tag of RFC 8746 of the same type. */
static bool read_type(npy *f) {
  static const struct {
    char kind;
    int tag;
  } kinds[] = {{'u', 64}, {'b', 64}, {'i', 72}, {'f', 79}};
  char text[32], order, kind, extra;
  int width, power = 0;
  skip_blanks(f);
  if (f->at < f->end && f->bytes[f->at] == '[') return fail(f, "a structured type is no number");
  if (!read_string(f, text)) return false;
  // NOLINTNEXTLINE(cert-err34-c): one digit
  bool is_plain = sscanf(text, "%c%c%1d%c", &order, &kind, &width, &extra) == 3 &&
                  strchr("<>|=", order) != NULL;
  for (size_t k = 0; is_plain && k < sizeof kinds / sizeof *kinds; k++) {
    const bool is_little = order != '>' && width > 1;
    while (1 << power < width) power++;
    if (kinds[k].kind != kind || 1 << power != width || (kind == 'b' && width > 1)) continue;
    f->type = typed_array_of((uint64_t)kinds[k].tag + (uint64_t)power + (is_little ? 4 : 0));
  }
  if (f->type == NULL || f->type->width != (size_t)width) {
    f->type = NULL;
    return fail(f, "an array of type %s, needs integers or floats of up to 8 bytes", text);
  }
  f->has_type = true;
  return true;
}

static bool read_order(npy *f) {
  f->is_fortran = take(f, "True");
  f->has_order = f->is_fortran || take(f, "False");
  return f->has_order || fail(f, "fortran_order needs True or False");
}

static bool read_extent(npy *f, int64_t *extent) {
  *extent = 0;
  skip_blanks(f);
  const size_t first = f->at;
  for (; f->at < f->end && f->bytes[f->at] >= '0' && f->bytes[f->at] <= '9'; f->at++) {
    if (*extent > INT64_MAX / 16) return fail(f, "an extent of the shape is too large");
    *extent = 10 * *extent + (f->bytes[f->at] - '0');
  }
  if (f->at > first) (void)take(f, "L"); /* of Python 2 */
  return f->at > first || fail(f, "the shape needs an integer here");
}

static bool read_shape(npy *f) {
  f->rank = 0;
  if (!need(f, "(")) return false;
  while (!take(f, ")")) {
    if (f->rank == DOC_RANK_MAX) return fail(f, "an array of more than %d ranks", DOC_RANK_MAX);
    if (!read_extent(f, &f->shape[f->rank++])) return false;
    if (!take(f, ",")) {
      f->has_shape = true;
      return need(f, ")");
    }
  }
  return f->has_shape = true;
}

static bool read_entry(npy *f) {
  static const struct {
    const char *key;
    bool (*read)(npy *f);
  } entries[] = {{"descr", read_type}, {"fortran_order", read_order}, {"shape", read_shape}};
  char key[32];
  if (!read_string(f, key) || !need(f, ":")) return false;
  for (size_t k = 0; k < sizeof entries / sizeof *entries; k++) {
    if (strcmp(key, entries[k].key) == 0) return entries[k].read(f);
  }
  return fail(f, "the header has an unknown entry");
}

static bool read_header(npy *f) {
  if (!need(f, "{")) return false;
  while (!take(f, "}")) {
    if (!read_entry(f)) return false;
    if (!take(f, ",")) {
      if (!need(f, "}")) return false;
      break;
    }
  }
  skip_blanks(f);
  if (f->at < f->end) return fail(f, "something follows the header");
  return (f->has_type && f->has_order && f->has_shape) ||
         fail(f, "the header needs descr, fortran_order and shape");
}

/* The file around it */

static bool find_header(npy *f) {
  enum { LEAD_1 = 10, LEAD_2 = 12 };
  const unsigned char *b = f->bytes;
  if (f->size < LEAD_2 || memcmp(b, "\x93NUMPY", 6) != 0) return fail(f, "this is no .npy file");
  const bool is_short = b[6] == 1;
  if (b[6] < 1 || b[6] > 3) return fail(f, "version %d.%d of the format is unknown", b[6], b[7]);
  size_t length = (size_t)b[8] | (size_t)b[9] << 8;
  if (!is_short) length |= (size_t)b[10] << 16 | (size_t)b[11] << 24;
  f->at = is_short ? LEAD_1 : LEAD_2;
  if (length > f->size - f->at) return fail(f, "the header is cut off");
  f->end = f->at + length;
  return true;
}

/* Numbers announced are the numbers there. */
static bool count_numbers(npy *f, const doc_limits *limits) {
  int64_t bytes = (int64_t)f->type->width;
  f->count = 1;
  for (int k = 0; k < f->rank; k++) {
    bool is_huge = __builtin_mul_overflow(bytes, f->shape[k], &bytes);
    if (is_huge) return fail(f, "the shape has more numbers than fit into memory");
    f->count *= f->shape[k];
  }
  if (f->count > limits->numbers) {
    f->error->too_large = true;
    return fail(f, "%" PRId64 " numbers, at most %" PRId64 " are allowed", f->count,
                limits->numbers);
  }
  if (bytes == (int64_t)(f->size - f->end)) return true;
  return fail(f, "the shape needs %" PRId64 " bytes, got %zu", bytes, f->size - f->end);
}

/* Column-major to row-major: rank 2 and 3. */
static void transpose(const npy *f, const double *from, double *to) {
  const int64_t *n = f->shape, planes = f->rank == 3 ? n[2] : 1;
  for (int64_t i = 0; i < n[0]; i++) {
    for (int64_t j = 0; j < n[1]; j++) {
      for (int64_t k = 0; k < planes; k++) *to++ = from[i + n[0] * (j + n[1] * k)];
    }
  }
}

static double *load(const npy *f, doc_arena *arena) {
  const size_t bytes = (size_t)f->count * sizeof(double);
  double *numbers = doc_arena_take(arena, bytes);
  if (numbers == NULL) return NULL;
  f->type->load(f->bytes + f->end, f->count, numbers);
  if (!f->is_fortran || f->rank < 2) return numbers;
  double *rows = doc_arena_take(arena, bytes);
  if (rows != NULL) transpose(f, numbers, rows);
  return rows;
}

static doc *make(const npy *f, doc_arena *arena) {
  doc *d = doc_arena_take(arena, sizeof *d);
  double *numbers = d != NULL ? load(f, arena) : NULL;
  if (numbers == NULL) return NULL;
  *d = (doc){.kind = DOC_NUMBERS, .count = f->count, .data = numbers, .rank = f->rank};
  memcpy(d->shape, f->shape, sizeof d->shape);
  if (f->rank == 0) *d = (doc){.kind = DOC_NUMBER, .number = numbers[0]};
  if (f->count == 0) *d = (doc){.kind = DOC_NUMBERS, .rank = 1};
  return d;
}

const doc *doc_from_npy(const void *body, size_t size, const doc_limits *limits, doc_arena **arena,
                        doc_error *error) {
  npy f = {.bytes = body, .size = size, .error = error};
  *error = (doc_error){0};
  *arena = doc_arena_new();
  if (*arena == NULL) {
    doc_no_memory(error);
    return NULL;
  }
  if (!find_header(&f) || !read_header(&f) || !count_numbers(&f, limits)) return NULL;
  doc *d = make(&f, *arena);
  if (d == NULL) doc_no_memory(error);
  return d;
}
