#include "job_state.h"

#include <string.h>

#define TO(state) (1u << JOB_##state)

static const struct {
  const char *name;
  unsigned next; /* set of states */
} states[JOB_STATES] = {
    [JOB_ACCEPTED] = {"accepted", TO(RUNNING) | TO(SUCCESSFUL) | TO(FAILED) | TO(DISMISSED)},
    [JOB_RUNNING] = {"running", TO(ACCEPTED) | TO(SUCCESSFUL) | TO(FAILED) | TO(DISMISSED)},
    [JOB_SUCCESSFUL] = {"successful", TO(DISMISSED)},
    [JOB_FAILED] = {"failed", TO(DISMISSED)},
    [JOB_DISMISSED] = {"dismissed", 0},
};

const char *job_state_name(job_state state) {
  return states[state].name;
}

int job_state_of(const char *name, int length) {
  for (int k = 0; k < JOB_STATES; k++) {
    const bool same = strncmp(states[k].name, name, (size_t)length) == 0;
    if (same && strlen(states[k].name) == (size_t)length) return k;
  }
  return -1;
}

bool job_state_may(job_state from, job_state to) {
  return (states[from].next >> to & 1u) != 0;
}

bool job_state_is_final(job_state state) {
  return (states[state].next & ~TO(DISMISSED)) == 0;
}
