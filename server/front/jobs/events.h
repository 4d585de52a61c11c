/* events.h - GET /jobs/{id}/events: what happens to a job, as it happens (server-sent events, HTML
 * Living Standard section 9.2).
 *
 * Events "status" (a statusInfo), "progress", "phase" and "residual"
 * ({"progress","phase","residual"?}). Each job keeps its newest events, each client only its place
 * among them: one that reads slowly, or comes back with Last-Event-ID after long, gets a status in
 * place of what it missed. The stream ends with the job; a client that comes back after that gets
 * 204, which stops it. Test: http.jobs.
 */
#ifndef SCATTERD_EVENTS_H
#define SCATTERD_EVENTS_H

#include "exchange.h"
#include "loop.h"
#include "service.h"

typedef struct streams streams;

streams *streams_new(loop *l, const parameters *set); /* NULL when out of memory */
void streams_free(streams **all);

/* Ends all of them, now. */
void streams_stop(streams *all);

void events_serve(const service *s, exchange *x);
void events_end(const service *s, exchange *x);

#endif
