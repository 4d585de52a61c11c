/* ready.h - what it takes to serve: the checks of /readyz. Test: http.metrics.
 */
#ifndef SCATTERD_READY_H
#define SCATTERD_READY_H

#include "service.h"

/* Name and reason of check k, *name NULL past the last one; true if it holds. */
bool ready_check(const service *s, int k, const char **name, const char **reason);

#endif
