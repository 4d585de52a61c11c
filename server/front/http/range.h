/* range.h - parts of a reply: the fields Range and If-Range (RFC 9110, section 14), one range of
 * bytes at a time. Test: unit.range, http.data.
 */
#ifndef SCATTERD_RANGE_H
#define SCATTERD_RANGE_H

#include <stddef.h>

#include "exchange.h"

typedef enum {
  RANGE_WHOLE, /* no range, several, another unit, bad syntax: all of it is sent */
  RANGE_PART,
  RANGE_OUTSIDE /* 416 */
} range_kind;

/* Reads a Range field (NULL: absent) for `size` bytes: *first and *length of a part. */
range_kind range_of(const char *field, size_t size, size_t *first, size_t *length);

/* Makes a reply of status 200 from a descriptor a part of it, or 416, as the request asks; `tag` is
 * its ETag, NULL if it has none. Only where the reply has no content coding. */
void range_apply(exchange *x, const char *tag);

#endif
