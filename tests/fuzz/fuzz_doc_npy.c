/* Any bytes as an .npy body: one array, or refused, never worse. */
#include <stdlib.h>

#include "doc.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const doc_limits limits = {.depth = 20, .nodes = 5000, .numbers = 20000};
  doc_arena *arena;
  doc_error error;
  volatile double sum = 0; /* reads all numbers */
  const doc *d = doc_from_npy(data, size, &limits, &arena, &error);
  if (d == NULL && error.text[0] == '\0') abort();
  if (d != NULL && d->count > limits.numbers) abort();
  for (int64_t k = 0; d != NULL && k < d->count; k++) sum = sum + d->data[k];
  doc_arena_free(&arena);
  return 0;
}
