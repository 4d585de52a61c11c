/* site.h - the static documents: landing page, API description, processes. "{B}" in them stands for
 * the address of the service and is replaced when they are served. Test: http.front.
 */
#ifndef SCATTERD_SITE_H
#define SCATTERD_SITE_H

#include "exchange.h"

/* Replies with document `name` as `type`; 404 if there is none. */
void site_serve(exchange *x, const char *name, const char *type);

/* The same with a page, which may load nothing and stand in nobody else's frame. */
void site_serve_page(exchange *x, const char *name);

/* The first `limit` processes. */
void site_processes(exchange *x, int64_t limit);

bool site_has_process(const char *id);

#endif
