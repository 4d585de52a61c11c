#include "emit.h"

#include <stdlib.h>
#include <string.h>

#include "emit_back.h"

static const emit_back *const backs[] = {
    [EMIT_JSON] = &emit_back_json, [EMIT_CBOR] = &emit_back_cbor};

emit *emit_new(emit_format format) {
  emit *e = calloc(1, sizeof *e);
  if (e != NULL) e->back = backs[format];
  return e;
}

void emit_free(emit **e) {
  if (*e == NULL) return;
  free((*e)->bytes.data);
  free(*e);
  *e = NULL;
}

bool emit_ok(const emit *e) {
  return !e->failed;
}

const void *emit_bytes(const emit *e, size_t *size) {
  *size = e->bytes.size;
  return e->bytes.data;
}

void *emit_take(emit *e, size_t *size) {
  void *bytes = e->bytes.data;
  *size = e->bytes.size;
  *e = (emit){.back = e->back};
  return bytes;
}

char *emit_take_text(emit *e, size_t *size) {
  char *end = emit_room(e, 1);
  if (end == NULL) return NULL;
  *end = '\0';
  return emit_take(e, size);
}

char *emit_room(emit *e, size_t n) {
  char *room = e->failed ? NULL : grow_room(&e->bytes, n);
  e->failed = room == NULL;
  return room;
}

void emit_used(emit *e, const char *end) {
  e->bytes.size = (size_t)(end - e->bytes.data);
}

void emit_raw(emit *e, const char *bytes, size_t n) {
  char *room = emit_room(e, n);
  if (room == NULL) return;
  if (n > 0) memcpy(room, bytes, n);
  emit_used(e, room + n);
}

/* Before each value: it must be due, and may need a separator. */
static bool begin(emit *e) {
  bool misplaced = e->depth == 0 ? e->filled[0] : e->object[e->depth] != e->keyed;
  e->failed = e->failed || misplaced;
  if (e->failed) return false;
  if (e->back->separates && e->filled[e->depth] && !e->keyed) emit_raw(e, ",", 1);
  e->filled[e->depth] = true;
  e->keyed = false;
  return !e->failed;
}

static void open_container(emit *e, bool object) {
  if (!begin(e)) return;
  if (e->depth == EMIT_DEPTH_MAX) {
    e->failed = true;
    return;
  }
  e->depth++;
  e->object[e->depth] = object;
  e->filled[e->depth] = false;
  e->back->open(e, object);
}

void emit_object(emit *e) {
  open_container(e, true);
}

void emit_list(emit *e) {
  open_container(e, false);
}

void emit_end(emit *e) {
  e->failed = e->failed || e->depth == 0 || e->keyed;
  if (e->failed) return;
  e->back->close(e, e->object[e->depth--]);
}

void emit_key(emit *e, const char *key) {
  e->failed = e->failed || !e->object[e->depth] || e->keyed;
  if (e->failed) return;
  if (e->back->separates && e->filled[e->depth]) emit_raw(e, ",", 1);
  e->back->key(e, key, strlen(key));
  e->keyed = true;
}

void emit_null(emit *e) {
  if (begin(e)) e->back->null(e);
}

void emit_bool(emit *e, bool value) {
  if (begin(e)) e->back->boolean(e, value);
}

void emit_number(emit *e, double value) {
  if (begin(e)) e->back->number(e, value);
}

void emit_integer(emit *e, int64_t value) {
  if (begin(e)) e->back->integer(e, value);
}

void emit_text(emit *e, const char *text) {
  emit_text_n(e, text, strlen(text));
}

void emit_text_n(emit *e, const char *text, size_t length) {
  if (begin(e)) e->back->text(e, text, length);
}

int64_t emit_count(int rank, const int64_t *shape) {
  int64_t n = 1;
  for (int k = 0; k < rank; k++) n *= shape[k];
  return n;
}

/* The bytes of an array must be countable. */
static bool begin_array(emit *e, int rank, const int64_t *shape) {
  int64_t bytes = sizeof(double);
  bool sane = rank >= 1 && rank <= DOC_RANK_MAX;
  for (int k = 0; k < rank && sane; k++) {
    sane = shape[k] >= 0 && !__builtin_mul_overflow(bytes, shape[k], &bytes);
  }
  e->failed = e->failed || !sane;
  return begin(e);
}

void emit_doubles(emit *e, const double *data, int rank, const int64_t *shape) {
  if (begin_array(e, rank, shape)) e->back->doubles(e, data, rank, shape);
}

void emit_int32s(emit *e, const int32_t *data, int rank, const int64_t *shape) {
  if (begin_array(e, rank, shape)) e->back->int32s(e, data, rank, shape);
}

static void emit_children(emit *e, const doc *d) {
  for (const doc *child = d->child; child != NULL; child = child->next) {
    if (child->key != NULL) emit_key(e, child->key);
    emit_doc(e, child);
  }
  emit_end(e);
}

void emit_doc(emit *e, const doc *d) {
  switch (d->kind) {
    case DOC_NULL:
      emit_null(e);
      break;
    case DOC_BOOL:
      emit_bool(e, d->truth);
      break;
    case DOC_NUMBER:
      emit_number(e, d->number);
      break;
    case DOC_TEXT:
      emit_text_n(e, d->text, d->length);
      break;
    case DOC_NUMBERS:
      emit_doubles(e, d->data, d->rank, d->shape);
      break;
    case DOC_LIST:
      emit_list(e), emit_children(e, d);
      break;
    case DOC_OBJECT:
      emit_object(e), emit_children(e, d);
      break;
  }
}
