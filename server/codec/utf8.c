#include "utf8.h"

#include <stdbool.h>

/* Lead bytes by ranges, with the range of the second byte (RFC 3629, section 4); further bytes are
 * 80..BF. */
typedef struct {
  unsigned char first, last, low, high;
  size_t bytes;
} utf8_form;

static const utf8_form forms[] = {
    {0x00, 0x7F, 0x00, 0x00, 1}, {0xC2, 0xDF, 0x80, 0xBF, 2}, {0xE0, 0xE0, 0xA0, 0xBF, 3},
    {0xE1, 0xEC, 0x80, 0xBF, 3}, {0xED, 0xED, 0x80, 0x9F, 3}, {0xEE, 0xEF, 0x80, 0xBF, 3},
    {0xF0, 0xF0, 0x90, 0xBF, 4}, {0xF1, 0xF3, 0x80, 0xBF, 4}, {0xF4, 0xF4, 0x80, 0x8F, 4},
};

static bool matches(const utf8_form *form, const unsigned char *p, size_t room) {
  if (p[0] < form->first || p[0] > form->last || form->bytes > room) return false;
  if (form->bytes > 1 && (p[1] < form->low || p[1] > form->high)) return false;
  for (size_t k = 2; k < form->bytes; k++) {
    if ((p[k] & 0xC0) != 0x80) return false;
  }
  return true;
}

size_t utf8_step(const char *p, const char *end) {
  size_t room = (size_t)(end - p);
  for (size_t k = 0; k < sizeof forms / sizeof forms[0]; k++) {
    if (matches(&forms[k], (const unsigned char *)p, room)) return forms[k].bytes;
  }
  return 0;
}

size_t utf8_prefix(const char *text, size_t length) {
  const char *p = text, *end = text + length;
  for (size_t step = 1; p < end && step > 0; p += step) {
    step = (unsigned char)*p < 0x80 ? 1 : utf8_step(p, end);
  }
  return (size_t)(p - text);
}

size_t utf8_put(uint32_t code, char *to) {
  static const unsigned char lead[] = {0, 0x00, 0xC0, 0xE0, 0xF0};
  size_t bytes = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
  for (size_t k = bytes - 1; k > 0; k--, code >>= 6) to[k] = (char)(0x80 | (code & 0x3F));
  to[0] = (char)(lead[bytes] | code);
  return bytes;
}
