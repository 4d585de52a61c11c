#include "fail_alloc.h"

#include <stddef.h>

static int64_t countdown;
static bool hit;

void fail_alloc_at(int64_t n) {
  countdown = n;
  hit = false;
}

bool fail_alloc_hit(void) {
  return hit;
}

static bool fails(void) {
  if (countdown == 0 || --countdown > 0) return false;
  hit = true;
  return true;
}

void *__real_malloc(size_t bytes);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *memory, size_t bytes);
void *__wrap_malloc(size_t bytes);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *memory, size_t bytes);

void *__wrap_malloc(size_t bytes) {
  return fails() ? NULL : __real_malloc(bytes);
}

void *__wrap_calloc(size_t count, size_t size) {
  return fails() ? NULL : __real_calloc(count, size);
}

void *__wrap_realloc(void *memory, size_t bytes) {
  return fails() ? NULL : __real_realloc(memory, bytes);
}
