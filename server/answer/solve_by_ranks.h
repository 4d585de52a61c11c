/* solve_by_ranks.h - process `solve` in parallel: a steady equation, every scheme and boundary,
 * with upwinding but `limited`, by iteration. Proof: http.executor_mpi
 */
#ifndef SCATTERD_SOLVE_BY_RANKS_H
#define SCATTERD_SOLVE_BY_RANKS_H

#include "process_solve.h"

/* Why what was read is for one process, or NULL. `alone` of a process. */
const char *solve_alone(const task *t, const void *state);

/* Solves s->in with all ranks of t->ranks into s->phi, which has the given values: true if this
 * process is rank 0 and it is done; else t->error, ranks->leaves or neither of them says what: then
 * the solution was not found together, and rank 0 is to find it alone. */
bool solve_by_ranks(task *t, solve *s);

#endif
