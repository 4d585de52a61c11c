/* task.h - one request at work: its limits, its memory, and everything found wrong with it.
 *
 * Two kinds of failure are kept apart. What the client can mend in the body is a complaint: it
 * points to a value, and reading goes on to find the others (HTTP 400). What only turns out while
 * solving is the sct_error of the library call that failed.
 */
#ifndef SCATTERD_TASK_H
#define SCATTERD_TASK_H

#include "doc.h"
#include "limit.h"
#include "problem.h"
#include "scatter/status.h"
#include "stopwatch.h"

typedef struct language language;

struct by_ranks;

typedef struct {
  const limits *limits;
  doc_arena *arena;      /* everything of this request; freed in one go after the reply */
  sct_work work;         /* for library calls: threads, and who is told */
  stopwatch watch;       /* where the time goes */
  language *language;    /* of expressions; NULL until there is one */
  const doc *parameters; /* object of numbers that expressions may name, or NULL */

  struct by_href *by_href; /* inputs by reference; NULL: there can be none */

  const struct cloud_input *cloud; /* whose places t->error speaks of; NULL: none so far */

  /* The state that the run goes on from, NULL: from the start; and who keeps one from time to time,
   * NULL: nobody. */
  const void *checkpoint;
  size_t checkpoint_size;
  bool (*keep_checkpoint)(void *context, const void *bytes, size_t size);

  struct by_ranks *ranks; /* by_ranks.h: that answer together; NULL: this process only */

  int64_t processes; /* that share the run, or will; 0: this one has it */

  int64_t memory_estimate; /* (bytes) of the run, 0 before it is known */

  const char *blame; /* JSON pointer to the input that a failure is the fault of, or NULL */

  problem complaints; /* about the body, with the places of the first PROBLEM_ERRORS_MAX */
  sct_error error;    /* of the library call that failed, points by place */
} task;

/* Memory for n >= 0 items that lives as long as the request; NULL with t->error set
 * (SCT_E_MEMORY) when there is none. task_zeros: filled with zero bytes. */
void *task_take(task *t, int64_t n, size_t size);
void *task_zeros(task *t, int64_t n, size_t size);

/* Nothing found wrong so far. */
bool task_is_well(const task *t);

#endif
