/* callback.h - subscribers: who may be called, and calling them. Test: http.jobs.callback.
 */
#ifndef SCATTERD_CALLBACK_H
#define SCATTERD_CALLBACK_H

#include "exchange.h"
#include "service.h"

/* Are the addresses of a subscriber allowed (callback-hosts)? If not there is a 400. */
bool callback_allows(const service *s, exchange *x, const job_extra *extra);

#endif
