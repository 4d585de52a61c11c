#include "prefer.h"

#include <stddef.h>

#include "field.h"

/* delta-seconds: digits only; -1 for anything else. */
static double seconds_of(span s) {
  double value = s.length > 0 ? 0 : -1;
  for (size_t k = 0; k < s.length; k++) {
    if (s.at[k] < '0' || s.at[k] > '9') return -1;
    value = 10 * value + (s.at[k] - '0');
  }
  return value;
}

prefer prefer_of(const char *text) {
  prefer p = {.wait = -1};
  field_item item;
  for (const char *rest = text != NULL ? text : ""; field_next(&rest, &item);) {
    if (span_is(item.name, "respond-async")) p.respond_async = true;
    if (span_is(item.name, "wait") && p.wait < 0) p.wait = seconds_of(item.value);
  }
  return p;
}
