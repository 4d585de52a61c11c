/* Launchers tell a process its place by variables of its environment. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scatter/ranks.h"

extern char **environ;

static const char *const places[][2] = {
    {"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE"},
    {"PMI_RANK", "PMI_SIZE"},
    {"SLURM_PROCID", "SLURM_STEP_NUM_TASKS"},
};

bool sct_ranks_place(int *rank, int *count) {
  for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
    const char *at = getenv(places[k][0]), *of = getenv(places[k][1]);
    if (at == NULL || of == NULL) continue;
    *rank = (int)strtol(at, NULL, 10);
    *count = (int)strtol(of, NULL, 10);
    if (*count > 0 && *rank >= 0 && *rank < *count) return true;
  }
  *rank = 0;
  *count = 1;
  return false;
}

/* MPI would find its launcher by any of these. */
void sct_ranks_alone(void) {
  static const char *const prefixes[] = {"OMPI_", "PMIX_", "PMI_", "ORTE_", "SLURM_"};
  char name[128];
  for (char **at = environ; at != NULL && *at != NULL;) {
    bool is_launcher = false;
    for (size_t k = 0; k < sizeof prefixes / sizeof *prefixes; k++) {
      is_launcher = is_launcher || strncmp(*at, prefixes[k], strlen(prefixes[k])) == 0;
    }
    const size_t length = strcspn(*at, "=");
    if (!is_launcher || length >= sizeof name) {
      at++;
      continue;
    }
    snprintf(name, sizeof name, "%.*s", (int)length, *at);
    unsetenv(name);
    at = environ; /* it has moved */
  }
}
