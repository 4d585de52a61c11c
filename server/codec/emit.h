/* emit.h - writes a document as JSON or CBOR, number arrays in bulk.
 *
 * Calls describe the document in order: emit_object, then emit_key and a value for each member,
 * then emit_end; emit_list, values, emit_end. After the first failure (memory, or a call that does
 * not fit: a value without its key, an end too many, a shape below zero) all calls do nothing and
 * emit_ok is false, so only the end needs a check.
 * Text should be UTF-8; a byte that is none (a message cut short) becomes U+FFFD.
 * JSON numbers are the shortest text that reads back bit for bit; integers without fraction or
 * exponent up to 2^53. NaN and infinities have no JSON: they are written as null. CBOR has them;
 * its objects and lists are of indefinite length, its numbers floats as short as keeps their value,
 * its arrays of numbers typed arrays (tag 86 for double, 78 for int32; tag 40 around them for a
 * shape). Tests: unit.emit.
 */
#ifndef SCATTERD_EMIT_H
#define SCATTERD_EMIT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "doc.h"

typedef enum { EMIT_JSON, EMIT_CBOR } emit_format;
typedef struct emit emit;

emit *emit_new(emit_format format); /* NULL when out of memory */
void emit_free(emit **e);
bool emit_ok(const emit *e);

/* The bytes so far; valid until the next call on `e`. */
const void *emit_bytes(const emit *e, size_t *size);

/* Hands them over: malloc'ed, NULL if there are none; `e` is as new. */
void *emit_take(emit *e, size_t *size);

/* The same with a NUL behind them, which does not count; NULL when anything has failed. */
char *emit_take_text(emit *e, size_t *size);

void emit_object(emit *e);
void emit_list(emit *e);
void emit_end(emit *e);
void emit_key(emit *e, const char *key);
void emit_null(emit *e);
void emit_bool(emit *e, bool value);
void emit_number(emit *e, double value);
void emit_integer(emit *e, int64_t value);
void emit_text(emit *e, const char *text);
void emit_text_n(emit *e, const char *text, size_t length);
/* rank 1 to 3, as in doc.h: shape[0] numbers, or shape[0] rows of shape[1], ... */
void emit_doubles(emit *e, const double *data, int rank, const int64_t *shape);
void emit_int32s(emit *e, const int32_t *data, int rank, const int64_t *shape);
/* A decoded document as a value. Recursion as deep as the document. */
void emit_doc(emit *e, const doc *d);

#endif
