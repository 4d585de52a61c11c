/* asset.h - the files of the dashboard, built into the program by embed.py; none in a build without
 * Node. */
#ifndef SCATTERD_ASSET_H
#define SCATTERD_ASSET_H

#include <stddef.h>

typedef struct {
  const char *name; /* "index.html"; others have a hash of their content in it: "index-B3x_9a.js" */
  const char *type;
  const char *etag; /* of the plain bytes, with its quotes */
  const void *bytes;
  size_t size;
  const void *packed; /* the same under gzip */
  size_t packed_size;
} asset;

extern const asset assets[];
extern const size_t asset_count;

#endif
