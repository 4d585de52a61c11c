/* media.h - media types and content codings we speak: one table each; what a client sent, what it
 * takes. Test: unit.media.
 */
#ifndef SCATTERD_MEDIA_H
#define SCATTERD_MEDIA_H

#include <stdbool.h>
#include <stdint.h>

typedef enum {
  MEDIA_JSON,
  MEDIA_CBOR,
  MEDIA_PROBLEM,
  MEDIA_NPY, /* one array, as numpy.save writes it */
  MEDIA_VTP, /* VTK PolyData, XML */
  MEDIA_CSV,
  MEDIA_MULTIPART, /* multipart/related */
  MEDIA_NDJSON,    /* a JSON text a line */
  MEDIA_OCTETS,
  MEDIA_COUNT
} media;
typedef enum { CODING_IDENTITY, CODING_GZIP, CODING_ZSTD, CODING_COUNT } coding;

const char *media_type(media m);               /* "application/json" */
bool media_find(const char *type, media *out); /* by name, parameters and other names allowed */
const char *coding_name(coding c);             /* "gzip"; "identity" */

/* How much a client wants `type` ("text/html"), 0 to 1, by its Accept field; NULL or "" accepts
 * all. The most specific range counts, as RFC 9110 section 12.5.1 says; parameters of ranges other
 * than q are not compared. */
double media_quality(const char *accept, const char *type);

/* The media type of `offers` the client wants most, the earlier one when equal; -1 if it takes
 * none. */
int media_choose(const char *accept, const char *const *offers, int count);

/* How much a client wants each of our types, in thousandths. Not stated (all zero): whoever
 * replies takes the first of what it has. */
typedef struct {
  bool stated;
  uint16_t of[MEDIA_COUNT];
} wishes;

/* The wishes of an Accept field; of an absent or empty one nothing is stated. */
wishes media_wishes(const char *accept);
wishes media_wish(media only);

/* The one of `offers` that is wished most, the earlier one when equal; MEDIA_COUNT if none is. */
media media_pick(const wishes *w, const media *offers, int count);

/* Does the field name this very type, with q > 0? Wildcards do not count. */
bool media_names(const char *accept, const char *type);

/* Type of a body: JSON, CBOR, NPY or CSV. No field means JSON. False for any other type or for a
 * charset that is not UTF-8. */
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
