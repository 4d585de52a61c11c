/* field.h - header fields that are lists: `a;x=1;q=0.5, b="c", d` (RFC 9110 sections 5.6.1 and
 * 5.6.6). Bad syntax never fails: an item that cannot be read is skipped, as the RFC asks of a
 * recipient. Test: unit.media, unit.prefer.
 */
#ifndef SCATTERD_FIELD_H
#define SCATTERD_FIELD_H

#include <stdbool.h>
#include <stddef.h>

typedef struct {
  const char *at; /* not NUL-terminated */
  size_t length;
} span;

typedef struct {
  span name;       /* before '=' or ';' */
  span value;      /* after '=', without quotes; length 0 if none */
  span parameters; /* from the first ';' on */
} field_item;

/* The next item of a list; *rest starts as the field's text and moves on. False at the end. */
bool field_next(const char **rest, field_item *item);

/* The value of parameter `name` of an item (case does not matter). False if it has none. */
bool field_parameter(const field_item *item, const char *name, span *value);

/* Parameter q: 0 to 1, 1 if there is none, 0 if it is not a number. */
double field_quality(const field_item *item);

/* Is the text of the span `text`, whatever the case? */
bool span_is(span s, const char *text);

#endif
