#include <stdio.h>

#include "doc.h"

static const doc *from_json(const void *body, size_t size, const doc_limits *limits,
                            doc_arena **arena, doc_error *error) {
  return doc_from_json(body, size, limits, arena, error);
}

static const doc *from_csv(const void *body, size_t size, const doc_limits *limits,
                           doc_arena **arena, doc_error *error) {
  return doc_from_csv(body, size, limits, arena, error);
}

typedef const doc *decoder(const void *body, size_t size, const doc_limits *limits,
                           doc_arena **arena, doc_error *error);

static decoder *const decoders[MEDIA_COUNT] = {[MEDIA_JSON] = from_json,
                                               [MEDIA_CBOR] = doc_from_cbor,
                                               [MEDIA_NPY] = doc_from_npy,
                                               [MEDIA_CSV] = from_csv};

const doc *doc_from(media form, const void *body, size_t size, const doc_limits *limits,
                    doc_arena **arena, doc_error *error) {
  if (form < MEDIA_COUNT && decoders[form] != NULL) {
    return decoders[form](body, size, limits, arena, error);
  }
  *arena = NULL;
  *error = (doc_error){0};
  snprintf(error->text, sizeof error->text, "cannot be read here, needs %s, %s, %s or %s",
           media_type(MEDIA_JSON), media_type(MEDIA_CBOR), media_type(MEDIA_NPY),
           media_type(MEDIA_CSV));
  return NULL;
}
