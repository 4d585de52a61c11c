/* submitter.h - who submits: what queues are fair between and Idempotency-Keys are unique within.
 */
#ifndef SCATTERD_SUBMITTER_H
#define SCATTERD_SUBMITTER_H

#include "exchange.h"
#include "job_row.h"

/* The owner of the request; where there are no tokens the address of the client, "local" on a Unix
 * socket. */
void submitter_of(const exchange *x, char submitter[JOB_SUBMITTER]);

#endif
