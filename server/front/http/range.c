#include "range.h"

#include <stdint.h>
#include <string.h>
#include <strings.h>

#include "http.h"

/* Digits; SIZE_MAX for more than fit; false for none. */
static bool read_number(const char **at, size_t *value) {
  const char *first = *at;
  *value = 0;
  for (; **at >= '0' && **at <= '9'; ++*at) {
    const size_t digit = (size_t)(**at - '0');
    *value = *value > (SIZE_MAX - digit) / 10 ? SIZE_MAX : 10 * *value + digit;
  }
  return *at > first;
}

/* "-500": the last 500 bytes. */
static range_kind suffix(const char *at, size_t size, size_t *first, size_t *length) {
  size_t wanted;
  at++;
  if (!read_number(&at, &wanted) || *at != '\0') return RANGE_WHOLE;
  if (wanted == 0 || size == 0) return RANGE_OUTSIDE;
  *length = wanted < size ? wanted : size;
  *first = size - *length;
  return RANGE_PART;
}

range_kind range_of(const char *field, size_t size, size_t *first, size_t *length) {
  size_t last = SIZE_MAX;
  if (field == NULL || strncasecmp(field, "bytes=", 6) != 0) return RANGE_WHOLE;
  const char *at = field + 6;
  if (*at == '-') return suffix(at, size, first, length);
  if (!read_number(&at, first) || *at++ != '-') return RANGE_WHOLE;
  if (*at != '\0' && (!read_number(&at, &last) || *at != '\0' || last < *first)) return RANGE_WHOLE;
  if (*first >= size) return RANGE_OUTSIDE;
  if (last >= size) last = size - 1;
  *length = last - *first + 1;
  return RANGE_PART;
}

/* If-Range: the part is wanted only of what the client knows. Times are not told, so none fits. */
static bool is_known(const exchange *x, const char *tag) {
  char room[256];
  const char *wanted = http_field(x, "If-Range", room, sizeof room);
  return wanted == NULL || (tag != NULL && strcmp(wanted, tag) == 0);
}

void range_apply(exchange *x, const char *tag) {
  char room[256];
  size_t first = 0, length = 0;
  const size_t size = x->reply.size;
  if (x->reply.status != 200 || x->reply.coding != CODING_IDENTITY) return;
  exchange_add(x, "Accept-Ranges", "bytes");
  const char *field =
      strcmp(x->method, "GET") == 0 ? http_field(x, "Range", room, sizeof room) : NULL;
  if (field == NULL || !is_known(x, tag)) return;
  const range_kind kind = range_of(field, size, &first, &length);
  if (kind == RANGE_OUTSIDE) {
    exchange_refuse(x, 416, "Range: got \"%.100s\", there are %zu bytes", field, size);
    exchange_add(x, "Content-Range", "bytes */%zu", size);
  } else if (kind == RANGE_PART) {
    exchange_add(x, "Content-Range", "bytes %zu-%zu/%zu", first, first + length - 1, size);
    x->reply.status = 206;
    x->reply.offset = first;
    x->reply.size = length;
  }
}
