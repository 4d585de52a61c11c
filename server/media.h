/* media.h - media types and content codings we speak: one table each. */
#ifndef SCATTERD_MEDIA_H
#define SCATTERD_MEDIA_H

typedef enum { MEDIA_JSON, MEDIA_CBOR, MEDIA_PROBLEM, MEDIA_COUNT } media;
typedef enum { CODING_IDENTITY, CODING_GZIP, CODING_ZSTD, CODING_COUNT } coding;

const char *media_type(media m);   /* "application/json" */
const char *coding_name(coding c); /* "gzip"; "identity" */

#endif
