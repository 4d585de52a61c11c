/* exchange.h - one request and its reply, as plain data. http.c fills the request and sends the
 * reply; the handlers of route.c read the one and set the other. Test: unit.exchange.
 */
#ifndef SCATTERD_EXCHANGE_H
#define SCATTERD_EXCHANGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

#include "media.h"
#include "problem.h"
#include "spool.h"
#include "token.h"

enum { EXCHANGE_FIELDS = 28, EXCHANGE_BASE = 1100, EXCHANGE_ITEM = 72 };

enum { EXCHANGE_END = -1, EXCHANGE_BROKEN = -2 };

/* A reply that comes in pieces of unknown number. */
typedef struct {
  void *self;
  /* Writes up to `size` bytes and says how many; 0: none are there yet, http_wake when there are;
   * EXCHANGE_END: that was all; EXCHANGE_BROKEN: the rest is not to be had, and who reads is told
   * by a connection that closes in the middle. */
  ssize_t (*read)(void *self, char *room, size_t size);
} exchange_source;

/* What is sent back. Bytes are in `fd` if that is not -1, else at `bytes`. */
typedef struct {
  int status; /* 0: there is no reply yet */
  const char *type;
  char type_room[128]; /* where `type` may stand */
  coding coding;
  exchange_source source; /* in place of bytes, if it has `read` */
  int fd;                 /* closed once sent */
  const void *bytes;
  void *owned;   /* freed once sent; NULL if `bytes` are borrowed for ever */
  size_t offset; /* in fd, of the first byte that is sent */
  size_t size;
  int fields;
  struct {
    const char *name;
    char value[EXCHANGE_BASE + 200];
  } field[EXCHANGE_FIELDS];
} exchange_reply;

typedef struct exchange {
  /* the request */
  char id[65];              /* X-Request-Id, of the client or ours */
  char method[17];          /* longer ones are cut: none of ours is */
  char *target;             /* as sent */
  char *path;               /* decoded, without the query */
  char base[EXCHANGE_BASE]; /* URL of this service as the client sees it, no slash at the end */
  bool has_body;
  int64_t declared;   /* Content-Length; -1 if chunked; 0 without body */
  int64_t body_most;  /* bytes that the body may have */
  bool plain_problem; /* problems as application/json */
  bool model_error;   /* as errors of UM-Bridge (model_error.h), whatever is accepted */
  double began;       /* loop_now */
  spool body;
  exchange_reply reply;
  /* who sends it, of gate.c */
  char owner[TOKEN_NAME]; /* name of the token; "" where there are none */
  token_limits most;
  const void *route;         /* of route.c */
  char item[EXCHANGE_ITEM];  /* what {} in the route's path stands for */
  char item2[EXCHANGE_ITEM]; /* and the second {} */
  /* for the log, set by handlers */
  char process[EXCHANGE_ITEM];
  pid_t worker;
  double run_seconds;
  int64_t points;
  /* of the handler and of http.c */
  void *task;
  void *connection;
} exchange;

/* A new exchange for a request target; NULL when out of memory. */
exchange *exchange_new(const char *target);
void exchange_free(exchange **x);

/* Adopts the client's X-Request-Id if it is 1 to 64 letters, digits, '.', '_' or '-', else makes
 * one: unique within this process, unguessable between processes. */
void exchange_identify(exchange *x, const char *wanted);

/* Sets x->path from x->target: the path of an origin-form or absolute-form target, percent-decoded.
 * False for a target without a path, broken escapes, and escaped NUL. */
bool exchange_find_path(exchange *x);

/* Is this text a Host: name, IPv4 or [IPv6], and perhaps a port (RFC 9110, 7.2)? */
bool exchange_is_host(const char *text);

/* ---- The reply ---- */

/* Sets the reply. _text and _constant borrow bytes for ever; _bytes and _file take them. */
void exchange_text(exchange *x, int status, const char *type, const char *text);
void exchange_constant(exchange *x, int status, const char *type, coding how, const void *bytes,
                       size_t size);
void exchange_bytes(exchange *x, int status, const char *type, void *bytes, size_t size);
void exchange_file(exchange *x, int status, const char *type, coding how, int fd, size_t size);

/* 304: no bytes are sent, Content-Length is that of the 200 (RFC 9110, 8.6). */
void exchange_unchanged(exchange *x, size_t size);

/* The same reply in a content coding: takes its packed bytes in place of those it has. */
void exchange_pack(exchange *x, coding how, void *packed, size_t size);

/* Bytes that come from a source, which lives until the exchange ends. */
void exchange_stream(exchange *x, int status, const char *type, exchange_source source);

/* Sets a problem as the reply, in the form and media type the client takes. */
void exchange_problem(exchange *x, const problem *p);

/* The same for a problem without errors, in one call. */
void exchange_refuse(exchange *x, int status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Adds a header field to the reply, set or not yet; `name` is borrowed for ever. Fields beyond
 * EXCHANGE_FIELDS or longer than their room are left out. */
void exchange_add(exchange *x, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

#endif
