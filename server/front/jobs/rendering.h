/* rendering.h - a stored result as the client wants it: a worker makes it. Test: http.jobs.
 */
#ifndef SCATTERD_RENDERING_H
#define SCATTERD_RENDERING_H

#include "exchange.h"
#include "service.h"

typedef struct rendering rendering;

/* Starts the reply to GET .../results[/{output}] of a successful job, by the fields of the request;
 * `output` "" is the whole document. It is delivered later; NULL when a refusal is set already. */
rendering *rendering_new(const service *s, exchange *x, const job_row *row, const char *output);

/* The exchange ends. */
void rendering_free(rendering **r);

#endif
