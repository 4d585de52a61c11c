/* Clients that are slow, and clients that cannot be let in. */
#include <math.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "http_inner.h"

static const double sweep_seconds = 0.25;  /* how often slow connections are looked for */
static const double hangup_seconds = 1;    /* for what a client that closed had still sent */
static const double breath_seconds = 0.05; /* between tries to accept when that fails */

/* When the patience with a connection ends: a header has a fixed time; a body may neither pause
 * longer than that nor, on the whole, be slower than receive-rate. The sending of replies is
 * libmicrohttpd's to watch (idle-seconds). */
static double deadline(const connection *c) {
  const parameters *set = c->http->set;
  if (c->vanished && c->state < PENDING) return c->heard + hangup_seconds;
  switch (c->state) {
    case IDLE:
      return c->since + (c->used ? set->idle_seconds : set->receive_seconds);
    case HEADER:
      return c->x->began + set->receive_seconds;
    case BODY:
      return fmin(c->heard, c->x->began + (double)c->x->body.size / (double)set->receive_rate) +
             set->receive_seconds;
    default:
      return INFINITY;
  }
}

static void time_out(connection *c) {
  if (c->x != NULL && c->x->reply.status == 0) {
    exchange_refuse(c->x, 408,
                    "request: it came too slowly (receive-seconds %g, receive-rate %lld)",
                    c->http->set->receive_seconds, (long long)c->http->set->receive_rate);
    http_last_word(c);
  }
  shutdown(c->fd, SHUT_RDWR); /* libmicrohttpd then closes it */
}

/* ---- When no connection can be accepted ----
 * Without a descriptor for it libmicrohttpd accepts nobody. If it has no connection, it goes on
 * trying, as fast as it is run: then its descriptor is left alone for a breath. If it has some, it
 * waits until one of them closes, however long that takes: then a connection that closes at once is
 * made for it as soon as there are descriptors again. */

void http_take_breath(http *h) {
  loop_forget(h->loop, h->epoll, &h->source);
  h->breath = loop_now() + breath_seconds;
}

void http_look_again(http *h) {
  h->breath = INFINITY;
  if (!loop_watch(h->loop, h->epoll, EPOLLIN, &h->source)) http_take_breath(h);
}

static void knock(http *h) {
  static const struct sockaddr nobody = {.sa_family = AF_UNIX};
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends) != 0) return;
  (void)MHD_add_connection(h->mhd, ends[0], &nobody, sizeof nobody); /* closes it in any case */
  close(ends[1]);
  h->wake = true;
}

/* Has somebody been waiting since the last sweep while there was room? */
static void look_at_door(http *h) {
  struct pollfd door = {.fd = h->place.listener, .events = POLLIN};
  const bool waits = !h->quiet && h->count < h->set->connections && poll(&door, 1, 0) > 0;
  if (waits && h->waited == h->opened) knock(h);
  h->waited = waits ? h->opened : -1;
}

void http_sweep(http *h) {
  const double now = loop_now();
  h->sweep = now + sweep_seconds;
  look_at_door(h);
  for (connection *c = h->connections; c != NULL; c = c->next) {
    if (deadline(c) <= now) time_out(c);
  }
}
