/* lift.h - finds the arrays of numbers in a stream of values; keeps limits and paths.
 *
 * A decoder tells a lift what it reads, in order. All numbers go side by side into one array of
 * doubles. Around them, only what is not a rectangular array of numbers reaches the decoder's sink
 * piece by piece; an array of numbers (up to DOC_RANK_MAX deep) reaches it as one piece, once it is
 * complete. Until then nothing but counts is kept of it, so a million rows cost nothing but their
 * numbers. Every call is O(1) on average, whatever the nesting: what an array held back is
 * delivered at most once. No recursion.
 */
#ifndef SCATTERD_LIFT_H
#define SCATTERD_LIFT_H

#include "doc.h"

/* Takes the pieces. Each returns false when out of memory. */
typedef struct {
  bool (*open)(void *sink, doc_kind kind); /* DOC_LIST or DOC_OBJECT */
  bool (*close)(void *sink, doc_kind kind);
  bool (*number)(void *sink); /* the next of `values`, standing alone */
  bool (*numbers)(void *sink, int rank, const int64_t *shape); /* the next ones of `values` */
} lift_sink;

typedef enum {
  LIFT_EMPTY,   /* an array without elements yet */
  LIFT_NUMBERS, /* so far numbers only: held back */
  LIFT_ROWS,    /* so far arrays of numbers of one shape only: held back */
  LIFT_GIVEN,   /* open in the sink */
  LIFT_SHAPED   /* [dimensions, numbers] of which an array is to be made */
} lift_state;

/* A container that is open. */
typedef struct {
  doc_kind kind;
  lift_state state;
  int64_t count; /* elements complete */
  int rank;      /* of a row; SHAPED: of the result */
  int64_t shape[DOC_RANK_MAX];
  bool by_columns; /* SHAPED: first index fastest */
  const char *key; /* OBJECT: member being read, else NULL */
  size_t key_length;
  size_t first_key; /* OBJECT: where its keys begin in `keys` */
  int64_t left;     /* free for the decoder */
} lift_frame;

typedef struct {
  const char *key;
  size_t length;
  int64_t offset;
} lift_key_entry;

typedef struct {
  doc_limits limits;
  const lift_sink *sink;
  void *context; /* of the sink */
  doc_error *error;
  lift_frame *frames; /* 0: the whole body (DOC_NULL), then the open containers */
  int depth;          /* containers open */
  int given;          /* frames [0, given) are open in the sink */
  int64_t nodes;
  double *values;
  size_t count, capacity;
  lift_key_entry *keys; /* of all open objects */
  size_t key_count, key_capacity;
} lift;

/* Depth is at most DOC_DEPTH_MAX, whatever the limits say. False when out of memory. */
bool lift_start(lift *l, const doc_limits *limits, const lift_sink *sink, void *context,
                doc_error *error);
void lift_stop(lift *l); /* frees all but what lift_take_values took */

/* What comes next. False with l->error filled: a limit, a key twice, a wrong shape, no memory. */
bool lift_number(lift *l, double value);
bool lift_other(lift *l); /* null, a bool or a text, which the decoder hands to its sink itself */
bool lift_open(lift *l, doc_kind kind);
bool lift_open_shaped(lift *l, bool by_columns);
bool lift_close(lift *l);

/* Key of the next value; the bytes stay valid until the object is closed. */
bool lift_key(lift *l, const char *key, size_t length, int64_t offset);

/* n numbers at once as one array: room to write them to, then lift_array. NULL: error filled. */
double *lift_room(lift *l, uint64_t n);
bool lift_array(lift *l, int64_t n);

/* The container that is open; frame 0 if none. */
lift_frame *lift_top(lift *l);

/* Numbers of the whole body; the caller frees them. */
double *lift_take_values(lift *l);

/* Fills l->error with the pointer to the value being read, or (inside false) to the open
 * container. Returns false. The offset is the decoder's matter. */
bool lift_fail(lift *l, bool inside, const char *format, ...) __attribute__((format(printf, 3, 4)));
bool lift_no_memory(lift *l);

#endif
