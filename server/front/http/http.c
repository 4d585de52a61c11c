/* What libmicrohttpd calls, and the loop. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include "http_inner.h"
#include "log.h"
#include "tls.h"

/* ---- Waiting for the reply ---- */

static void resume(connection *c) {
  c->http->wake = true;
  MHD_resume_connection(c->mhd);
}

/* The client closed its side: nobody will read the reply, so the connection is resumed for
 * on_request to close it; so is one that sleeps between two pieces of its reply. Nothing else is
 * done: bytes may still be unread. */
static void on_hangup(void *self, uint32_t events) {
  connection *c = self;
  (void)events;
  const bool waits = c->state == PENDING && c->x->reply.status == 0;
  if (waits && !c->vanished) resume(c);
  c->vanished = true;
  if (c->asleep) http_wake(c->x);
}

static void suspend(connection *c) {
  c->state = PENDING;
  MHD_suspend_connection(c->mhd);
}

void http_wake(exchange *x) {
  connection *c = x->connection;
  if (!c->asleep) return;
  c->asleep = false;
  resume(c);
}

void http_deliver(exchange *x) {
  resume(x->connection);
}

/* ---- What libmicrohttpd calls ---- */

static void *on_target(void *self, const char *target, struct MHD_Connection *mhd) {
  http *h = self;
  connection *c = MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_SOCKET_CONTEXT)->socket_context;
  if (c != NULL) c->x = exchange_new(target);
  if (c == NULL || c->x == NULL) return NULL;
  c->clean = false;
  c->x->connection = c;
  c->x->began = c->heard = loop_now();
  exchange_identify(c->x, NULL);
  c->state = HEADER;
  h->pending++;
  return c->x;
}

static enum MHD_Result on_header(connection *c, const char *method, const char *version) {
  const http *h = c->http;
  head facts;
  http_read_head(c, method, version, &facts);
  if (exchange_find_path(c->x)) h->handler.look(h->handler.self, c->x);
  if (admit(c->x, &facts, h->set, &h->place)) h->handler.begin(h->handler.self, c->x);
  c->state = BODY;
  c->heard = loop_now();
  if (c->x->reply.status == 0 || !c->x->has_body) return MHD_YES;
  c->refused = true;
  return http_send(c);
}

static enum MHD_Result on_body(connection *c, const char *bytes, size_t *size) {
  const parameters *set = c->http->set;
  exchange *x = c->x;
  /* One that will be large goes to its file at once, so that it need not be moved later. */
  const int64_t memory = x->declared > set->spool_bytes ? 0 : set->spool_bytes;
  c->heard = loop_now();
  if (x->body.size + (int64_t)*size > x->body_most) {
    exchange_refuse(x, 413, "body: got more than %lld bytes (body-bytes)", (long long)x->body_most);
  } else if (!spool_add(&x->body, bytes, *size, memory, set->data_dir)) {
    log_say(LOG_ERROR, "spool", "cannot keep a body: %s", strerror(errno));
    exchange_refuse(x, 507, "body: no room to keep it");
  } else {
    *size = 0;
    return MHD_YES;
  }
  http_last_word(c);
  return MHD_NO;
}

static enum MHD_Result on_request(connection *c) {
  exchange *x = c->x;
  const bool vain = c->vanished && (c->state == PENDING || x->has_body);
  if (x->reply.status == 0 && vain) return MHD_NO; /* no work for a client that has gone */
  if (x->reply.status == 0 && !spool_end(&x->body)) {
    log_say(LOG_ERROR, "spool", "cannot close a body: %s", strerror(errno));
    exchange_refuse(x, 503, "body: it cannot be read again now");
  }
  if (x->reply.status == 0) c->http->handler.serve(c->http->handler.self, x);
  if (x->reply.status != 0) return http_send(c);
  suspend(c);
  return MHD_YES;
}

static enum MHD_Result on_access(void *self, struct MHD_Connection *mhd, const char *url,
                                 const char *method, const char *version, const char *bytes,
                                 size_t *size, void **context) {
  exchange *x = *context;
  (void)self, (void)mhd, (void)url;
  if (x == NULL) return MHD_NO; /* no memory for it */
  connection *c = x->connection;
  if (c->state == HEADER) return on_header(c, method, version);
  if (*size > 0) return on_body(c, bytes, size);
  return on_request(c);
}

static void log_peer(log_line *line, const connection *c) {
  char text[64];
  http_peer(c->x, text, sizeof text);
  log_text(line, "peer", text);
}

static void log_request(const connection *c, bool complete) {
  const exchange *x = c->x;
  log_line line;
  log_begin(&line, LOG_INFO, "request");
  log_text(&line, "id", x->id);
  log_peer(&line, c);
  log_text(&line, "method", x->method);
  log_text(&line, "target", x->target);
  log_count(&line, "status", x->reply.status);
  log_count(&line, "in", x->body.size);
  log_count(&line, "out", (int64_t)x->reply.size);
  log_milliseconds(&line, "ms", loop_now() - x->began);
  if (*x->process != '\0') log_text(&line, "process", x->process);
  if (x->worker != 0) {
    log_count(&line, "worker", x->worker);
    log_milliseconds(&line, "run_ms", x->run_seconds);
  }
  if (x->points > 0) log_count(&line, "points", x->points);
  if (*x->owner != '\0') log_text(&line, "token", x->owner);
  if (!complete) log_text(&line, "end", "aborted");
  log_end(&line);
}

static void on_completed(void *self, struct MHD_Connection *mhd, void **context,
                         enum MHD_RequestTerminationCode code) {
  http *h = self;
  exchange *x = *context;
  (void)mhd;
  if (x == NULL) return;
  connection *c = x->connection;
  h->handler.end(h->handler.self, x);
  log_request(c, code == MHD_REQUEST_TERMINATED_COMPLETED_OK);
  h->pending--;
  exchange_free(&c->x);
  *context = NULL;
  c->state = IDLE;
  c->asleep = false;
  c->used = true;
  c->clean = code == MHD_REQUEST_TERMINATED_COMPLETED_OK && !c->refused;
  c->since = loop_now();
}

/* May one more connection come from there? Those of this machine are not counted: whoever is a
 * proxy for many is usually here. */
static enum MHD_Result on_knock(void *self, const struct sockaddr *from, socklen_t size) {
  const http *h = self;
  const int64_t most = h->set->connections_per_address;
  int64_t count = 0;
  ip client;
  (void)size;
  if (most == 0 || !ip_of(&client, from) || ip_is_loopback(&client)) return MHD_YES;
  for (const connection *c = h->connections; c != NULL; c = c->next) {
    count += c->is_remote && ip_is_same_client(&c->from, &client);
  }
  return count < most ? MHD_YES : MHD_NO;
}

static void open_connection(http *h, struct MHD_Connection *mhd, void **context) {
  connection *c = calloc(1, sizeof *c);
  *context = c;
  if (c == NULL) return;
  c->http = h;
  c->mhd = mhd;
  c->fd = MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
  const union MHD_ConnectionInfo *info =
      MHD_get_connection_info(mhd, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  c->is_remote = info != NULL && info->client_addr != NULL && ip_of(&c->from, info->client_addr);
  c->since = c->heard = loop_now();
  c->hangup = (loop_source){on_hangup, c};
  c->next = h->connections;
  if (c->next != NULL) c->next->previous = c;
  h->connections = c;
  h->count++;
  h->opened++;
  loop_watch(h->loop, c->fd, EPOLLRDHUP | EPOLLET, &c->hangup);
}

static void close_connection(connection *c) {
  http *h = c->http;
  h->wake = true; /* a daemon that was full listens again only when it is run once more */
  loop_forget(h->loop, c->fd, &c->hangup);
  if (!c->clean && h->drain != NULL) drain_add(h->drain, c->fd);
  if (c->next != NULL) c->next->previous = c->previous;
  *(c->previous != NULL ? &c->previous->next : &h->connections) = c->next;
  h->count--;
  free(c);
}

static void on_connection(void *self, struct MHD_Connection *mhd, void **context,
                          enum MHD_ConnectionNotificationCode code) {
  if (code == MHD_CONNECTION_NOTIFY_STARTED) {
    open_connection(self, mhd, context);
  } else if (*context != NULL) {
    close_connection(*context);
  }
}

static void on_message(void *self, const char *format, va_list arguments) {
  char text[256];
  (void)self;
  vsnprintf(text, sizeof text, format, arguments);
  text[strcspn(text, "\n")] = '\0';
  const bool refuses = strstr(text, "HTTP response code") != NULL; /* what never was a request */
  log_say(refuses ? LOG_INFO : LOG_DEBUG, "http", "%s", text);
}

/* ---- In the event loop ---- */

static double due(void *self) {
  const http *h = self;
  MHD_UNSIGNED_LONG_LONG milliseconds;
  if (h->wake) return 0;
  double first = fmin(h->breath, h->connections != NULL ? h->sweep : INFINITY);
  if (MHD_get_timeout(h->mhd, &milliseconds) == MHD_YES) {
    first = fmin(first, loop_now() + 1e-3 * (double)milliseconds);
  }
  return first;
}

static void run(void *self) {
  http *h = self;
  h->wake = false;
  if (h->breath <= loop_now()) http_look_again(h);
  if (h->connections != NULL && h->sweep <= loop_now()) http_sweep(h);
  MHD_run(h->mhd);
}

static void on_ready(void *self, uint32_t events) {
  enum { PATIENCE = 3 }; /* a client may be gone before it is accepted */
  http *h = self;
  const bool alone = h->connections == NULL;
  const int64_t opened = h->opened;
  (void)events;
  MHD_run(h->mhd);
  h->vain = alone && h->opened == opened ? h->vain + 1 : 0;
  if (h->vain > PATIENCE) http_take_breath(h);
}

/* Seconds without traffic after which libmicrohttpd closes. It sends no 408, so our own patience
 * must end first; what is left to it are clients that do not read. */
static unsigned patience(const parameters *set) {
  return (unsigned)ceil(fmax(set->idle_seconds, set->receive_seconds)) + 2;
}

/* What TLS adds to the options of libmicrohttpd; nothing without it. */
static void set_tls(const parameters *set, struct MHD_OptionItem options[3]) {
  int used = 0;
  if (*set->tls_certificate != '\0') {
    options[used++] = (struct MHD_OptionItem){MHD_OPTION_HTTPS_CERT_CALLBACK, 0, tls_source()};
    options[used++] =
        (struct MHD_OptionItem){MHD_OPTION_HTTPS_PRIORITIES, 0, (void *)tls_priorities};
  }
  options[used] = (struct MHD_OptionItem){MHD_OPTION_END, 0, NULL};
}

http *http_new(loop *l, const parameters *set, const http_place *place, const http_handler *handler,
               fault *why) {
  struct MHD_OptionItem secure[3];
  const unsigned kind = *set->tls_certificate != '\0' ? MHD_USE_TLS : 0;
  set_tls(set, secure);
  http *h = calloc(1, sizeof *h);
  if (h == NULL) goto failed;
  *h = (http){.loop = l, .set = set, .handler = *handler, .place = *place};
  h->waited = -1;
  h->breath = INFINITY;
  h->source = (loop_source){on_ready, h};
  h->drain = drain_new(l);
  if (h->drain == NULL) goto failed;
  h->mhd = MHD_start_daemon(
      MHD_USE_EPOLL | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG | kind, 0, on_knock, h,
      on_access, h, MHD_OPTION_EXTERNAL_LOGGER, on_message, NULL, MHD_OPTION_LISTEN_SOCKET,
      place->listener, MHD_OPTION_CONNECTION_LIMIT, (unsigned)set->connections,
      MHD_OPTION_CONNECTION_TIMEOUT, patience(set), MHD_OPTION_CONNECTION_MEMORY_LIMIT,
      (size_t)(4 * set->header_bytes), MHD_OPTION_URI_LOG_CALLBACK, on_target, h,
      MHD_OPTION_NOTIFY_COMPLETED, on_completed, h, MHD_OPTION_NOTIFY_CONNECTION, on_connection, h,
      MHD_OPTION_ARRAY, secure, MHD_OPTION_END);
  if (h->mhd == NULL) goto failed;
  h->epoll = MHD_get_daemon_info(h->mhd, MHD_DAEMON_INFO_EPOLL_FD)->epoll_fd;
  if (!loop_watch(l, h->epoll, EPOLLIN, &h->source)) goto failed;
  loop_add(l, (loop_chore){due, run, h});
  return h;
failed:
  fault_set(why, "cannot start the HTTP server: %s", strerror(errno));
  http_free(&h);
  return NULL;
}

void http_free(http **h) {
  if (*h == NULL) return;
  if ((*h)->mhd != NULL) {
    loop_forget((*h)->loop, (*h)->epoll, &(*h)->source);
    drain_free(&(*h)->drain);
    MHD_quiesce_daemon((*h)->mhd); /* so that it leaves the socket, which is not its own, open */
    MHD_stop_daemon((*h)->mhd);
  }
  drain_free(&(*h)->drain);
  free(*h);
  *h = NULL;
}

void http_quiesce(http *h) {
  if (h->quiet) return;
  h->quiet = true;
  MHD_quiesce_daemon(h->mhd);
  for (connection *c = h->connections; c != NULL; c = c->next) {
    if (c->state == IDLE) shutdown(c->fd, SHUT_RDWR);
  }
}

int http_pending(const http *h) {
  return h->pending;
}
