/* Bytes that choose a form and a result - process, outputs, shapes, numbers - which is then written
 * in that form and read back: numbers come back bit for bit, the parts of a multipart are
 * the outputs by themselves, and the arrays of a VTP lie where its XML says. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "answer.h"
#include "doc.h"
#include "emit.h"
#include "form.h"
#include "fuzz.h"
#include "process.h"

enum { ROWS_MAX = 12, COLUMNS_MAX = 7, NUMBERS_MAX = ROWS_MAX * COLUMNS_MAX };

static void require(int holds, const char *what) {
  if (holds) return;
  fprintf(stderr, "does not hold: %s\n", what);
  abort();
}

/* ---- A result from bytes ---- */

typedef struct {
  const uint8_t *at, *end;
} bytes;

static int take(bytes *b, int below) {
  return b->at < b->end ? *b->at++ % below : 0;
}

static double take_number(bytes *b) {
  static const double plain[] = {0, 1, -0.0, 0.1, 1e300, 5e-324, -17, 3};
  const int kind = take(b, 32);
  double value = plain[kind % 8];
  if (kind < 24 || b->end - b->at < (int)sizeof value) return value;
  memcpy(&value, b->at, sizeof value);
  b->at += sizeof value;
  return value;
}

static void emit_array(emit *e, bytes *b, int rank, const int64_t *shape) {
  double number[NUMBERS_MAX];
  int64_t count = 1;
  for (int k = 0; k < rank; k++) count *= shape[k];
  for (int64_t k = 0; k < count; k++) number[k] = take_number(b);
  emit_doubles(e, number, rank, shape);
}

static void emit_other(emit *e, bytes *b) {
  char text[] = "a \"text\"\r\n--part-of-a-result-5ca77e6d\r\n,<&>\\";
  text[take(b, sizeof text)] = '\0';
  emit_object(e);
  emit_key(e, "text");
  emit_text(e, text);
  emit_key(e, "number");
  emit_number(e, take_number(b));
  emit_end(e);
}

/* An output of a role as a process writes it: [n], [n][dim] ...; now and then another. */
static void emit_output(emit *e, bytes *b, output_role role, int rows, int dim) {
  const int kind = take(b, 8);
  int64_t shape[2] = {rows, kind % COLUMNS_MAX + 1};
  if (role == OUTPUT_OTHER) {
    emit_other(e, b);
  } else if (role == OUTPUT_COORDINATES) {
    shape[1] = dim;
    emit_array(e, b, 2, shape);
  } else if (role == OUTPUT_FIELD || role == OUTPUT_COUNTS) {
    emit_array(e, b, role == OUTPUT_COUNTS || kind < 4 ? 1 : 2, shape);
  } else if (role == OUTPUT_TENSOR) {
    shape[1] = dim * (dim + 1) / 2;
    emit_array(e, b, 2, shape);
  } else {
    shape[0] = take(b, ROWS_MAX + 1);
    emit_array(e, b, 1 + kind % 2, shape);
  }
}

static void emit_outputs(emit *e, bytes *b, const process *p) {
  const int rows = take(b, ROWS_MAX + 1), dim = 1 + take(b, 3);
  const unsigned wanted = (unsigned)take(b, 256) | (unsigned)take(b, 256) << 8;
  for (int k = 0; p->outputs[k].name; k++) {
    if (!(wanted & 1u << k)) continue;
    const process_output *o = &p->outputs[k];
    const media format = (media)take(b, MEDIA_COUNT + 1);
    emit_key(e, o->name);
    emit_object(e);
    emit_key(e, "reference");
    emit_bool(e, take(b, 4) == 0);
    if (format != MEDIA_COUNT && form_fits_output(format, o->role)) {
      emit_key(e, "format");
      emit_text(e, media_type(format));
    }
    emit_key(e, "value");
    emit_output(e, b, o->role, rows, dim);
    emit_end(e);
  }
}

static void *stored_result(bytes *b, size_t *size) {
  emit *e = emit_new(EMIT_CBOR);
  const process *p = process_at(take(b, 6));
  emit_object(e);
  emit_key(e, "scatterd");
  emit_text(e, "result 1");
  emit_key(e, "process");
  emit_text(e, p->id);
  emit_key(e, "raw");
  emit_bool(e, take(b, 2));
  emit_key(e, "outputs");
  emit_object(e);
  emit_outputs(e, b, p);
  emit_end(e);
  emit_end(e);
  require(emit_ok(e), "a result");
  void *taken = emit_take(e, size);
  emit_free(&e);
  return taken;
}

/* ---- Rendering it ---- */

typedef struct {
  const void *stored;
  size_t size;
} source;

/* Free the bytes. */
static reply rendered_as(source s, const char *output, media form) {
  static const limits most = {.decoded_bytes = 1 << 20, .depth = 32, .nodes = 10000};
  const ask question = {.work = IPC_RENDER,
                        .output = output,
                        .results_url = "http://here/jobs/1/results",
                        .body = s.stored,
                        .size = s.size,
                        .accept = form == MEDIA_COUNT ? (wishes){0} : media_wish(form),
                        .limits = &most};
  reply r;
  answer(&question, &r);
  require(r.bytes != NULL, "a reply");
  require(r.status == 200 || r.status == 204 || r.status == 400 || r.status == 406, r.detail);
  return r;
}

/* ---- Reading it back ---- */

static const doc *decode(media form, const void *data, size_t size, doc_arena **arena) {
  static const doc_limits most = {DOC_DEPTH_MAX, 100000, 100000};
  doc_error why;
  const doc *d = doc_from(form, data, size, &most, arena, &why);
  if (d == NULL) fprintf(stderr, "%s\n", why.text);
  return d;
}

/* What a number of this role reads as: counts are integers of 32 bits, JSON has no infinities. */
static double as_read(double value, bool is_count, media form) {
  if (is_count) return value >= 0 && value <= INT32_MAX ? (double)(int32_t)value : -1;
  return form == MEDIA_JSON && !isfinite(value) ? NAN : value;
}

static void same_number(double got, double wanted) {
  const bool are_none = isnan(got) && isnan(wanted);
  require(are_none || memcmp(&got, &wanted, sizeof got) == 0, "the same number");
}

/* An array by itself, in a form that is read by doc_from. JSON has null for what is not finite, and
 * is no array of numbers then; an empty array has no shape. */
static void compare_array(const doc *stored, bool is_count, media form, const reply *r) {
  doc_arena *arena = NULL;
  const doc *d = decode(form, r->bytes, r->size, &arena);
  require(d != NULL, "what was written can be read");
  bool is_whole = d->kind == DOC_NUMBERS && stored->count > 0;
  if (form == MEDIA_JSON && d->kind != DOC_NUMBERS) is_whole = false;
  for (int64_t k = 0; is_whole && k < stored->count; k++) {
    require(d->count == stored->count, "as many numbers");
    const double value = as_read(stored->data[k], is_count, form);
    if (d->data[k] != value) same_number(d->data[k], value);
  }
  doc_arena_free(&arena);
}

/* A table by itself: its last columns are the output, behind the coordinates. */
static void compare_table(const doc *stored, const reply *r) {
  doc_arena *arena = NULL;
  const int64_t rows = stored->shape[0], columns = stored->rank == 2 ? stored->shape[1] : 1;
  const doc *d = rows > 0 ? decode(MEDIA_CSV, r->bytes, r->size, &arena) : NULL;
  require(rows == 0 || d != NULL, "a table that can be read");
  const int64_t all = d == NULL || d->rank == 1 ? 1 : d->shape[1];
  require(d == NULL || d->count == rows * all, "as many rows");
  for (int64_t k = 0; d != NULL && k < stored->count; k++) {
    const int64_t column = all - columns + k % columns;
    same_number(d->data[k / columns * all + column], stored->data[k]);
  }
  doc_arena_free(&arena);
}

/* Text from `at` on, up to `end`, where it must be. */
static const char *find(const char *at, const char *end, const char *text) {
  const char *found = memmem(at, (size_t)(end - at), text, strlen(text));
  require(found != NULL, text);
  return found;
}

/* The appended arrays follow each other without gaps, each where an element says, to the end. */
static void check_vtp(const reply *r) {
  const char *at = r->bytes, *end = at + r->size;
  const char *data = find(at, end, "<AppendedData encoding=\"raw\">\n_") + 31;
  uint64_t expected = 0;
  while ((at = memmem(at, (size_t)(data - at), "offset=\"", 8)) != NULL) {
    uint64_t size;
    require(strtoull(at += 8, NULL, 10) == expected, "an array where it is announced");
    require(data + expected + sizeof size <= end, "an array within the file");
    memcpy(&size, data + expected, sizeof size);
    expected += sizeof size + size;
  }
  static const char tail[] = "\n</AppendedData>\n</VTKFile>\n";
  require(data + expected + sizeof tail - 1 == end, "nothing between arrays and end");
  require(memcmp(data + expected, tail, sizeof tail - 1) == 0, "the end");
}

static void check_part(source s, const char *name, const char *type, const char *body,
                       size_t size) {
  media form;
  require(media_find(type, &form), "a type of ours");
  reply alone = rendered_as(s, name, form);
  require(alone.status == 200, "an output by itself");
  require(alone.size == size && memcmp(alone.bytes, body, size) == 0, "a part is the output");
  free(alone.bytes);
}

/* Reads one part from behind its boundary line; returns where its body ends. */
static const char *read_part(source s, const char *at, const char *end) {
  char type[128], name[64], length[32] = "";
  const char *body = find(at, end, "\r\n\r\n") + 4;
  require(sscanf(at, "Content-Type: %127[^\r]\r\nContent-ID: <%63[^>]>\r\n", type, name) == 2,
          "type and name of a part");
  if (memmem(at, (size_t)(body - at), "Content-Location: ", 18) != NULL) return body;
  sscanf(find(at, body, "Content-Length: "), "Content-Length: %31[0-9]", length);
  const size_t size = strtoull(length, NULL, 10);
  require(size <= (size_t)(end - body), "a part within the whole");
  check_part(s, name, type, body, size);
  return body + size;
}

static void check_multipart(source s, const reply *r, int64_t outputs) {
  char boundary[80] = "--";
  const char *at = r->bytes, *end = at + r->size, *named = strstr(r->type, "boundary=");
  require(named != NULL && sscanf(named, "boundary=%70[^;]", boundary + 2) == 1, "a boundary");
  const size_t length = strlen(boundary);
  int64_t parts = 0;
  for (;; parts++) {
    require((size_t)(end - at) >= length + 4 && memcmp(at, boundary, length) == 0, "boundary");
    at += length;
    if (memcmp(at, "--\r\n", 4) == 0) break;
    at = read_part(s, at + 2, end);
    require(memcmp(at, "\r\n", 2) == 0, "a line ends behind a part");
    at += 2;
  }
  require(at + 4 == end && parts == outputs, "all outputs, and nothing behind them");
}

static void check_whole(source s, media form, int64_t outputs) {
  reply r = rendered_as(s, "", form);
  doc_arena *arena = NULL;
  const bool is_made = r.status == 200 && strncmp(r.type, media_type(form), 12) == 0;
  if (is_made && (form == MEDIA_JSON || form == MEDIA_CBOR)) {
    require(decode(form, r.bytes, r.size, &arena) != NULL, "a document that can be read");
  }
  if (is_made && form == MEDIA_VTP) check_vtp(&r);
  if (is_made && form == MEDIA_MULTIPART && outputs > 0) check_multipart(s, &r, outputs);
  doc_arena_free(&arena);
  free(r.bytes);
}

static void check_one(source s, const doc *output, media form) {
  reply r = rendered_as(s, output->key, form);
  const doc *value = doc_member(output, "value");
  const bool is_made = r.status == 200 && strncmp(r.type, media_type(form), 8) == 0;
  if (is_made && form == MEDIA_VTP) check_vtp(&r);
  if (is_made && form == MEDIA_CSV) compare_table(value, &r);
  if (is_made && value->kind == DOC_NUMBERS && form <= MEDIA_NPY && form != MEDIA_PROBLEM) {
    const bool is_count = strcmp(output->key, "neighbours") == 0;
    compare_array(value, is_count, form, &r);
  }
  free(r.bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  bytes b = {data, data + size};
  const media form = (media)take(&b, MEDIA_COUNT);
  doc_arena *arena = NULL;
  source s;
  void *stored = stored_result(&b, &s.size);
  s.stored = stored;
  const doc *root = decode(MEDIA_CBOR, stored, s.size, &arena);
  require(root != NULL, "a stored result that can be read");
  const doc *outputs = doc_member(root, "outputs");
  check_whole(s, form, outputs->count);
  for (const doc *o = outputs->child; o; o = o->next) check_one(s, o, form);
  doc_arena_free(&arena);
  free(stored);
  return 0;
}
