/* scan_json.h - the strict pass over a JSON text: RFC 8259 and the limits are checked here, and
 * the numbers are taken out.
 *
 * What is left is a reduced text without white space, usually short: a number standing alone is 0
 * there, an array of numbers the string "\xFF", and the character NUL within a string the byte
 * 0xFE. Neither byte occurs in UTF-8, so nothing a client sends can be mistaken for them.
 */
#ifndef SCATTERD_SCAN_JSON_H
#define SCATTERD_SCAN_JSON_H

#include "doc.h"
#include "grow.h"

enum { SCAN_ARRAY = 0xFF, SCAN_NUL = 0xFE };

typedef struct {
  int rank;
  int64_t shape[DOC_RANK_MAX];
} scan_shape;

typedef struct {
  grow_bytes text;    /* reduced, not NUL-terminated */
  scan_shape *shapes; /* of its arrays of numbers, in order */
  size_t shape_count, shape_capacity;
  double *values; /* all numbers, in order */
} scan_result;

/* False with `error` filled. Keys with escapes are kept in `arena` until the end. Free the result
 * in either case. */
bool scan_json(const char *body, size_t size, const doc_limits *limits, doc_arena *arena,
               scan_result *result, doc_error *error);
void scan_result_free(scan_result *result);

#endif
