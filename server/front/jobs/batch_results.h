/* batch_results.h - the results of a batch: one document in the order of its requests once it is
 * over, or a line each (NDJSON) in the order in which they end, as they end.
 *
 * An entry is {"index","jobID","status"} with "results" (a results document), "problem", or, when
 * the results are no JSON, "href". A worker renders one after the other. Test: http.jobs.
 */
#ifndef SCATTERD_BATCH_RESULTS_H
#define SCATTERD_BATCH_RESULTS_H

#include "exchange.h"
#include "service.h"

typedef struct batch_results batch_results;

/* Begins the reply; NULL when a refusal is set. */
batch_results *batch_results_new(const service *s, exchange *x, const job_view *batch);

/* The exchange ends. */
void batch_results_free(batch_results **b);

#endif
