/* job_routes.h - the handlers under /jobs/{id}; GET /jobs is job_list.h, events are stream.h.
 * Test: http.jobs.
 */
#ifndef SCATTERD_JOB_ROUTES_H
#define SCATTERD_JOB_ROUTES_H

#include "exchange.h"
#include "service.h"

/* GET /jobs/{id}: at once, or later with Prefer: wait. */
void job_status_serve(const service *s, exchange *x);
void job_status_end(const service *s, exchange *x);

/* GET /jobs/{id}/results and /jobs/{id}/results/{output}. */
void job_results_serve(const service *s, exchange *x);
void job_results_end(const service *s, exchange *x);

/* DELETE /jobs/{id} */
void job_dismiss_serve(const service *s, exchange *x);

/* Finds the job of the route; false when the refusal is set. */
bool job_of_route(const service *s, exchange *x, job_view *view);

#endif
