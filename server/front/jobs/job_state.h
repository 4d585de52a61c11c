/* job_state.h - the states of a job and what may lead from one to another: one table.
 * Test: unit.job_state.
 */
#ifndef SCATTERD_JOB_STATE_H
#define SCATTERD_JOB_STATE_H

#include <stdbool.h>

/* In the order of the standard's statusCode. The numbers are stored: append only. */
typedef enum {
  JOB_ACCEPTED,
  JOB_RUNNING,
  JOB_SUCCESSFUL,
  JOB_FAILED,
  JOB_DISMISSED,
  JOB_STATES
} job_state;

/* "accepted", ... as in statusInfo. */
const char *job_state_name(job_state state);

/* The state of that name; -1 if there is none. */
int job_state_of(const char *name, int length);

/* May a job go from one state to the other? Running goes back to accepted when the daemon starts
 * again or stops in the middle; an accepted one is successful at once when its answer is at hand.
 */
bool job_state_may(job_state from, job_state to);

/* Is it the last one, apart from dismissal? */
bool job_state_is_final(job_state state);

#endif
