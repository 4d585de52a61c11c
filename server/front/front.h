/* front.h - the daemon: listens, starts workers, serves until it is told to stop.
 */
#ifndef SCATTERD_FRONT_H
#define SCATTERD_FRONT_H

#include "param.h"

/* Runs until SIGTERM or SIGINT; then takes no new requests, lets running ones end for
 * grace-seconds (a second signal cuts that short) and returns. Exit status: 0, or 1 when it could
 * not start. May change *set: an empty data-dir becomes the real one. */
int front_main(parameters *set);

#endif
