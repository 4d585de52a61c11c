/* progress.h - how far a request is, from what the phases of its calls say of themselves.
 *
 * A phase knows the fraction of itself only, and each begins at 0. Here they get their places in a
 * whole, by what they cost in a solve of some size; what is told grows from 0 to 1 and never goes
 * back. A phase that is not in the table speaks for the whole (study's rows, a pause). Test:
 * unit.progress.
 */
#ifndef SCATTERD_PROGRESS_H
#define SCATTERD_PROGRESS_H

#include "answer.h"

typedef struct {
  const ask_calls *calls; /* who is told */
  double told;            /* the largest fraction so far */
} progress;

/* As the callbacks of an sct_work whose context is a progress. */
bool progress_report(void *context, const char *phase, double fraction);
void progress_residual(void *context, double value);

#endif
