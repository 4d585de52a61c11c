/* submit.h - an execution that becomes a job: checked by a worker, stored, answered 201; with
 * Prefer: wait=N perhaps answered with the results. Test: http.jobs.
 */
#ifndef SCATTERD_SUBMIT_H
#define SCATTERD_SUBMIT_H

#include "exchange.h"
#include "prefer.h"
#include "service.h"

typedef struct submission submission;

/* Begins with the complete request. The reply is set, or is delivered later. NULL when it is set
 * and there is nothing to end. */
submission *submit_new(const service *s, exchange *x, const prefer *p, const ipc_ask *ask);

/* The exchange ends. A job that is accepted already stays. */
void submit_free(submission **b);

#endif
