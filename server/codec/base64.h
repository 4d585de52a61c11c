/* base64.h - bytes as text (RFC 4648, section 4). Test: unit.base64 */
#ifndef SCATTERD_BASE64_H
#define SCATTERD_BASE64_H

#include <stdbool.h>
#include <stddef.h>

/* malloc'ed with a NUL behind *length characters; NULL when out of memory. */
char *base64_encode(const void *bytes, size_t size, size_t *length);

/* malloc'ed (never NULL but out of memory); padding may be left out, white space may stand
 * anywhere, the letters of the URL alphabet ('-', '_') count as '+', '/'. *size is -1 if anything
 * else is in it. */
unsigned char *base64_decode(const char *text, size_t length, long long *size);

#endif
