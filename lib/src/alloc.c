#include "alloc.h"

#include <inttypes.h>
#include <string.h>
#include <sys/mman.h>

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

/* Large arrays are filled from end to end soon after: with small pages a fifth to a third of that
 * time is the kernel's, so huge ones are asked for. A hint, never an error. All of the mapping gets
 * it: a mapping in two parts could not be grown in place. */
static void prefer_huge_pages(void *memory, size_t bytes) {
#ifdef MADV_HUGEPAGE
  enum { LARGE = 4 << 20, PAGE = 4096 };
  if (memory == NULL || bytes < LARGE) return;
  const size_t before = (uintptr_t)memory % PAGE; /* of the page it begins in */
  const size_t pages = (before + bytes + PAGE - 1) / PAGE;
  (void)madvise((char *)memory - before, pages * PAGE, MADV_HUGEPAGE);
#else
  (void)memory;
  (void)bytes;
#endif
}

static sct_status take(void *out, int64_t n, size_t size, bool zeroed, sct_error *err) {
  size_t bytes = 0;
  void *memory = NULL;
  sct_status status = bytes_of(n, size, &bytes, err);
  if (status == SCT_OK) {
    memory = zeroed ? calloc(bytes, 1) : malloc(bytes);
    prefer_huge_pages(memory, bytes);
    if (memory == NULL) status = none_left(bytes, err);
  }
  memcpy(out, &memory, sizeof memory);
  return status;
}

sct_status sct_alloc(void *out, int64_t n, size_t size, sct_error *err) {
  return take(out, n, size, false, err);
}

sct_status sct_alloc_zero(void *out, int64_t n, size_t size, sct_error *err) {
  return take(out, n, size, true, err);
}

sct_status sct_realloc(void *inout, int64_t n, size_t size, sct_error *err) {
  size_t bytes = 0;
  sct_status status = bytes_of(n, size, &bytes, err);
  if (status != SCT_OK) return status;
  void *memory;
  memcpy(&memory, inout, sizeof memory);
  memory = realloc(memory, bytes);
  if (memory == NULL) return none_left(bytes, err);
  prefer_huge_pages(memory, bytes);
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
