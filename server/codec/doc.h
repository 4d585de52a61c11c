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

#include "media.h"

typedef enum {
  DOC_NULL,
  DOC_BOOL,
  DOC_NUMBER,
  DOC_TEXT,
  DOC_LIST, /* of anything that is not a rectangular array of numbers; never empty */
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
  const double *data; /* NUMBERS, last index fastest; may be NULL if there are none */
  int rank;           /* NUMBERS */
  int64_t shape[DOC_RANK_MAX];
  bool by_href; /* it came by reference */
};

typedef struct doc_arena doc_arena;

/* Limits a decoder keeps. They are checked before memory is taken, so a body costs at most about
 * 250 bytes per node, 8 bytes per number (16 while it grows) and three times the length of its
 * texts. */
typedef struct {
  int depth;       /* nesting of containers, at most DOC_DEPTH_MAX */
  int64_t nodes;   /* nodes of the document (an array of numbers is one) */
  int64_t numbers; /* numbers of the document, in arrays or alone */
} doc_limits;

/* What is wrong with a body. */
typedef struct {
  int64_t offset;    /* byte where decoding stopped; of a key twice, where it stands again */
  bool too_large;    /* a limit or memory, not the syntax */
  char pointer[256]; /* JSON pointer (RFC 6901) to the value concerned, "" for the whole body; of
                        one too long the containers that fit */
  char text[256];    /* "line 3, column 9: got ..., needed ..."; of CBOR "byte 17: ..." */
} doc_error;

/* Decode a whole body; nothing may follow it. Returns the root, or NULL with `error` filled. *arena
 * owns everything and is set in either case (NULL if there is no memory even for it); free with
 * doc_arena_free. The body is not needed any more afterwards.
 *
 * Arrays: a list of numbers is one node of rank 1, a list of arrays of one shape is one of a rank
 * more, up to DOC_RANK_MAX. Rows of different lengths stay a list of arrays, each its own node; so
 * do empty rows ([[],[]]), and numbers among other values stay nodes of their own. A key twice in
 * an object, and a key with the character NUL, are errors.
 *
 * doc_from_json: RFC 8259, strict, no byte order mark; half a surrogate pair is refused. Where a
 * number may stand, the text may hold NaN, Infinity and -Infinity (JSON has none, but a client that
 * sends them deserves a pointer): they become numbers that are not finite, as does a number too
 * large for a double. Others are the nearest double. About 30 ns per number of 17 digits.
 *
 * doc_from_cbor: RFC 8949 with the typed arrays of RFC 8746: tags 64-87 but for 128-bit floats (83,
 * 87), 40 and 1040 (dimensions, stored by rows and by columns). Integers beyond 2^53 become the
 * nearest double. Tag 55799 is skipped; any other tag, byte strings without one, `undefined` and
 * keys that are no text are refused. Numbers in typed arrays cost a copy.
 *
 * Cost: linear in the body, O(m log m) in the members of an object; recursion as deep as the
 * document. Tests: unit.doc_json, unit.doc_cbor, unit.doc_mutation, fault.codec, fuzz.doc_*. */
const doc *doc_from_json(const char *body, size_t size, const doc_limits *limits, doc_arena **arena,
                         doc_error *error);
const doc *doc_from_cbor(const void *body, size_t size, const doc_limits *limits, doc_arena **arena,
                         doc_error *error);

/* doc_from_npy: one array, a file as numpy.save writes it (numpy.lib.format, versions 1 to 3):
 * numbers of 1 to 8 bytes and booleans, either byte order, either memory order, rank 0 (a number)
 * to DOC_RANK_MAX; bytes neither missing nor left over. 64-bit integers beyond 2^53 become the
 * nearest double; objects, text, complex and structured types are refused.
 *
 * doc_from_csv: lines of numbers between commas (RFC 4180 without quotes), all of one length; a
 * first line that is not all numbers is a header and skipped. One column is [rows], more are
 * [rows][columns]. nan, inf and -inf are read. About 30 ns per number.
 *
 * Pointers of their errors are "", or the row of a CSV. Tests: unit.doc_npy, unit.doc_csv,
 * fault.codec, fuzz.doc_npy, fuzz.doc_csv. */
const doc *doc_from_npy(const void *body, size_t size, const doc_limits *limits, doc_arena **arena,
                        doc_error *error);
const doc *doc_from_csv(const char *body, size_t size, const doc_limits *limits, doc_arena **arena,
                        doc_error *error);

/* A body of any of these media types; of another an error that says so. */
const doc *doc_from(media form, const void *body, size_t size, const doc_limits *limits,
                    doc_arena **arena, doc_error *error);

/* Member of an object, NULL if absent or `d` is no object (or NULL). Child k of a list, NULL past
 * its end or if it is no list. Both walk: O(members), O(k). */
const doc *doc_member(const doc *d, const char *key);
const doc *doc_at(const doc *list, int64_t k);

/* "a number", "a string", "an array of 3 numbers", "an array of 5 x 2 numbers", "a list of 2
 * values", "NaN", "null" ...: what stands there, for messages. `room` is where the text may be
 * built. */
const char *doc_describe(const doc *d, char *room, size_t size);

/* Arena: memory that lives as long as the document. NULL when out of memory. */
doc_arena *doc_arena_new(void);
void *doc_arena_take(doc_arena *arena, size_t bytes); /* aligned to 16, not zeroed */
void doc_arena_free(doc_arena **arena);

/* Moves all memory of *from to `into`: it lives as long. *from becomes NULL. */
void doc_arena_adopt(doc_arena *into, doc_arena **from);

#endif
