#include "process.h"

#include <string.h>

static const process *const table[] = {&process_solve, &process_apply, &process_diagnose,
                                       &process_study, &process_flow,  &process_echo,
                                       &process_batch};

const process *process_at(int k) {
  return k >= 0 && k < (int)(sizeof table / sizeof *table) ? table[k] : NULL;
}

const process *process_find(const char *id) {
  for (int k = 0; process_at(k); k++) {
    if (!strcmp(process_at(k)->id, id)) return process_at(k);
  }
  return NULL;
}
