/* outbound.h - requests of ours to other services, driven by the event loop: the only door to
 * libcurl.
 *
 * http and https, no redirects, no proxy, no credentials or cookies of anybody; certificates are
 * checked. Names are looked up in threads of libcurl's, for which nothing waits once their call has
 * ended. Which hosts may be asked at all is the caller's to know (outbound_allows). Test:
 * unit.outbound, fault.outbound (each allocation fails), http.callbacks.
 */
#ifndef SCATTERD_OUTBOUND_H
#define SCATTERD_OUTBOUND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "loop.h"

typedef struct outbound outbound;
typedef struct outbound_call outbound_call;

outbound *outbound_new(loop *l); /* NULL when it cannot be had */

/* Ends all calls without a word. */
void outbound_free(outbound **o);

enum { OUTBOUND_FIELDS = 8 };

typedef struct {
  const char *url;
  const char *fields[OUTBOUND_FIELDS]; /* "Name: value", NULL after the last; copied */
  bool has_body;                       /* POST, else GET */
  const void *body;                    /* lives until the call ends */
  size_t size;
  double seconds;   /* for all of it */
  int64_t most;     /* bytes of the reply; more is an error */
  bool public_only; /* no address of a private, local or otherwise special network */
} outbound_request;

typedef struct {
  int status;      /* HTTP status; 0: there is none */
  char why[200];   /* status 0: the reason */
  bool scarce;     /* status 0: we lack memory or descriptors; nobody else is to blame */
  char type[128];  /* Content-Type, "" without */
  char coding[32]; /* Content-Encoding, "" without */
  int fd;          /* the bytes, the receiver's to close; -1 if there are none */
  int64_t size;
} outbound_reply;

/* Begins a call; `done` is called once, later, from the loop. NULL when out of memory. When it runs
 * out later, all calls under way may fail. */
outbound_call *outbound_start(outbound *o, const outbound_request *r,
                              void (*done)(void *context, const outbound_reply *reply),
                              void *context);

/* Ends a call; `done` is not called. */
void outbound_cancel(outbound_call *c);

/* Does a list such as "a.example b.example:8443" name the host of an http or https URL (with its
 * port if the URL has one)? User names in URLs are not allowed. */
bool outbound_allows(const char *hosts, const char *url);

#endif
