/* listener.h - the socket the daemon listens on: TCP or Unix.
 */
#ifndef SCATTERD_LISTENER_H
#define SCATTERD_LISTENER_H

#include <stdbool.h>

#include "fault.h"

typedef struct {
  int fd;
  char address[300]; /* where it really listens: "127.0.0.1:40313", "[::1]:80", "unix:/run/s" */
  char host[300];    /* what a URL to it may say: the address, "localhost" for a Unix socket */
  bool is_local;     /* only this machine reaches it */
  bool is_unix;
  char path[108]; /* of a Unix socket, else "" */
} listener;

/* Opens ADDR:PORT (name, IPv4, [IPv6]) or unix:PATH. A socket file that nobody listens on is
 * replaced; one in use is an error. A socket that systemd passed is taken in its place, whatever
 * `text` says, and its file stays systemd's. */
bool listener_open(listener *l, const char *text, fault *why);

/* Closes and removes the socket file. */
void listener_close(listener *l);

#endif
