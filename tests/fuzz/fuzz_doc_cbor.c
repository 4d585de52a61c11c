/* Any bytes as a CBOR body: taken or refused, never worse; what is taken goes out and comes back.
 */
#include <stdio.h>
#include <stdlib.h>

#include "doc_back.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const doc_limits limits = {.depth = 20, .nodes = 5000, .numbers = 20000};
  doc_arena *arena;
  doc_error error;
  const doc *d = doc_from_cbor(data, size, &limits, &arena, &error);
  for (int format = EMIT_JSON; d != NULL && format <= EMIT_CBOR; format++) {
    char *wrong = doc_back(d, (emit_format)format);
    if (wrong != NULL) {
      fprintf(stderr, "%s\n", wrong);
      abort();
    }
  }
  doc_arena_free(&arena);
  return 0;
}
