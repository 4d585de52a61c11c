/* emit_back.h - what a format must be able to write: the inside of emit. */
#ifndef SCATTERD_EMIT_BACK_H
#define SCATTERD_EMIT_BACK_H

#include "emit.h"
#include "grow.h"

/* Values are complete when these are called: separators and failures are emit.c's matter. */
typedef struct {
  bool separates; /* values of a container by ',' */
  void (*open)(emit *e, bool object);
  void (*close)(emit *e, bool object);
  void (*key)(emit *e, const char *key, size_t length);
  void (*null)(emit *e);
  void (*boolean)(emit *e, bool value);
  void (*number)(emit *e, double value);
  void (*integer)(emit *e, int64_t value);
  void (*text)(emit *e, const char *text, size_t length);
  void (*doubles)(emit *e, const double *data, int rank, const int64_t *shape);
  void (*int32s)(emit *e, const int32_t *data, int rank, const int64_t *shape);
} emit_back;

extern const emit_back emit_back_json, emit_back_cbor;

enum { EMIT_DEPTH_MAX = DOC_DEPTH_MAX + 12 };

struct emit {
  const emit_back *back;
  grow_bytes bytes;
  bool failed;
  int depth;
  bool object[EMIT_DEPTH_MAX + 1]; /* kinds of the open containers */
  bool filled[EMIT_DEPTH_MAX + 1]; /* a value has been written into it */
  bool keyed;                      /* a key waits for its value */
};

/* Room for n bytes, NULL (and failed) out of memory; then emit_used says where they end. */
char *emit_room(emit *e, size_t n);
void emit_used(emit *e, const char *end);

/* Appends bytes as they are. */
void emit_raw(emit *e, const char *bytes, size_t n);

/* Numbers of an array. */
int64_t emit_count(int rank, const int64_t *shape);

#endif
