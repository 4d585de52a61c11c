/* doc.h - a decoded document: one data model for JSON and CBOR bodies.
 *
 * Arrays of numbers (nested ones too, if rectangular and up to three deep) are one node with the
 * numbers side by side, never a node per number. All memory of a document belongs to its arena.
 */
#ifndef SCATTERD_DOC_H
#define SCATTERD_DOC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum {
  DOC_NULL,
  DOC_BOOL,
  DOC_NUMBER,
  DOC_TEXT,
  DOC_LIST, /* of anything that is not a rectangular array of numbers */
  DOC_OBJECT,
  DOC_NUMBERS /* [shape[0]] .. [shape[0]][shape[1]][shape[2]]; an empty array is one of rank 1 */
} doc_kind;

enum { DOC_RANK_MAX = 3, DOC_DEPTH_MAX = 500 };

typedef struct doc doc;
struct doc {
  doc_kind kind;
  const char *key;    /* within an object, NUL-terminated; else NULL */
  const doc *next;    /* sibling */
  const doc *child;   /* LIST, OBJECT: first child */
  int64_t count;      /* LIST, OBJECT: children; NUMBERS: numbers in all */
  bool truth;         /* BOOL */
  double number;      /* NUMBER; may be NaN or infinite: the reader refuses it by name */
  const char *text;   /* TEXT: valid UTF-8, NUL-terminated */
  size_t length;      /* TEXT: bytes; may contain NUL */
  const double *data; /* NUMBERS */
  int rank;           /* NUMBERS */
  int64_t shape[DOC_RANK_MAX];
};

typedef struct doc_arena doc_arena;

/* Limits a decoder keeps. */
typedef struct {
  int depth;       /* nesting of containers */
  int64_t nodes;   /* nodes of the document (an array of numbers is one) */
  int64_t numbers; /* numbers in all arrays together */
} doc_limits;

/* What is wrong with a body. */
typedef struct {
  int64_t offset;    /* byte where decoding stopped */
  bool too_large;    /* a limit, not the syntax */
  char pointer[256]; /* JSON pointer to the value concerned, "" for the whole body */
  char text[256];    /* subject, got, needed */
} doc_error;

/* Decode a whole body; nothing may follow it. Returns the root, or NULL with `error` filled. The
 * text may hold NaN, Infinity and -Infinity where a number may stand (JSON has none, but a client
 * that sends them deserves a pointer): they become numbers that are not finite. A key twice in an
 * object is an error. *arena owns everything and is set in either case; free with doc_arena_free.
 * doc_from_json: RFC 8259, strict. doc_from_cbor: RFC 8949 with RFC 8746 typed arrays (tags 64-79
 * little and big endian integers, 80-86 floats, 40 and 1040 shapes). */
const doc *doc_from_json(const char *body, size_t size, const doc_limits *limits, doc_arena **arena,
                         doc_error *error);
const doc *doc_from_cbor(const void *body, size_t size, const doc_limits *limits, doc_arena **arena,
                         doc_error *error);

/* Member of an object, NULL if absent or `d` is no object. Child k of a list, NULL past its end. */
const doc *doc_member(const doc *d, const char *key);
const doc *doc_at(const doc *list, int64_t k);

/* "a number", "a string", "an array of 3 numbers", "an array of 5 x 2 numbers", "null" ...: what
 * stands there, for messages. `room` is where the text may be built. */
const char *doc_describe(const doc *d, char *room, size_t size);

/* Arena: memory that lives as long as the document. NULL when out of memory. */
doc_arena *doc_arena_new(void);
void *doc_arena_take(doc_arena *arena, size_t bytes); /* aligned to 16, not zeroed */
void doc_arena_free(doc_arena **arena);

#endif
