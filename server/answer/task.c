#include "task.h"

#include <string.h>

static void *out_of_memory(task *t) {
  if (!t->error.code)
    (void)sct_fail(&t->error, SCT_E_MEMORY, -1, "no room for the data of the request");
  return NULL;
}

void *task_take(task *t, int64_t n, size_t size) {
  size_t bytes;
  if (n < 0 || __builtin_mul_overflow((size_t)n, size, &bytes)) return out_of_memory(t);
  void *memory = doc_arena_take(t->arena, bytes ? bytes : 1);
  return memory ? memory : out_of_memory(t);
}

void *task_zeros(task *t, int64_t n, size_t size) {
  void *memory = task_take(t, n, size);
  if (memory) memset(memory, 0, (size_t)n * size);
  return memory;
}

bool task_is_well(const task *t) {
  return t->complaints.found == 0 && t->error.code == SCT_OK;
}
