/* route.h - which handler serves which method and path: one table, in route.c.
 */
#ifndef SCATTERD_ROUTE_H
#define SCATTERD_ROUTE_H

#include <stdio.h>

#include "http.h"
#include "service.h"

/* The handler of all requests: finds the route, answers what has none (404, 405, OPTIONS), adds
 * what pages of other origins may know (CORS). */
http_handler route_handler(service *s);

/* The table, a line for each row: "GET /jobs/{}". HEAD goes with GET, OPTIONS with every path. */
void route_print(FILE *out);

#endif
