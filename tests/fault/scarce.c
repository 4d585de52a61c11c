#include "scarce.h"

#include <errno.h>
#include <stddef.h>

static bool is_scarce, has_failed, is_lasting;
static int64_t left, asked;

void scarce_after(int64_t granted, bool lasting) {
  is_scarce = true;
  has_failed = false;
  is_lasting = lasting;
  left = granted;
  asked = 0;
}

int64_t scarce_count(void) {
  return asked;
}

bool scarce_end(void) {
  is_scarce = false;
  return has_failed;
}

/* Is this allocation to fail? */
static bool runs_out(void) {
  asked++;
  if (!is_scarce || (has_failed && !is_lasting) || left-- > 0) return false;
  has_failed = true;
  errno = ENOMEM;
  return true;
}

void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
int __real_posix_memalign(void **memory, size_t alignment, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t n, size_t size);
void *__wrap_realloc(void *memory, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
int __wrap_posix_memalign(void **memory, size_t alignment, size_t size);

void *__wrap_malloc(size_t size) {
  return runs_out() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t n, size_t size) {
  return runs_out() ? NULL : __real_calloc(n, size);
}

void *__wrap_realloc(void *memory, size_t size) {
  return runs_out() ? NULL : __real_realloc(memory, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size) {
  return runs_out() ? NULL : __real_aligned_alloc(alignment, size);
}

int __wrap_posix_memalign(void **memory, size_t alignment, size_t size) {
  return runs_out() ? ENOMEM : __real_posix_memalign(memory, alignment, size);
}
