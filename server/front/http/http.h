/* http.h - HTTP/1.1 on a listening socket, driven by the event loop: the only door to
 * libmicrohttpd.
 *
 * Bodies are spooled as they arrive, replies sent from memory or from a descriptor. While a reply
 * is pending the connection sleeps, and its client is watched for leaving. Requests that break HTTP
 * itself are refused here; what a request means is the handler's business.
 * Tests: http.front, http.faults.
 */
#ifndef SCATTERD_HTTP_H
#define SCATTERD_HTTP_H

#include "admit.h"
#include "exchange.h"
#include "fault.h"
#include "loop.h"
#include "param.h"

typedef struct http http;

typedef struct {
  void *self;
  /* The path is known: sets how refusals are told. */
  void (*look)(void *self, exchange *x);
  /* The header is there. Sets a reply to refuse the request, else the body follows. */
  void (*begin)(void *self, exchange *x);
  /* The body is there too. Sets a reply, or leaves that for later: then calls http_deliver. */
  void (*serve)(void *self, exchange *x);
  /* The reply is sent, or the client has gone, also in the middle of its request or while its
   * reply was pending: forget x, which is freed after this. Called once for each x. */
  void (*end)(void *self, exchange *x);
} http_handler;

/* Serves the socket of a place, which stays the caller's. */
http *http_new(loop *l, const parameters *set, const http_place *place, const http_handler *handler,
               fault *why);

/* Ends all connections. No reply may be pending. */
void http_free(http **h);

/* A header field of the request, its occurrences joined by ", "; a query argument. NULL if absent.
 * Both live as long as the exchange, the field at `room` if it occurs more than once. Of an
 * argument that occurs more than once the first is taken: http_arguments counts. */
const char *http_field(const exchange *x, const char *name, char *room, size_t size);
const char *http_argument(const exchange *x, const char *name);
int http_arguments(const exchange *x, const char *name);

/* All values of an argument that may occur more than once, with commas between, in `room`; NULL if
 * there is none, "" if they do not fit. */
const char *http_argument_list(const exchange *x, const char *name, char *room, size_t size);

/* Address of the client, "local" on a Unix socket. */
void http_peer(const exchange *x, char *room, size_t size);

/* Sends the reply of an exchange that was left for later. */
void http_deliver(exchange *x);

/* The source of a reply has more to say, or is at its end. */
void http_wake(exchange *x);

/* Takes no new connections, closes idle ones, and each other one after its reply. */
void http_quiesce(http *h);

/* Requests begun whose reply is not sent. */
int http_pending(const http *h);

#endif
