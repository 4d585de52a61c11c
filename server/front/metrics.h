/* metrics.h - GET /metrics and GET /readyz: the state of the service, for those who watch it.
 * Test: http.metrics.
 */
#ifndef SCATTERD_METRICS_H
#define SCATTERD_METRICS_H

#include "exchange.h"
#include "service.h"

/* Once, at the start. */
void metrics_begin(const service *s);

/* An exchange has ended; `route` is its pattern, "none" for a path there is not. */
void metrics_count(const exchange *x, const char *route);

void metrics_serve(const service *s, exchange *x);
void metrics_ready(const service *s, exchange *x);

#endif
