/* job_list.h - GET /jobs: filters, pages. Test: http.jobs.
 */
#ifndef SCATTERD_JOB_LIST_H
#define SCATTERD_JOB_LIST_H

#include "exchange.h"
#include "service.h"

void job_list_serve(const service *s, exchange *x);

#endif
