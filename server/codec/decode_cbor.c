/* CBOR to document: libcbor's streaming decoder reads one item at a time from the body, so nothing
 * is allocated on a claimed size and nothing recurses; lift finds the arrays of numbers. The only
 * door to libcbor for decoding. */
#include <cbor.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "doc_tree.h"
#include "grow.h"
#include "lift.h"
#include "typed_array.h"
#include "utf8.h"

enum { TAG_NONE = -1, TAG_ROWS = 40, TAG_COLUMNS = 1040, TAG_CBOR = 55799 };
enum { INDEFINITE = -1 };

typedef enum { CHUNKS_NONE, CHUNKS_TEXT, CHUNKS_BYTES } chunks;

typedef struct {
  const unsigned char *start, *at, *end;
  int64_t tag;       /* before the item, or TAG_NONE */
  bool fine;         /* set to false by the callback that finds a fault */
  bool opened;       /* the item read is no whole value: a key, a tag, a chunk, a start */
  chunks chunks;     /* kind of the text or byte string whose chunks come */
  grow_bytes joined; /* the chunks so far */
  lift lift;
  doc_tree tree;
} stream;

/* ---- pieces of the document ---- */

static bool sink_open(void *sink, doc_kind kind) {
  return doc_tree_open(sink, kind);
}

static bool sink_close(void *sink, doc_kind kind) {
  (void)kind;
  doc_tree_close(sink);
  return true;
}

static bool sink_number(void *sink) {
  return doc_tree_number(sink);
}

static bool sink_numbers(void *sink, int rank, const int64_t *shape) {
  return doc_tree_numbers(sink, rank, shape);
}

static const lift_sink to_tree = {sink_open, sink_close, sink_number, sink_numbers};

/* ---- what may stand here ---- */

/* In an object keys and values alternate: finish_value clears the key its value was read for. */
static bool is_key_due(stream *s) {
  const lift_frame *f = lift_top(&s->lift);
  return f->kind == DOC_OBJECT && f->key == NULL;
}

/* Every item but a text or a byte string passes here first. */
static bool admit(stream *s, const char *what) {
  if (s->chunks != CHUNKS_NONE) {
    return lift_fail(&s->lift, true, "got %s within a string of chunks, needed a chunk", what);
  }
  if (is_key_due(s)) return lift_fail(&s->lift, true, "got %s as a key, needed a text", what);
  if (s->tag != TAG_NONE) {
    return lift_fail(&s->lift, true, "got %s behind tag %" PRId64 ", which does not go with it",
                     what, s->tag);
  }
  return true;
}

static void number(stream *s, double value) {
  s->fine = admit(s, "a number") && lift_number(&s->lift, value);
}

static void on_uint8(void *s, uint8_t value) {
  number(s, (double)value);
}
static void on_uint16(void *s, uint16_t value) {
  number(s, (double)value);
}
static void on_uint32(void *s, uint32_t value) {
  number(s, (double)value);
}
static void on_uint64(void *s, uint64_t value) {
  number(s, (double)value);
}
static void on_negative8(void *s, uint8_t value) {
  number(s, -1.0 - (double)value);
}
static void on_negative16(void *s, uint16_t value) {
  number(s, -1.0 - (double)value);
}
static void on_negative32(void *s, uint32_t value) {
  number(s, -1.0 - (double)value);
}
/* Stands for -1 - value: exact in integers, then rounded once. */
static void on_negative64(void *s, uint64_t value) {
  number(s, value == UINT64_MAX ? -0x1p64 : -(double)(value + 1));
}
static void on_float(void *s, float value) {
  number(s, (double)value);
}
static void on_double(void *s, double value) {
  number(s, value);
}

static void on_null(void *context) {
  stream *s = context;
  s->fine = admit(s, "null") && lift_other(&s->lift) &&
            (doc_tree_null(&s->tree) || lift_no_memory(&s->lift));
}

static void on_bool(void *context, bool value) {
  stream *s = context;
  s->fine = admit(s, "a boolean") && lift_other(&s->lift) &&
            (doc_tree_bool(&s->tree, value) || lift_no_memory(&s->lift));
}

static void on_undefined(void *context) {
  stream *s = context;
  s->fine = lift_fail(&s->lift, true, "got undefined, needed a value");
}

/* ---- text and bytes ---- */

static bool take_key(stream *s, const char *text, size_t length) {
  if (!doc_tree_key(&s->tree, text, length)) return lift_no_memory(&s->lift);
  return lift_key(&s->lift, s->tree.key, length, s->at - s->start);
}

static bool take_text(stream *s, const char *text, size_t length) {
  if (s->tag != TAG_NONE) return admit(s, "a text");
  if (is_key_due(s)) {
    s->opened = true;
    return take_key(s, text, length);
  }
  return lift_other(&s->lift) &&
         (doc_tree_text(&s->tree, text, length) || lift_no_memory(&s->lift));
}

static bool take_bytes(stream *s, const unsigned char *bytes, size_t size) {
  const typed_array *type = s->tag == TAG_NONE ? NULL : typed_array_of((uint64_t)s->tag);
  if (type == NULL) {
    return lift_fail(&s->lift, true, "got a byte string, needed a tag of a typed array before it");
  }
  if (size % type->width != 0) {
    return lift_fail(&s->lift, true, "got %zu bytes in a typed array, needed a multiple of %zu",
                     size, type->width);
  }
  double *room = lift_room(&s->lift, size / type->width);
  if (room == NULL) return false;
  int64_t n = (int64_t)(size / type->width);
  type->load(bytes, n, room);
  s->tag = TAG_NONE;
  return lift_array(&s->lift, n);
}

static bool add_chunk(stream *s, chunks kind, const unsigned char *bytes, size_t size) {
  if (kind != s->chunks) {
    return lift_fail(&s->lift, true, "got a chunk of the other kind in a string of chunks");
  }
  char *room = grow_room(&s->joined, size);
  if (room == NULL) return lift_no_memory(&s->lift);
  memcpy(room, bytes, size);
  s->joined.size += size;
  s->opened = true;
  return true;
}

static bool check_utf8(stream *s, const unsigned char *bytes, size_t size) {
  size_t good = utf8_prefix((const char *)bytes, size);
  return good == size ||
         lift_fail(&s->lift, true, "got byte 0x%02X in a text, needed UTF-8", bytes[good]);
}

static void on_text(void *context, cbor_data bytes, size_t size) {
  stream *s = context;
  s->fine = check_utf8(s, bytes, size) &&
            (s->chunks != CHUNKS_NONE ? add_chunk(s, CHUNKS_TEXT, bytes, size)
                                      : take_text(s, (const char *)bytes, size));
}

static void on_bytes(void *context, cbor_data bytes, size_t size) {
  stream *s = context;
  if (s->chunks == CHUNKS_NONE && is_key_due(s)) {
    s->fine = admit(s, "a byte string");
    return;
  }
  s->fine = s->chunks != CHUNKS_NONE ? add_chunk(s, CHUNKS_BYTES, bytes, size)
                                     : take_bytes(s, bytes, size);
}

static void start_chunks(stream *s, chunks kind) {
  s->fine = s->chunks == CHUNKS_NONE || admit(s, "a string of chunks");
  s->chunks = kind;
  s->joined.size = 0;
  s->opened = true;
}

static void on_text_start(void *s) {
  start_chunks(s, CHUNKS_TEXT);
}
static void on_bytes_start(void *s) {
  start_chunks(s, CHUNKS_BYTES);
}

static bool end_chunks(stream *s) {
  chunks kind = s->chunks;
  s->chunks = CHUNKS_NONE;
  if (grow_room(&s->joined, 1) == NULL) return lift_no_memory(&s->lift);
  const unsigned char *bytes = (const unsigned char *)s->joined.data;
  (kind == CHUNKS_TEXT ? on_text : on_bytes)(s, bytes, s->joined.size);
  return s->fine;
}

/* ---- containers and tags ---- */

/* Bytes of the head at `at`: the first one, and those of its argument. */
static int64_t head_size(const unsigned char *at) {
  int argument = *at & 0x1F;
  return argument < 24 ? 1 : 1 + (1 << (argument - 24));
}

/* An item takes at least one byte: a larger claim is refused before anything else. */
static bool check_claim(stream *s, const char *what, uint64_t items, uint64_t least) {
  uint64_t bytes = (uint64_t)(s->end - s->at - head_size(s->at));
  return items <= bytes / least ||
         lift_fail(&s->lift, true,
                   "truncated: %s claims %" PRIu64 " items, %" PRIu64 " bytes follow", what, items,
                   bytes);
}

static bool open_array(stream *s, int64_t items) {
  bool shaped = s->chunks == CHUNKS_NONE && (s->tag == TAG_ROWS || s->tag == TAG_COLUMNS);
  bool by_columns = s->tag == TAG_COLUMNS;
  if (shaped) s->tag = TAG_NONE;
  if (!admit(s, "an array")) return false;
  if (!(shaped ? lift_open_shaped(&s->lift, by_columns) : lift_open(&s->lift, DOC_LIST))) {
    return false;
  }
  lift_top(&s->lift)->left = items;
  s->opened = true;
  return true;
}

static bool open_object(stream *s, int64_t items) {
  if (!admit(s, "a map") || !lift_open(&s->lift, DOC_OBJECT)) return false;
  lift_top(&s->lift)->left = items;
  s->opened = true;
  return true;
}

static void on_array(void *context, size_t items) {
  stream *s = context;
  s->fine = check_claim(s, "an array", items, 1) && open_array(s, (int64_t)items);
}
static void on_endless_array(void *s) {
  ((stream *)s)->fine = open_array(s, INDEFINITE);
}
static void on_object(void *context, size_t members) {
  stream *s = context;
  s->fine = check_claim(s, "a map", members, 2) && open_object(s, (int64_t)members);
}
static void on_endless_object(void *s) {
  ((stream *)s)->fine = open_object(s, INDEFINITE);
}

static bool is_known(uint64_t tag) {
  return tag == TAG_ROWS || tag == TAG_COLUMNS || typed_array_of(tag) != NULL;
}

/* Tag 55799 says only "this is CBOR". Of the others none may be ignored: they change the value. */
static void on_tag(void *context, uint64_t tag) {
  stream *s = context;
  s->opened = true;
  s->fine = admit(s, "a tag");
  if (!s->fine || tag == TAG_CBOR) return;
  if (is_known(tag)) {
    s->tag = (int64_t)tag;
  } else {
    s->fine = lift_fail(&s->lift, true, "got tag %" PRIu64 ", which is not supported", tag);
  }
}

static bool close_endless(stream *s) {
  const lift_frame *f = lift_top(&s->lift);
  bool value_due = f->kind == DOC_OBJECT && f->key != NULL;
  if (s->lift.depth == 0 || f->left != INDEFINITE || value_due || s->tag != TAG_NONE) {
    return lift_fail(&s->lift, true, "got a break, needed a value");
  }
  return lift_close(&s->lift);
}

static void on_break(void *context) {
  stream *s = context;
  s->fine = s->chunks != CHUNKS_NONE ? end_chunks(s) : close_endless(s);
}

static const struct cbor_callbacks callbacks = {
    .uint8 = on_uint8,
    .uint16 = on_uint16,
    .uint32 = on_uint32,
    .uint64 = on_uint64,
    .negint8 = on_negative8,
    .negint16 = on_negative16,
    .negint32 = on_negative32,
    .negint64 = on_negative64,
    .byte_string_start = on_bytes_start,
    .byte_string = on_bytes,
    .string = on_text,
    .string_start = on_text_start,
    .indef_array_start = on_endless_array,
    .array_start = on_array,
    .indef_map_start = on_endless_object,
    .map_start = on_object,
    .tag = on_tag,
    .float2 = on_float,
    .float4 = on_float,
    .float8 = on_double,
    .undefined = on_undefined,
    .null = on_null,
    .boolean = on_bool,
    .indef_break = on_break,
};

/* ---- the body ---- */

static bool truncated(stream *s) {
  if (s->at == s->end) return lift_fail(&s->lift, true, "truncated: got the end, needed a value");
  return lift_fail(&s->lift, true, "truncated: the body ends within an item, %td bytes into it",
                   s->end - s->at);
}

/* Reads one item; of a container, text in chunks or tagged item only the start. */
static bool item(stream *s) {
  s->fine = true;
  s->opened = false;
  struct cbor_decoder_result result =
      cbor_stream_decode(s->at, (size_t)(s->end - s->at), &callbacks, s);
  if (result.status == CBOR_DECODER_NEDATA) return truncated(s);
  if (result.status == CBOR_DECODER_ERROR) {
    return lift_fail(&s->lift, true, "got byte 0x%02X, which begins no CBOR value", *s->at);
  }
  if (s->fine) s->at += result.read;
  return s->fine;
}

/* A value is complete: so are the containers it was the last value of. */
static bool finish_value(stream *s) {
  for (;;) {
    lift_frame *f = lift_top(&s->lift);
    f->key = NULL;
    if (s->lift.depth == 0 || f->left == INDEFINITE || --f->left > 0) return true;
    if (!lift_close(&s->lift)) return false;
  }
}

/* Containers of no items are complete at once. */
static bool finish_empty(stream *s) {
  bool empty = s->lift.depth > 0 && lift_top(&s->lift)->left == 0;
  if (!empty) return true;
  s->opened = false;
  return lift_close(&s->lift) && finish_value(s);
}

static bool whole(stream *s) {
  do {
    if (!item(s)) return false;
    if (!(s->opened ? finish_empty(s) : finish_value(s))) return false;
  } while (s->lift.depth > 0 || s->opened);
  return s->at == s->end ||
         lift_fail(&s->lift, true, "got %td bytes more, needed the end of the body",
                   s->end - s->at);
}

static bool settle(stream *s) {
  double *values = lift_take_values(&s->lift);
  if (values == NULL) return true;
  if (!doc_arena_keep(s->tree.arena, values)) return lift_no_memory(&s->lift);
  doc_tree_settle(&s->tree, values);
  return true;
}

/* "byte 17: got ..., needed ..." */
static void locate(const stream *s, doc_error *error) {
  if (error->offset < 0) error->offset = s->at - s->start;
  char text[sizeof error->text];
  memcpy(text, error->text, sizeof text);
  int used = snprintf(error->text, sizeof error->text, "byte %" PRId64 ": ", error->offset);
  snprintf(error->text + used, sizeof error->text - (size_t)used, "%s", text);
}

const doc *doc_from_cbor(const void *body, size_t size, const doc_limits *limits, doc_arena **arena,
                         doc_error *error) {
  stream s = {.start = body, .at = body, .end = (const unsigned char *)body + size};
  s.tag = TAG_NONE;
  *error = (doc_error){.offset = -1};
  *arena = doc_arena_new();
  bool fine = *arena != NULL && lift_start(&s.lift, limits, &to_tree, &s.tree, error);
  if (!fine) doc_no_memory(error);
  fine = fine &&
         (doc_tree_start(&s.tree, *arena, s.lift.limits.depth) || lift_no_memory(&s.lift)) &&
         whole(&s) && settle(&s);
  if (!fine) locate(&s, error);
  lift_stop(&s.lift);
  free(s.joined.data);
  return fine ? s.tree.root : NULL;
}
