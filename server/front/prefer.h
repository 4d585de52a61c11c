/* prefer.h - the Prefer field (RFC 7240): what a client would like but does not insist on.
 * Test: unit.prefer.
 */
#ifndef SCATTERD_PREFER_H
#define SCATTERD_PREFER_H

#include <stdbool.h>

typedef struct {
  bool respond_async;
  double wait; /* seconds; -1 if not given */
} prefer;

/* Reads the field (NULL: absent). Unknown preferences and parameters are skipped, of a preference
 * given twice the first counts, a wait that is not a number is ignored. */
prefer prefer_of(const char *text);

#endif
