#include "fail_alloc.h"

#include <stdbool.h>
#include <stddef.h>

static int64_t failing = -1, count;

void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void *__real_realloc(void *memory, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t n, size_t size);
void *__wrap_realloc(void *memory, size_t size);

void fail_alloc_at(int64_t n) {
  failing = n;
  count = 0;
}

int64_t fail_alloc_count(void) {
  return count;
}

static bool fails(void) {
  return count++ == failing;
}

void *__wrap_malloc(size_t size) {
  return fails() ? NULL : __real_malloc(size);
}

void *__wrap_calloc(size_t n, size_t size) {
  return fails() ? NULL : __real_calloc(n, size);
}

void *__wrap_realloc(void *memory, size_t size) {
  return fails() ? NULL : __real_realloc(memory, size);
}
