#include "lift.h"

#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "doc_tree.h"
#include "grow.h"

bool lift_start(lift *l, const doc_limits *limits, const lift_sink *sink, void *context,
                doc_error *error) {
  *l = (lift){.limits = *limits, .sink = sink, .context = context, .error = error, .given = 1};
  if (l->limits.depth > DOC_DEPTH_MAX) l->limits.depth = DOC_DEPTH_MAX;
  if (l->limits.depth < 0) l->limits.depth = 0;
  l->frames = calloc((size_t)l->limits.depth + 1, sizeof *l->frames);
  if (l->frames == NULL) return lift_no_memory(l);
  l->frames[0] = (lift_frame){.kind = DOC_NULL, .state = LIFT_GIVEN};
  return true;
}

void lift_stop(lift *l) {
  free(l->frames);
  free(l->values);
  free(l->keys);
  *l = (lift){0};
}

lift_frame *lift_top(lift *l) {
  return &l->frames[l->depth];
}

double *lift_take_values(lift *l) {
  double *values = l->values;
  l->values = NULL;
  return values;
}

/* ---- errors ---- */

/* Appends "/token" with ~ and / escaped (RFC 6901) to the text in pointer[room]; false, and nothing
 * appended, if it does not fit. */
static bool append_token(char *pointer, size_t room, const char *token, size_t length) {
  size_t used = strlen(pointer), start = used, spare = 3; /* an escape of two, and the end */
  bool fits = used + spare <= room;
  if (fits) pointer[used++] = '/';
  for (size_t k = 0; k < length && fits; k++) {
    bool escape = token[k] == '~' || token[k] == '/';
    fits = used + spare <= room;
    if (!fits) break;
    if (escape) pointer[used++] = '~';
    pointer[used++] = !escape ? token[k] : token[k] == '~' ? '0' : '1';
  }
  pointer[fits ? used : start] = '\0';
  return fits;
}

static bool append_frame(char *pointer, size_t room, const lift_frame *frame) {
  if (frame->kind == DOC_OBJECT) {
    return frame->key != NULL && append_token(pointer, room, frame->key, frame->key_length);
  }
  char index[24];
  int length = snprintf(index, sizeof index, "%" PRId64, frame->count);
  return append_token(pointer, room, index, (size_t)length);
}

/* A pointer too long for its room names the innermost container that fits. */
static void point(lift *l, bool inside) {
  char *pointer = l->error->pointer;
  int last = inside ? l->depth : l->depth - 1;
  pointer[0] = '\0';
  for (int k = 1; k <= last; k++) {
    if (!append_frame(pointer, sizeof l->error->pointer, &l->frames[k])) return;
  }
}

bool lift_fail(lift *l, bool inside, const char *format, ...) {
  va_list values;
  va_start(values, format);
  vsnprintf(l->error->text, sizeof l->error->text, format, values);
  va_end(values);
  point(l, inside);
  return false;
}

static bool too_large(lift *l, const char *what, int64_t limit) {
  l->error->too_large = true;
  return lift_fail(l, true, "body has more than %" PRId64 " %s", limit, what);
}

bool lift_no_memory(lift *l) {
  doc_no_memory(l->error);
  return false;
}

/* ---- values ---- */

static bool add_nodes(lift *l, int64_t n) {
  if (n > l->limits.nodes - l->nodes) {
    return too_large(l, "values (an array of numbers is one)", l->limits.nodes);
  }
  l->nodes += n;
  return true;
}

static bool give_numbers(lift *l, int rank, const int64_t *shape) {
  return l->sink->numbers(l->context, rank, shape) || lift_no_memory(l);
}

static bool give_number(lift *l) {
  return l->sink->number(l->context) || lift_no_memory(l);
}

/* Opens a frame in the sink, with the elements it held back. */
static bool give_frame(lift *l, lift_frame *f) {
  if (f->state == LIFT_SHAPED) {
    return lift_fail(l, true, "an array with dimensions needs [dimensions, numbers]");
  }
  if (!add_nodes(l, 1 + f->count)) return false;
  if (!l->sink->open(l->context, f->kind)) return lift_no_memory(l);
  bool fine = true;
  for (int64_t k = 0; k < f->count && fine; k++) {
    fine = f->state == LIFT_ROWS ? give_numbers(l, f->rank, f->shape) : give_number(l);
  }
  f->state = LIFT_GIVEN;
  return fine;
}

/* Something comes that makes no array of numbers: neither are the containers around it. */
static bool give_all(lift *l) {
  for (; l->given <= l->depth; l->given++) {
    if (!give_frame(l, &l->frames[l->given])) return false;
  }
  return true;
}

bool lift_other(lift *l) {
  if (!give_all(l) || !add_nodes(l, 1)) return false;
  lift_top(l)->count++;
  return true;
}

double *lift_room(lift *l, uint64_t n) {
  if (n > (uint64_t)l->limits.numbers || (int64_t)n > l->limits.numbers - (int64_t)l->count) {
    too_large(l, "numbers", l->limits.numbers);
    return NULL;
  }
  double *values = grow(l->values, &l->capacity, l->count + n, sizeof *values);
  if (values == NULL) {
    lift_no_memory(l);
    return NULL;
  }
  l->values = values;
  return values + l->count;
}

bool lift_number(lift *l, double value) {
  double *room = lift_room(l, 1);
  if (room == NULL) return false;
  *room = value;
  l->count++;
  lift_frame *f = lift_top(l);
  if (f->state == LIFT_EMPTY) f->state = LIFT_NUMBERS;
  if (f->state != LIFT_NUMBERS && !(give_all(l) && add_nodes(l, 1) && give_number(l))) return false;
  f->count++;
  return true;
}

/* ---- arrays ---- */

/* Dimensions become the shape of the frame; they are not numbers of the body. */
static bool take_dimensions(lift *l, lift_frame *f, int rank, const int64_t *shape) {
  if (rank != 1 || shape[0] < 1 || shape[0] > DOC_RANK_MAX) {
    return lift_fail(l, true, "dimensions of an array: needed a list of 1 to %d integers",
                     DOC_RANK_MAX);
  }
  f->rank = (int)shape[0];
  l->count -= (size_t)shape[0];
  for (int k = 0; k < f->rank; k++) {
    double n = l->values[l->count + (size_t)k];
    if (!(n >= 0 && n <= 0x1p53 && n == floor(n))) {
      return lift_fail(l, true, "dimension %d of an array: got %g, needed an integer >= 0", k, n);
    }
    f->shape[k] = (int64_t)n;
  }
  f->count++;
  return true;
}

static bool check_dimensions(lift *l, const lift_frame *f, int rank, const int64_t *shape) {
  int64_t product = 1;
  bool overflow = false;
  if (rank != 1) {
    return lift_fail(l, true, "numbers of an array with dimensions: got rows, needed a flat array");
  }
  for (int k = 0; k < f->rank; k++) {
    overflow = overflow || __builtin_mul_overflow(product, f->shape[k], &product);
  }
  if (overflow || product != shape[0]) {
    return lift_fail(l, true,
                     "numbers of an array with dimensions: got %" PRId64
                     ", needed the product of the dimensions",
                     shape[0]);
  }
  return true;
}

/* values[k + K (j + J i)] = columns[i + I (j + J k)], the last index fastest in memory. */
static bool transpose(lift *l, const lift_frame *f) {
  int64_t size[DOC_RANK_MAX] = {1, 1, 1}, n = 1;
  for (int k = 0; k < f->rank; k++) {
    size[k] = f->shape[k];
    n *= size[k];
  }
  double *to = l->values + l->count - n;
  double *columns = malloc((size_t)n * sizeof *columns);
  if (columns == NULL) return lift_no_memory(l);
  memcpy(columns, to, (size_t)n * sizeof *columns);
  for (int64_t i = 0; i < size[0]; i++) {
    for (int64_t j = 0; j < size[1]; j++) {
      for (int64_t k = 0; k < size[2]; k++) *to++ = columns[i + size[0] * (j + size[1] * k)];
    }
  }
  free(columns);
  return true;
}

static bool take_shaped(lift *l, lift_frame *f, int rank, const int64_t *shape) {
  if (f->count == 0) return take_dimensions(l, f, rank, shape);
  if (f->count > 1) {
    return lift_fail(l, true, "an array with dimensions needs [dimensions, numbers] and no more");
  }
  if (!check_dimensions(l, f, rank, shape)) return false;
  f->count++;
  return !f->by_columns || shape[0] == 0 || transpose(l, f);
}

static bool same_shape(const lift_frame *f, int rank, const int64_t *shape) {
  return f->rank == rank && memcmp(f->shape, shape, (size_t)rank * sizeof *shape) == 0;
}

/* A complete array of numbers comes: another row of one shape, or a piece for the sink. */
static bool take_array(lift *l, int rank, const int64_t *shape) {
  lift_frame *f = lift_top(l);
  if (f->state == LIFT_SHAPED) return take_shaped(l, f, rank, shape);
  if (f->state == LIFT_EMPTY && rank < DOC_RANK_MAX && shape[0] > 0) {
    f->state = LIFT_ROWS;
    f->rank = rank;
    memcpy(f->shape, shape, (size_t)rank * sizeof *shape);
  }
  bool row = f->state == LIFT_ROWS && same_shape(f, rank, shape);
  if (!row && !(give_all(l) && add_nodes(l, 1) && give_numbers(l, rank, shape))) return false;
  f->count++;
  return true;
}

bool lift_array(lift *l, int64_t n) {
  l->count += (size_t)n;
  return take_array(l, 1, &n);
}

static bool push(lift *l, lift_frame frame) {
  if (l->depth == l->limits.depth) return too_large(l, "levels of nesting", l->limits.depth);
  frame.first_key = l->key_count;
  l->frames[++l->depth] = frame;
  return true;
}

bool lift_open(lift *l, doc_kind kind) {
  bool array = kind == DOC_LIST;
  return push(l, (lift_frame){.kind = kind, .state = LIFT_EMPTY}) && (array || give_all(l));
}

bool lift_open_shaped(lift *l, bool by_columns) {
  return push(l, (lift_frame){.kind = DOC_LIST, .state = LIFT_SHAPED, .by_columns = by_columns});
}

/* ---- keys ---- */

bool lift_key(lift *l, const char *key, size_t length, int64_t offset) {
  lift_frame *f = lift_top(l);
  f->key = key;
  f->key_length = length;
  if (memchr(key, 0, length) != NULL) {
    l->error->offset = offset;
    return lift_fail(l, true, "a key contains a NUL character");
  }
  lift_key_entry *keys = grow(l->keys, &l->key_capacity, l->key_count + 1, sizeof *keys);
  if (keys == NULL) return lift_no_memory(l);
  l->keys = keys;
  keys[l->key_count++] = (lift_key_entry){key, length, offset};
  return true;
}

static int compare_keys(const lift_key_entry *a, const lift_key_entry *b) {
  size_t shorter = a->length < b->length ? a->length : b->length;
  int order = shorter == 0 ? 0 : memcmp(a->key, b->key, shorter);
  return order != 0 ? order : (a->length > b->length) - (a->length < b->length);
}

static int compare_entries(const void *a, const void *b) {
  const lift_key_entry *x = a, *y = b;
  int order = compare_keys(x, y);
  return order != 0 ? order : (x->offset > y->offset) - (x->offset < y->offset);
}

/* Sorting finds a key that stands twice in O(n log n); of several the first in the body counts. */
static bool check_keys(lift *l, lift_frame *f) {
  size_t n = l->key_count - f->first_key;
  l->key_count = f->first_key;
  if (n < 2) return true;
  lift_key_entry *keys = l->keys + f->first_key, *twice = NULL;
  qsort(keys, n, sizeof *keys, compare_entries);
  for (size_t k = 1; k < n; k++) {
    bool same = compare_keys(&keys[k - 1], &keys[k]) == 0;
    if (same && (twice == NULL || keys[k].offset < twice->offset)) twice = &keys[k];
  }
  if (twice == NULL) return true;
  f->key = twice->key;
  f->key_length = twice->length;
  l->error->offset = twice->offset;
  return lift_fail(l, true, "key \"%.*s\" is there twice in an object",
                   twice->length > 80 ? 80 : (int)twice->length, twice->key);
}

static bool close_given(lift *l, lift_frame *f) {
  if (f->kind == DOC_OBJECT && !check_keys(l, f)) return false;
  l->depth--;
  l->given = l->depth + 1;
  lift_top(l)->count++;
  return l->sink->close(l->context, f->kind) || lift_no_memory(l);
}

bool lift_close(lift *l) {
  lift_frame f = *lift_top(l);
  if (f.state == LIFT_GIVEN) return close_given(l, lift_top(l));
  if (f.state == LIFT_SHAPED && f.count != 2) {
    return lift_fail(l, false, "an array with dimensions needs [dimensions, numbers]");
  }
  l->depth--;
  if (f.state == LIFT_SHAPED) {
    bool empty = false;
    for (int k = 0; k < f.rank; k++) empty = empty || f.shape[k] == 0;
    return empty ? take_array(l, 1, (int64_t[]){0}) : take_array(l, f.rank, f.shape);
  }
  int64_t shape[DOC_RANK_MAX] = {f.count};
  int rank = f.state == LIFT_ROWS ? f.rank : 0;
  for (int k = 0; k < rank; k++) shape[k + 1] = f.shape[k];
  return take_array(l, rank + 1, shape);
}
