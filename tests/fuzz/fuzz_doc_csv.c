/* Any bytes as a CSV body: rows of one length, or refused, never worse. */
#include <stdlib.h>

#include "doc.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const doc_limits limits = {.depth = 20, .nodes = 5000, .numbers = 20000};
  doc_arena *arena;
  doc_error error;
  const doc *d = doc_from_csv((const char *)data, size, &limits, &arena, &error);
  if (d == NULL && error.text[0] == '\0') abort();
  if (d != NULL && d->count != (d->rank == 2 ? d->shape[0] * d->shape[1] : d->shape[0])) abort();
  doc_arena_free(&arena);
  return 0;
}
