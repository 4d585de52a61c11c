/* utf8.h - UTF-8 as RFC 3629 defines it: shortest forms only, no surrogates, up to U+10FFFF. */
#ifndef SCATTERD_UTF8_H
#define SCATTERD_UTF8_H

#include <stddef.h>
#include <stdint.h>

/* Bytes of the character at p (1 to 4); 0 if what stands there is not UTF-8. Needs p < end. */
size_t utf8_step(const char *p, const char *end);

/* Bytes at the start of text[length] that are UTF-8; `length` if all are. */
size_t utf8_prefix(const char *text, size_t length);

/* Writes a code point that is no surrogate to to[4]; returns the bytes used. */
size_t utf8_put(uint32_t code, char *to);

#endif
