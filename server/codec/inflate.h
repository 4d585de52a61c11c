/* inflate.h - content codings: gzip (RFC 1952) and zstd (RFC 8878), bodies in and replies out.
 *
 * What comes out is bounded, whatever a small body claims or unfolds to: memory grows by doubling
 * with what has really come out, never beyond the limit. Tests: unit.inflate, fault.codec,
 * fuzz.inflate.
 */
#ifndef SCATTERD_INFLATE_H
#define SCATTERD_INFLATE_H

#include <stddef.h>

#include "media.h"

typedef enum {
  INFLATE_OK,
  INFLATE_BAD,       /* not of this coding, damaged, truncated, or something follows */
  INFLATE_TOO_LARGE, /* more than `limit` bytes come out, or a zstd window above 8 MiB (RFC 9659) */
  INFLATE_MEMORY
} inflate_status;

/* "the body unfolds to more than the limit", ...: for messages, never NULL. */
const char *inflate_text(inflate_status status);

/* Undoes a coding. *out is malloc'ed, with *out_size <= limit bytes (several gzip members or zstd
 * frames one after the other are one body); NULL unless INFLATE_OK. Identity copies. */
inflate_status inflate_bytes(coding from, const void *in, size_t size, size_t limit, void **out,
                             size_t *out_size);

/* Applies a coding, at its fastest level: numbers gain nothing from more (1e6 random ones as JSON:
 * gzip 1 makes 2.1 times smaller at 100 MB/s, gzip 6 2.3 times at 15 MB/s). *out is malloc'ed, NULL
 * unless INFLATE_OK; only INFLATE_MEMORY can go wrong. */
inflate_status deflate_bytes(coding to, const void *in, size_t size, void **out, size_t *out_size);

#endif
