/* Any bytes as a stored result: rendered in each form or refused, never worse. */
#include <stdlib.h>

#include "answer.h"
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static const limits most = {.decoded_bytes = 1 << 20, .depth = 32, .nodes = 10000};
  static const char *const outputs[] = {"", "value", "neighbours"};
  for (int k = 0; k < 3 * MEDIA_COUNT; k++) {
    reply r;
    const ask question = {.work = IPC_RENDER,
                          .output = outputs[k % 3],
                          .results_url = "http://here",
                          .body = data,
                          .size = size,
                          .accept = media_wish((media)(k / 3)),
                          .limits = &most};
    answer(&question, &r);
    if (r.bytes == NULL) abort();
    free(r.bytes);
  }
  return 0;
}
