/* execute.h - POST /processes/{id}/execution: negotiates, hands the body to a worker, replies with
 * what the worker says or with what became of it. Test: http.front, http.faults.
 */
#ifndef SCATTERD_EXECUTE_H
#define SCATTERD_EXECUTE_H

#include "exchange.h"
#include "service.h"

/* The header is there: refuses what cannot be answered, before the body is sent. */
void execute_begin(const service *s, exchange *x);

/* The body is there: the reply comes later. */
void execute_serve(const service *s, exchange *x);

/* The exchange ends: a request that still waits or runs is stopped. */
void execute_end(const service *s, exchange *x);

#endif
