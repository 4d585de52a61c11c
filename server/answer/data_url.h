/* data_url.h - data: URLs (RFC 2397). Proof: unit.by_href */
#ifndef SCATTERD_DATA_URL_H
#define SCATTERD_DATA_URL_H

#include <stdbool.h>
#include <stddef.h>

#include "media.h"

/* data:[<media type>][;base64],<bytes, percent-encoded or base64>. *bytes is malloc'ed. No media
 * type, or text/plain, is JSON. False with a reason in `why` (a literal), NULL when out of memory.
 */
bool data_url_is(const char *url);
bool data_url_read(const char *url, media *form, unsigned char **bytes, size_t *size,
                   const char **why);

#endif
