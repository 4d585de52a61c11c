/* prefer.h - the Prefer field (RFC 7240): what a client would like but does not insist on.
 * Test: unit.prefer.
 */
#ifndef SCATTERD_PREFER_H
#define SCATTERD_PREFER_H

#include <stdbool.h>

typedef enum { PREFER_ANY, PREFER_MINIMAL, PREFER_REPRESENTATION } prefer_shape;

typedef struct {
  bool respond_async;
  double wait;        /* seconds; -1 if not given */
  prefer_shape shape; /* return=minimal, return=representation */
  int priority;       /* priority=0 to 9, of our own making; -1 if not given */
} prefer;

/* Reads the field (NULL: absent). Unknown preferences and parameters are skipped, of a preference
 * given twice the first counts, a value that makes no sense is ignored, a wait above `most` seconds
 * is that, so that Preference-Applied tells what is done. */
prefer prefer_of(const char *text, double most);

#endif
