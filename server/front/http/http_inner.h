/* http_inner.h - a server and its connections, for the files http*.c alone: http.c what
 * libmicrohttpd and the loop call, http_read.c what a request says, http_send.c its reply,
 * http_door.c who comes in and whose time is up.
 */
#ifndef SCATTERD_HTTP_INNER_H
#define SCATTERD_HTTP_INNER_H

#include <microhttpd.h>

#include "drain.h"
#include "http.h"
#include "ip.h"

typedef enum { IDLE, HEADER, BODY, PENDING, REPLYING } connection_state;

typedef struct connection connection;
struct connection {
  connection *next, *previous;
  http *http;
  struct MHD_Connection *mhd;
  int fd;
  connection_state state;
  double since;  /* when it became idle */
  double heard;  /* when something of a request last came */
  bool used;     /* it has carried a request */
  bool clean;    /* nothing unread can be left of its last request */
  bool refused;  /* its request is, before all of the body was read */
  bool vanished; /* the client closed its side */
  bool asleep;   /* REPLYING: its source has nothing to say */
  exchange *x;   /* not IDLE */
  loop_source hangup;
  bool is_remote; /* of another machine, at an address */
  ip from;
};

struct http {
  loop *loop;
  const parameters *set;
  http_handler handler;
  http_place place;
  struct MHD_Daemon *mhd;
  int epoll;
  loop_source source;
  drain *drain;
  connection *connections;
  double sweep; /* time of the next one */
  bool wake;    /* libmicrohttpd has something to do that its descriptor does not tell */
  bool quiet;
  int count;      /* connections */
  int64_t opened; /* connections so far */
  int64_t waited; /* `opened` when somebody was last seen waiting to be accepted, -1: nobody was */
  int vain;       /* runs in a row that should have accepted somebody and did not */
  double breath;  /* when to look at its descriptor again, INFINITY: it is looked at */
  int pending;
};

/* ---- http_read.c ---- */

/* What admit() wants to know of a header that has come. */
void http_read_head(const connection *c, const char *method, const char *version, head *out);

/* ---- http_send.c ---- */

/* Hands the reply that is set to libmicrohttpd. MHD_NO: there is no memory for it, close. */
enum MHD_Result http_send(connection *c);

/* Replies in the middle of a request, where libmicrohttpd cannot: writes the reply that is set to
 * the socket as far as it goes (a problem always fits its buffer), to be closed after it. */
void http_last_word(connection *c);

/* ---- http_door.c ---- */

/* Leaves the descriptor of libmicrohttpd alone for a moment; looks at it again. */
void http_take_breath(http *h);
void http_look_again(http *h);

/* Lets in who waits unnoticed, ends connections whose time is up. Sets h->sweep. */
void http_sweep(http *h);

#endif
