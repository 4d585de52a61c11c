/* seam.h - is what we are told of a request's header all that came?
 *
 * libmicrohttpd before 1.0 leaves name and value of a field where they arrived, one behind the
 * other, and makes three things of a header that others on the way read differently: a line that
 * continues a field (obs-fold) becomes part of that field's name; a line without a name ends the
 * header; a NUL ends a value. By each a length can be hidden, and the body of one request become
 * the next one. All of them leave a gap between what we are told, and that is looked for.
 * Tests: unit.seam, http.hostile.
 */
#ifndef SCATTERD_SEAM_H
#define SCATTERD_SEAM_H

#include <stdbool.h>

typedef struct {
  bool is_strict;  /* look for gaps; else for names that are none only */
  bool is_broken;  /* something was found */
  const char *end; /* of the last field, NULL before the first */
} seam;

/* One field after the other, as they came. A name is a token (RFC 9110, 5.1): no blank before the
 * colon. */
void seam_field(seam *s, const char *name, const char *value);

/* All fields were told; `end` is where the header ends, behind its empty line. */
void seam_end(seam *s, const char *end);

#endif
