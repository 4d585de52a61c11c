/* quota.h - how many executions the owner of a request has at the same time. Test: http.access.
 */
#ifndef SCATTERD_QUOTA_H
#define SCATTERD_QUOTA_H

#include "exchange.h"
#include "service.h"

/* May the owner of *x have `more` executions, jobs or not? False if not: the reply is 429 then.
 * Cost: the number of tasks that wait, and of submitters that have jobs. */
bool quota_allows(const service *s, exchange *x, int64_t more);

/* How many jobs the owner may have, beside its executions here that are none; INT64_MAX: any. */
int64_t quota_jobs(const service *s, const exchange *x);

/* Refuses a job that it might have had, but for one that another daemon stored first. */
void quota_refuse_late(const service *s, exchange *x);

#endif
