/* drain.h - closing a connection whose client may still be sending.
 *
 * Closing a TCP socket with unread bytes resets the connection, and the reset can destroy the reply
 * on its way (RFC 9112 section 9.6). So after an early refusal the socket is kept a little: our
 * side is closed for sending, what comes is thrown away.
 */
#ifndef SCATTERD_DRAIN_H
#define SCATTERD_DRAIN_H

#include "loop.h"

typedef struct drain drain;

drain *drain_new(loop *l); /* NULL when out of memory */
void drain_free(drain **g);

/* Lets a copy of the socket be drained; the caller goes on to close its own. Does nothing when
 * enough of them do already. */
void drain_add(drain *g, int fd);

#endif
