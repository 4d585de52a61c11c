#include "prefer.h"

#include <math.h>
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

static int priority_of(span s) {
  return s.length == 1 && s.at[0] >= '0' && s.at[0] <= '9' ? s.at[0] - '0' : -1;
}

static prefer_shape shape_of(span s) {
  if (span_is(s, "minimal")) return PREFER_MINIMAL;
  return span_is(s, "representation") ? PREFER_REPRESENTATION : PREFER_ANY;
}

prefer prefer_of(const char *text, double most) {
  prefer p = {.wait = -1, .priority = -1};
  field_item item;
  for (const char *rest = text != NULL ? text : ""; field_next(&rest, &item);) {
    if (span_is(item.name, "respond-async")) p.respond_async = true;
    if (span_is(item.name, "wait") && p.wait < 0) p.wait = seconds_of(item.value);
    if (span_is(item.name, "return") && p.shape == PREFER_ANY) p.shape = shape_of(item.value);
    if (span_is(item.name, "priority") && p.priority < 0) p.priority = priority_of(item.value);
  }
  p.wait = fmin(p.wait, most);
  return p;
}
