/* callback.h - calls to subscribers: who may be called, and calling them.
 *
 * A call is stored with the state it tells, so none is forgotten when the daemon ends; it is tried
 * callback-attempts times with pauses of 1, 4, 16, ... s, then given up. What comes of it is in the
 * job's log. Bodies: the results document for successUri, statusInfo for the others. Each carries
 * the fields of the Standard Webhooks specification: webhook-id (the same in each attempt),
 * webhook-timestamp, and with a callback-key webhook-signature: "v1," and the base64 of the
 * HMAC-SHA-256 of id "." timestamp "." body. Test: http.callbacks.
 */
#ifndef SCATTERD_CALLBACK_H
#define SCATTERD_CALLBACK_H

#include "exchange.h"
#include "loop.h"
#include "service.h"

typedef struct callbacks callbacks;

callbacks *callbacks_new(loop *l, const service *s); /* NULL when out of memory */
void callbacks_free(callbacks **all);

/* The time of day was set by so many seconds, and the dates of the store with it (clock.h). */
void callbacks_shift(callbacks *all, double by);

/* Are the addresses of a subscriber allowed (callback-hosts)? If not there is a 400. */
bool callback_allows(const service *s, exchange *x, const job_extra *extra);

#endif
