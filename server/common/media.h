/* media.h - media types and content codings we speak: one table each; what a client sent, what it
 * takes. Test: unit.media.
 */
#ifndef SCATTERD_MEDIA_H
#define SCATTERD_MEDIA_H

#include <stdbool.h>

typedef enum { MEDIA_JSON, MEDIA_CBOR, MEDIA_PROBLEM, MEDIA_COUNT } media;
typedef enum { CODING_IDENTITY, CODING_GZIP, CODING_ZSTD, CODING_COUNT } coding;

const char *media_type(media m);   /* "application/json" */
const char *coding_name(coding c); /* "gzip"; "identity" */

/* How much a client wants `type` ("text/html"), 0 to 1, by its Accept field; NULL or "" accepts
 * all. The most specific range counts, as RFC 9110 section 12.5.1 says; parameters of ranges other
 * than q are not compared. */
double media_quality(const char *accept, const char *type);

/* The media type of `offers` the client wants most, the earlier one when equal; -1 if it takes
 * none. */
int media_choose(const char *accept, const char *const *offers, int count);

/* Does the field name this very type, with q > 0? Wildcards do not count. */
bool media_names(const char *accept, const char *type);

/* Type of a body: JSON or CBOR. No field means JSON. False for any other type or for a charset that
 * is not UTF-8. */
bool media_of_body(const char *content_type, media *out);

/* Coding of a body: identity when there is no field. False for an unknown coding and for several
 * on top of each other. */
bool coding_of_body(const char *content_encoding, coding *out);

/* The coding for a reply. Compression must be asked for by name; zstd comes before gzip when equal.
 * False if the client takes none of ours, not even identity. */
bool coding_choose(const char *accept_encoding, coding *out);

/* Does the client take this coding, asked for by name? For what is stored in that coding only. */
bool coding_accepts(const char *accept_encoding, coding c);

#endif
