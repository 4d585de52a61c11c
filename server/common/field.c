#include "field.h"

#include <string.h>
#include <strings.h>

bool span_is(span s, const char *text) {
  return strlen(text) == s.length && strncasecmp(s.at, text, s.length) == 0;
}

static bool is_space(char c) {
  return c == ' ' || c == '\t';
}

static span trimmed(const char *from, const char *to) {
  while (from < to && is_space(*from)) from++;
  while (to > from && is_space(to[-1])) to--;
  return (span){from, (size_t)(to - from)};
}

/* First of `stops` or the end (`end`), outside quoted strings. */
static const char *find(const char *at, const char *end, const char *stops) {
  bool quoted = false;
  for (; at < end; at++) {
    if (quoted && *at == '\\' && at + 1 < end) {
      at++;
    } else if (*at == '"') {
      quoted = !quoted;
    } else if (!quoted && strchr(stops, *at) != NULL) {
      break;
    }
  }
  return at;
}

static span unquoted(span s) {
  if (s.length >= 2 && s.at[0] == '"' && s.at[s.length - 1] == '"') {
    return (span){s.at + 1, s.length - 2};
  }
  return s;
}

/* Splits `name = value` within [at, end). */
static void split(const char *at, const char *end, span *name, span *value) {
  const char *equals = find(at, end, "=");
  *name = trimmed(at, equals);
  *value = equals < end ? unquoted(trimmed(equals + 1, end)) : (span){end, 0};
}

bool field_next(const char **rest, field_item *item) {
  while (**rest != '\0') {
    const char *at = *rest, *all = at + strlen(at);
    const char *end = find(at, all, ",");
    *rest = end < all ? end + 1 : end;
    const char *semicolon = find(at, end, ";");
    split(at, semicolon, &item->name, &item->value);
    item->parameters = (span){semicolon, (size_t)(end - semicolon)};
    if (item->name.length > 0) return true;
  }
  return false;
}

bool field_parameter(const field_item *item, const char *name, span *value) {
  const char *at = item->parameters.at, *end = at + item->parameters.length;
  while (at < end) {
    const char *next = find(at + 1, end, ";");
    span key;
    split(at + 1, next, &key, value);
    if (span_is(key, name)) return true;
    at = next;
  }
  return false;
}

/* qvalue of RFC 9110: 0, 1, 0.123; digits only, so that no locale plays a part. */
double field_quality(const field_item *item) {
  span q;
  if (!field_parameter(item, "q", &q)) return 1;
  double value = 0, unit = 1;
  bool point = false;
  for (size_t k = 0; k < q.length; k++) {
    if (q.at[k] == '.' && !point) {
      point = true;
    } else if (q.at[k] >= '0' && q.at[k] <= '9') {
      if (point) unit /= 10;
      value = point ? value + unit * (q.at[k] - '0') : 10 * value + (q.at[k] - '0');
    } else {
      return 0;
    }
  }
  return value <= 1 ? value : 1;
}
