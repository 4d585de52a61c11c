#include "page.h"

#include <string.h>

#include "asset.h"
#include "http.h"

static const char index_name[] = "index.html";

/* Nothing inline, nothing evaluated, nobody else's: what an attacker could bring onto the page
 * neither runs nor phones home. Pictures may be made by the page itself (blob:, data:). */
static const char policy[] =
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; "
    "img-src 'self' blob: data:; worker-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'self'";

static const asset *find(const char *name) {
  for (size_t k = 0; k < asset_count; k++) {
    if (strcmp(assets[k].name, name) == 0) return &assets[k];
  }
  return NULL;
}

bool page_exists(void) {
  return find(index_name) != NULL;
}

/* Does If-None-Match name this entity tag? Weak comparison, RFC 9110, 13.1.2. */
static bool is_known(const exchange *x, const char *etag) {
  char room[512];
  const char *known = http_field(x, "If-None-Match", room, sizeof room);
  return known != NULL && (strcmp(known, "*") == 0 || strstr(known, etag) != NULL);
}

static void serve(exchange *x, const asset *a) {
  char room[512];
  const bool packed =
      coding_accepts(http_field(x, "Accept-Encoding", room, sizeof room), CODING_GZIP);
  exchange_add(x, "ETag", "%s", a->etag);
  exchange_add(x, "Vary", "Accept, Accept-Encoding");
  exchange_add(x, "X-Content-Type-Options", "nosniff");
  if (is_known(x, a->etag)) {
    exchange_unchanged(x, packed ? a->packed_size : a->size);
  } else if (packed) {
    exchange_constant(x, 200, a->type, CODING_GZIP, a->packed, a->packed_size);
  } else {
    exchange_constant(x, 200, a->type, CODING_IDENTITY, a->bytes, a->size);
  }
}

void page_serve(exchange *x) {
  exchange_add(x, "Cache-Control", "no-cache");
  exchange_add(x, "Content-Security-Policy", "%s", policy);
  exchange_add(x, "Referrer-Policy", "no-referrer");
  serve(x, find(index_name));
}

void page_serve_asset(exchange *x, const char *name) {
  const asset *a = find(name);
  if (a == NULL || strcmp(name, index_name) == 0) {
    exchange_refuse(x, 404, "the dashboard has no file %.100s", name);
    return;
  }
  exchange_add(x, "Cache-Control", "public, max-age=31536000, immutable");
  serve(x, a);
}
