/* host.h - by which names this service may be called. A web page can give its own name the address
 * of this service (DNS rebinding), and then counts as part of it; but requests made so carry that
 * name in Host. So where there are no tokens to keep strangers out, names that nobody configured
 * are refused. Test: unit.host, http.access.
 */
#ifndef SCATTERD_HOST_H
#define SCATTERD_HOST_H

#include <stdbool.h>

#include "param.h"

typedef enum {
  HOST_ANY,      /* there are tokens, or no browser gets here (Unix socket) */
  HOST_LOOPBACK, /* localhost and loopback addresses */
  HOST_ADDRESS,  /* these and all addresses: no name, nothing to rebind */
} host_rule;

/* Is `host`, a name or address perhaps with a port, one of those that the rule allows, one of the
 * parameter hosts, or that of public-url? */
bool host_allows(host_rule rule, const parameters *set, const char *host);

/* Is `origin` (as in the field Origin) in a list such as "https://a.example, *"? */
bool host_lists(const char *list, const char *origin);

#endif
