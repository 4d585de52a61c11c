/* by_ranks.h - one request answered by several processes that a launcher started together.
 *
 * All of them ("ranks") read the same request and come to the same decisions without a word. What
 * can be shared they do together; the rest rank 0 does alone, with the reason in its report, while
 * the others leave. Rank 0 replies. Proof: http.executor_mpi
 */
#ifndef SCATTERD_BY_RANKS_H
#define SCATTERD_BY_RANKS_H

#include "answer.h"
#include "emit.h"
#include "perform.h"
#include "scatter/ranks.h"

struct by_ranks {
  int rank, count;         /* place among those that were started */
  sct_ranks *group;        /* NULL: not together */
  bool leaves;             /* this process is not needed any more, and makes no reply */
  bool disbanded;          /* nobody waits for anybody any more, but to end */
  char alone[256];         /* why one process did it; "": it was shared, or it was not said yet */
  sct_ranks_report report; /* of what was shared */
};

/* Joins the others for a request that was read, or leaves it to rank 0. False if this process is
 * not needed any more. Nothing for a task without ranks. */
bool by_ranks_begin(task *t, const performance *f);

/* Leaves the rest to rank 0; `reason` NULL: all is well. False if this process is not rank 0. */
bool by_ranks_disband(task *t, const char *reason);

/* The member `ranks` of the report; nothing for a task without ranks. */
void by_ranks_write(emit *e, const task *t);

#endif
