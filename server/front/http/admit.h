/* admit.h - is this HTTP we can work with? Checks of a request's head before anyone asks what it
 * means. Test: unit.exchange.
 */
#ifndef SCATTERD_ADMIT_H
#define SCATTERD_ADMIT_H

#include "exchange.h"
#include "host.h"
#include "param.h"

/* What the checks look at; fields are NULL if absent. */
typedef struct {
  const char *method;
  bool old;    /* HTTP/1.0 */
  size_t size; /* bytes of request line and fields */
  bool broken; /* fields are not all that came, or have names that are none: seam.h */
  const char *id, *host, *length, *coding, *accept;
  int hosts, lengths, codings; /* occurrences */
  char room[1024];             /* where `accept` may stand */
} head;

/* Where requests come in. */
typedef struct {
  int listener;     /* listening socket */
  const char *host; /* what links say for a client that names no Host */
  host_rule rule;   /* which Host it may name */
} http_place;

/* Fills the request part of *x from its head. False if the request is refused: x->reply is the
 * problem then. */
bool admit(exchange *x, const head *h, const parameters *set, const http_place *place);

#endif
