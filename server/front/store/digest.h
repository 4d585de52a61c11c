/* digest.h - SHA-256 and HMAC-SHA-256: the only door to nettle. Test: unit.digest.
 */
#ifndef SCATTERD_DIGEST_H
#define SCATTERD_DIGEST_H

#include <stdbool.h>
#include <stddef.h>

enum { DIGEST_TEXT = 65 }; /* 64 hexadecimal digits and a NUL */

/* SHA-256 of `label`, its NUL, and the first `size` bytes of descriptor fd (-1: none); `label` NULL
 * is nothing at all. False with errno when fd cannot be read. */
bool digest_file(const char *label, int fd, size_t size, char text[DIGEST_TEXT]);

enum { DIGEST_BYTES = 32 };

/* SHA-256 of bytes in memory. */
void digest_bytes(const void *bytes, size_t size, unsigned char sum[DIGEST_BYTES]);

/* Are two digests the same? Takes the same time wherever they differ. */
bool digest_is(const unsigned char a[DIGEST_BYTES], const unsigned char b[DIGEST_BYTES]);

/* HMAC-SHA-256 (RFC 2104) under a key, of a head and a body one after the other. */
void digest_sign(const char *key, const char *head, const void *body, size_t size,
                 unsigned char sum[DIGEST_BYTES]);

#endif
