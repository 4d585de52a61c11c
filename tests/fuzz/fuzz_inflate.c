/* Any bytes as a packed body (the first names the coding): never more than the limit comes out, and
 * what comes out can be packed and comes back. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fuzz.h"
#include "inflate.h"

enum { LIMIT = 100000 };

static void require(int holds, const char *what) {
  if (holds) return;
  fprintf(stderr, "does not hold: %s\n", what);
  abort();
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  void *text, *packed, *back;
  size_t text_size, packed_size, back_size;
  if (size == 0) return 0;
  coding c = (coding)(data[0] % CODING_COUNT);
  inflate_status status = inflate_bytes(c, data + 1, size - 1, LIMIT, &text, &text_size);
  require((text != NULL) == (status == INFLATE_OK), "bytes come out if and only if all is fine");
  if (text == NULL) return 0;
  require(text_size <= LIMIT, "the limit");
  require(deflate_bytes(c, text, text_size, &packed, &packed_size) == INFLATE_OK, "packing");
  status = inflate_bytes(c, packed, packed_size, text_size, &back, &back_size);
  require(status == INFLATE_OK && back_size == text_size, "unpacking again");
  require(memcmp(text, back, text_size) == 0, "the same again");
  free(text);
  free(packed);
  free(back);
  return 0;
}
