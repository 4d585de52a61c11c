/* negotiate.h - what the client takes of what there is. Test: http.front.
 */
#ifndef SCATTERD_NEGOTIATE_H
#define SCATTERD_NEGOTIATE_H

#include "exchange.h"

/* What the client takes of `offers`; -1 after a 406. Adds Vary. */
int negotiate(exchange *x, const char *const *offers, int count);

/* Does it take JSON? If not there is a 406. */
bool negotiate_json(exchange *x);

/* Packs a reply of status 200 that is in memory, in the coding that the client asks for by name, if
 * it is worth it. One that takes nothing we have gets it as it is. Adds Vary. */
void negotiate_coding(exchange *x);

#endif
