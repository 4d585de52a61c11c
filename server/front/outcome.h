/* outcome.h - the reply to a request that a worker had: the worker's own, or what became of it.
 * Test: http.faults.
 */
#ifndef SCATTERD_OUTCOME_H
#define SCATTERD_OUTCOME_H

#include "exchange.h"
#include "pool.h"

/* Sets the reply; the descriptor of the outcome is taken. */
void outcome_reply(exchange *x, const limits *most, const pool_outcome *o);

/* No worker took it: 503. */
void outcome_refuse_full(exchange *x, const pool *p, int64_t queue);

#endif
