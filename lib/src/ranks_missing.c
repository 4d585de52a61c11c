/* In the place of ranks.c where PETSc was not there when the library was built. */
#include "scatter/ranks.h"

static sct_status missing(sct_error *err) {
  return sct_fail(err, SCT_E_ARGUMENT, -1,
                  "parallel runs need PETSc and MPI, which this library was built without "
                  "(Debian: petsc-dev)");
}

sct_status sct_ranks_open(sct_ranks **ranks, sct_error *err) {
  *ranks = NULL;
  return missing(err);
}

void sct_ranks_close(sct_ranks **ranks) {
  *ranks = NULL;
}

int sct_ranks_rank(const sct_ranks *ranks) {
  (void)ranks;
  return 0;
}

int sct_ranks_count(const sct_ranks *ranks) {
  (void)ranks;
  return 1;
}

sct_status sct_ranks_solve(sct_ranks *ranks, const sct_part_problem *problem,
                           const sct_solve_options *options, const sct_work *work, double *phi,
                           sct_solve_report *solve, sct_ranks_report *report, sct_error *err) {
  (void)ranks, (void)problem, (void)options, (void)work, (void)phi, (void)solve, (void)report;
  return missing(err);
}
