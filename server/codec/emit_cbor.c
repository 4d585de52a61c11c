/* CBOR as RFC 8949 writes it, arrays of numbers as RFC 8746. Containers are of indefinite length,
 * because they are written before their end is known. The only door to libcbor for encoding. */
#include <cbor.h>
#include <endian.h>
#include <math.h>
#include <string.h>

#include "emit_back.h"
#include "utf8.h"

enum { HEAD_MAX = 9, TAG_ROWS = 40, TAG_INT32 = 78, TAG_DOUBLE = 86 };

/* Writes a head. `encoded`: a call of one of libcbor's encoders that writes to `h`. */
#define HEAD(e, encoded)                \
  do {                                  \
    unsigned char h[HEAD_MAX];          \
    size_t used = (encoded);            \
    emit_raw(e, (const char *)h, used); \
  } while (0)

static void cbor_open(emit *e, bool object) {
  if (object) {
    HEAD(e, cbor_encode_indef_map_start(h, HEAD_MAX));
  } else {
    HEAD(e, cbor_encode_indef_array_start(h, HEAD_MAX));
  }
}

static void cbor_close(emit *e, bool object) {
  (void)object;
  HEAD(e, cbor_encode_break(h, HEAD_MAX));
}

static void cbor_null(emit *e) {
  HEAD(e, cbor_encode_null(h, HEAD_MAX));
}

static void cbor_boolean(emit *e, bool value) {
  HEAD(e, cbor_encode_bool(value, h, HEAD_MAX));
}

/* The shorter of single and double that keeps the value. */
static void cbor_number(emit *e, double value) {
  bool fits = isnan(value) || fabs(value) <= 0x1.fffffep127 || isinf(value);
  if (fits && (isnan(value) || (double)(float)value == value)) {
    HEAD(e, cbor_encode_single((float)value, h, HEAD_MAX));
  } else {
    HEAD(e, cbor_encode_double(value, h, HEAD_MAX));
  }
}

/* -1 - n stands for a negative integer, which is ~n in two's complement. */
static void cbor_integer(emit *e, int64_t value) {
  if (value < 0) {
    HEAD(e, cbor_encode_negint(~(uint64_t)value, h, HEAD_MAX));
  } else {
    HEAD(e, cbor_encode_uint((uint64_t)value, h, HEAD_MAX));
  }
}

/* ---- text ---- */

static void definite_text(emit *e, const char *text, size_t length) {
  HEAD(e, cbor_encode_string_start(length, h, HEAD_MAX));
  emit_raw(e, text, length);
}

/* A text that is not all UTF-8 goes in chunks, with U+FFFD for each byte that is none. */
static void repaired_text(emit *e, const char *text, size_t length) {
  HEAD(e, cbor_encode_indef_string_start(h, HEAD_MAX));
  for (const char *end = text + length; text < end;) {
    size_t good = utf8_prefix(text, (size_t)(end - text));
    if (good > 0) definite_text(e, text, good);
    text += good;
    if (text == end) break;
    definite_text(e, "\xEF\xBF\xBD", 3);
    text++;
  }
  HEAD(e, cbor_encode_break(h, HEAD_MAX));
}

static void cbor_text(emit *e, const char *text, size_t length) {
  bool valid = utf8_prefix(text, length) == length;
  (valid ? definite_text : repaired_text)(e, text, length);
}

/* ---- arrays ---- */

/* [shape, numbers] within tag 40 if there are rows; then the head of the bytes of the numbers. */
static void array_head(emit *e, int rank, const int64_t *shape, uint64_t tag, size_t bytes) {
  if (rank > 1) {
    HEAD(e, cbor_encode_tag(TAG_ROWS, h, HEAD_MAX));
    HEAD(e, cbor_encode_array_start(2, h, HEAD_MAX));
    HEAD(e, cbor_encode_array_start((size_t)rank, h, HEAD_MAX));
    for (int k = 0; k < rank; k++) HEAD(e, cbor_encode_uint((uint64_t)shape[k], h, HEAD_MAX));
  }
  HEAD(e, cbor_encode_tag(tag, h, HEAD_MAX));
  HEAD(e, cbor_encode_bytestring_start(bytes, h, HEAD_MAX));
}

/* Numbers in little-endian order: one copy, and the turning is free where the host has it so. */
#define CBOR_ARRAY(name, type, raw, little, tag)                                \
  static void name(emit *e, const type *data, int rank, const int64_t *shape) { \
    size_t n = (size_t)emit_count(rank, shape);                                 \
    array_head(e, rank, shape, tag, n * sizeof *data);                          \
    char *room = emit_room(e, n * sizeof *data);                                \
    if (room == NULL) return;                                                   \
    for (size_t k = 0; k < n; k++) {                                            \
      raw bits;                                                                 \
      memcpy(&bits, &data[k], sizeof bits);                                     \
      bits = little(bits);                                                      \
      memcpy(room + k * sizeof bits, &bits, sizeof bits);                       \
    }                                                                           \
    emit_used(e, room + n * sizeof *data);                                      \
  }

CBOR_ARRAY(cbor_doubles, double, uint64_t, htole64, TAG_DOUBLE)
CBOR_ARRAY(cbor_int32s, int32_t, uint32_t, htole32, TAG_INT32)

const emit_back emit_back_cbor = {
    .open = cbor_open,
    .close = cbor_close,
    .key = cbor_text,
    .null = cbor_null,
    .boolean = cbor_boolean,
    .number = cbor_number,
    .integer = cbor_integer,
    .text = cbor_text,
    .doubles = cbor_doubles,
    .int32s = cbor_int32s,
};
