/* fetch.h - values by reference: what workers ask for while they read inputs ({"href": ...}), and
 * what they want kept (outputs by reference).
 *
 * Objects under /data and results of jobs are given as descriptors at once, whatever host stands in
 * an absolute URL, because the ids are unguessable and of data even name the bytes. Other URLs are
 * fetched if their host is in fetch-hosts: no redirects, no private addresses, limits of size and
 * time. Test: http.data, http.fetch.
 */
#ifndef SCATTERD_FETCH_H
#define SCATTERD_FETCH_H

#include "service.h"

typedef struct fetches fetches;

/* Answers the workers of s->pool from now on. NULL when out of memory. */
fetches *fetches_new(const service *s);
void fetches_free(fetches **f);

#endif
