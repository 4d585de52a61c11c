#include "alloc.h"

#include <inttypes.h>
#include <string.h>

static sct_status bytes_of(int64_t n, size_t size, size_t *bytes, sct_error *err) {
  if (n < 0 || (size != 0 && (uint64_t)n > PTRDIFF_MAX / size)) {
    return sct_fail(err, SCT_E_MEMORY, -1, "array of %" PRId64 " items of %zu bytes is too large",
                    n, size);
  }
  *bytes = n == 0 ? 1 : (size_t)n * size;
  return SCT_OK;
}

static sct_status none_left(size_t bytes, sct_error *err) {
  return sct_fail(err, SCT_E_MEMORY, -1, "no memory for an array of %zu bytes", bytes);
}

sct_status sct_alloc(void *out, int64_t n, size_t size, sct_error *err) {
  size_t bytes = 0;
  void *memory = NULL;
  sct_status status = bytes_of(n, size, &bytes, err);
  if (status == SCT_OK) {
    memory = malloc(bytes);
    if (memory == NULL) status = none_left(bytes, err);
  }
  memcpy(out, &memory, sizeof memory);
  return status;
}

sct_status sct_alloc_zero(void *out, int64_t n, size_t size, sct_error *err) {
  size_t bytes = 0;
  void *memory = NULL;
  sct_status status = bytes_of(n, size, &bytes, err);
  if (status == SCT_OK) {
    memory = calloc(bytes, 1);
    if (memory == NULL) status = none_left(bytes, err);
  }
  memcpy(out, &memory, sizeof memory);
  return status;
}

sct_status sct_realloc(void *inout, int64_t n, size_t size, sct_error *err) {
  size_t bytes = 0;
  sct_status status = bytes_of(n, size, &bytes, err);
  if (status != SCT_OK) return status;
  void *memory;
  memcpy(&memory, inout, sizeof memory);
  memory = realloc(memory, bytes);
  if (memory == NULL) return none_left(bytes, err);
  memcpy(inout, &memory, sizeof memory);
  return SCT_OK;
}

void sct_release(void *inout) {
  void *memory;
  memcpy(&memory, inout, sizeof memory);
  free(memory);
  memory = NULL;
  memcpy(inout, &memory, sizeof memory);
}
