#include "http.h"

#include <errno.h>
#include <math.h>
#include <microhttpd.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "admit.h"
#include "drain.h"
#include "ip.h"
#include "log.h"
#include "seam.h"
#include "tls.h"

static const double sweep_seconds = 0.25;  /* how often slow connections are looked for */
static const double hangup_seconds = 1;    /* for what a client that closed had still sent */
static const double breath_seconds = 0.05; /* between tries to accept when that fails */

typedef enum { IDLE, HEADER, BODY, PENDING, REPLYING } state;

typedef struct connection connection;
struct connection {
  connection *next, *previous;
  http *http;
  struct MHD_Connection *mhd;
  int fd;
  state state;
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

/* ---- Reading the request ---- */

const char *http_argument(const exchange *x, const char *name) {
  const connection *c = x->connection;
  return MHD_lookup_connection_value(c->mhd, MHD_GET_ARGUMENT_KIND, name);
}

typedef struct {
  const char *name;
  int count;
} tally;

static enum MHD_Result count_argument(void *self, enum MHD_ValueKind kind, const char *name,
                                      const char *value) {
  tally *t = self;
  (void)kind;
  (void)value;
  t->count += strcmp(name, t->name) == 0;
  return MHD_YES;
}

int http_arguments(const exchange *x, const char *name) {
  const connection *c = x->connection;
  tally t = {name, 0};
  MHD_get_connection_values(c->mhd, MHD_GET_ARGUMENT_KIND, count_argument, &t);
  return t.count;
}

void http_peer(const exchange *x, char *room, size_t size) {
  const connection *c = x->connection;
  const union MHD_ConnectionInfo *info =
      MHD_get_connection_info(c->mhd, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  snprintf(room, size, "local");
  if (info == NULL || info->client_addr == NULL) return;
  ip_show(info->client_addr, room, size);
}

typedef struct {
  const char *name, *first;
  int count;
  char *room;
  size_t size;
} gather;

static enum MHD_Result gather_field(void *self, enum MHD_ValueKind kind, const char *name,
                                    const char *value) {
  gather *g = self;
  (void)kind;
  if (strcasecmp(name, g->name) != 0) return MHD_YES;
  if (value == NULL) value = "";
  if (g->count++ == 0) {
    g->first = value;
    if (g->size > 0) snprintf(g->room, g->size, "%s", value);
  } else if (g->size > 0) {
    const size_t used = strlen(g->room);
    snprintf(g->room + used, g->size - used, ", %s", value);
  }
  return MHD_YES;
}

const char *http_field(const exchange *x, const char *name, char *room, size_t size) {
  const connection *c = x->connection;
  gather g = {.name = name, .room = room, .size = size};
  MHD_get_connection_values(c->mhd, MHD_HEADER_KIND, gather_field, &g);
  return g.count > 1 && size > 0 ? room : g.first;
}

static const char *single_field(const connection *c, const char *name, int *count) {
  gather g = {.name = name};
  MHD_get_connection_values(c->mhd, MHD_HEADER_KIND, gather_field, &g);
  *count = g.count;
  return g.first;
}

static enum MHD_Result join_field(void *self, enum MHD_ValueKind kind, const char *name,
                                  const char *value) {
  (void)kind;
  seam_field(self, name, value != NULL ? value : "");
  return MHD_YES;
}

/* From 1.0 on the library reads headers as others do. */
static bool is_broken(const connection *c, const char *method, size_t size) {
  seam s = {.is_strict = *MHD_get_version() == '0'};
  MHD_get_connection_values(c->mhd, MHD_HEADER_KIND, join_field, &s);
  if (size > 0) seam_end(&s, method + size);
  return s.is_broken;
}

static void read_head(const connection *c, const char *method, const char *version, head *out) {
  const union MHD_ConnectionInfo *size =
      MHD_get_connection_info(c->mhd, MHD_CONNECTION_INFO_REQUEST_HEADER_SIZE);
  int ignored;
  *out = (head){.method = method, .size = size != NULL ? size->header_size : 0};
  out->broken = is_broken(c, method, out->size);
  out->old = strcmp(version, "HTTP/1.0") == 0;
  out->id = single_field(c, "X-Request-Id", &ignored);
  out->host = single_field(c, "Host", &out->hosts);
  out->length = single_field(c, "Content-Length", &out->lengths);
  out->coding = single_field(c, "Transfer-Encoding", &out->codings);
  out->accept = http_field(c->x, "Accept", out->room, sizeof out->room);
}

/* ---- Sending the reply ---- */

/* Replies up to this size are copied into memory and leave in one piece with their header, which
 * is cheaper than sendfile. */
static const size_t small = 16384;

static struct MHD_Response *response_of_file(exchange_reply *r) {
  char bytes[16384];
  const int fd = r->fd;
  if (r->size > small) {
    struct MHD_Response *response = MHD_create_response_from_fd_at_offset64(r->size, fd, r->offset);
    if (response != NULL) r->fd = -1; /* the response closes it */
    return response;
  }
  if (pread(fd, bytes, r->size, (off_t)r->offset) != (ssize_t)r->size) return NULL;
  return MHD_create_response_from_buffer(r->size, bytes, MHD_RESPMEM_MUST_COPY);
}

/* Asks the source of a reply for more; without any the connection sleeps until http_wake. */
static ssize_t read_source(void *self, uint64_t position, char *room, size_t size) {
  connection *c = self;
  const exchange_source *source = &c->x->reply.source;
  (void)position;
  if (c->vanished) return MHD_CONTENT_READER_END_WITH_ERROR;
  const ssize_t length = source->read(source->self, room, size);
  if (length == EXCHANGE_END) return MHD_CONTENT_READER_END_OF_STREAM;
  if (length < 0) return MHD_CONTENT_READER_END_WITH_ERROR;
  c->asleep = length == 0;
  if (c->asleep) MHD_suspend_connection(c->mhd);
  return length;
}

/* The body of a reply that has none, whatever its length. */
static ssize_t read_nothing(void *self, uint64_t position, char *room, size_t size) {
  (void)self, (void)position, (void)room, (void)size;
  return MHD_CONTENT_READER_END_WITH_ERROR;
}

static struct MHD_Response *response_of(connection *c) {
  exchange_reply *r = &c->x->reply;
  if (r->status == 304) {
    return MHD_create_response_from_callback(r->size, 1, read_nothing, NULL, NULL);
  }
  if (r->source.read != NULL) {
    return MHD_create_response_from_callback(MHD_SIZE_UNKNOWN, 4096, read_source, c, NULL);
  }
  if (r->fd >= 0) return response_of_file(r);
  void *bytes = (void *)r->bytes;
  const enum MHD_ResponseMemoryMode mode =
      r->owned != NULL ? MHD_RESPMEM_MUST_FREE : MHD_RESPMEM_PERSISTENT;
  struct MHD_Response *response = MHD_create_response_from_buffer(r->size, bytes, mode);
  if (response != NULL) r->owned = NULL; /* the response frees it */
  return response;
}

/* All of them or false: without its coding, say, a body means something else. */
static bool add_fields(struct MHD_Response *response, const connection *c) {
  const exchange_reply *r = &c->x->reply;
  const char *const own[][2] = {
      {"Content-Type", *r->type != '\0' ? r->type : NULL},
      {"Content-Encoding", r->coding != CODING_IDENTITY ? coding_name(r->coding) : NULL},
      {"X-Request-Id", c->x->id},
      {"Connection", c->http->quiet || c->refused ? "close" : NULL}};
  bool good = true;
  for (size_t k = 0; k < sizeof own / sizeof *own && good; k++) {
    good = own[k][1] == NULL || MHD_add_response_header(response, own[k][0], own[k][1]) == MHD_YES;
  }
  for (int k = 0; k < r->fields && good; k++) {
    good = MHD_add_response_header(response, r->field[k].name, r->field[k].value) == MHD_YES;
  }
  return good;
}

static enum MHD_Result send_reply(connection *c) {
  struct MHD_Response *response = response_of(c);
  if (response == NULL) return MHD_NO;
  c->state = REPLYING;
  const enum MHD_Result result =
      add_fields(response, c) ? MHD_queue_response(c->mhd, (unsigned)c->x->reply.status, response)
                              : MHD_NO; /* closes */
  MHD_destroy_response(response);
  return result;
}

/* Replies in the middle of a request, where libmicrohttpd cannot: writes the reply that is set to
 * the socket as far as it goes (a problem always fits its buffer), to be closed after it. */
static void last_word(connection *c) {
  const exchange_reply *r = &c->x->reply;
  char text[4096];
  const int length = snprintf(text, sizeof text,
                              "HTTP/1.1 %d %s\r\nContent-Type: %s\r\nContent-Length: %zu\r\n"
                              "X-Request-Id: %s\r\nConnection: close\r\n\r\n%.*s",
                              r->status, problem_phrase(r->status), r->type, r->size, c->x->id,
                              (int)r->size, (const char *)r->bytes);
  c->refused = true;
  if (length <= 0 || (size_t)length >= sizeof text) return;
  const union MHD_ConnectionInfo *info =
      MHD_get_connection_info(c->mhd, MHD_CONNECTION_INFO_GNUTLS_SESSION);
  if (info != NULL) {
    tls_send(info->tls_session, text, (size_t)length);
  } else {
    send(c->fd, text, (size_t)length, MSG_NOSIGNAL | MSG_DONTWAIT);
  }
}

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
  read_head(c, method, version, &facts);
  if (exchange_find_path(c->x)) h->handler.look(h->handler.self, c->x);
  if (admit(c->x, &facts, h->set, &h->place)) h->handler.begin(h->handler.self, c->x);
  c->state = BODY;
  c->heard = loop_now();
  if (c->x->reply.status == 0 || !c->x->has_body) return MHD_YES;
  c->refused = true;
  return send_reply(c);
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
  last_word(c);
  return MHD_NO;
}

static enum MHD_Result on_request(connection *c) {
  exchange *x = c->x;
  const bool vain = c->vanished && (c->state == PENDING || x->has_body);
  if (x->reply.status == 0 && vain) return MHD_NO; /* no work for a client that has gone */
  if (x->reply.status == 0 && !spool_seal(&x->body)) {
    log_say(LOG_ERROR, "spool", "cannot close a body: %s", strerror(errno));
    exchange_refuse(x, 503, "body: it cannot be read again now");
  }
  if (x->reply.status == 0) c->http->handler.serve(c->http->handler.self, x);
  if (x->reply.status != 0) return send_reply(c);
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

/* ---- Slow clients ---- */

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
    last_word(c);
  }
  shutdown(c->fd, SHUT_RDWR); /* libmicrohttpd then closes it */
}

/* ---- When no connection can be accepted ----
 * Without a descriptor for it libmicrohttpd accepts nobody. If it has no connection, it goes on
 * trying, as fast as it is run: then its descriptor is left alone for a breath. If it has some, it
 * waits until one of them closes, however long that takes: then a connection that closes at once is
 * made for it as soon as there are descriptors again. */

static void take_breath(http *h) {
  loop_forget(h->loop, h->epoll, &h->source);
  h->breath = loop_now() + breath_seconds;
}

static void look_again(http *h) {
  h->breath = INFINITY;
  if (!loop_watch(h->loop, h->epoll, EPOLLIN, &h->source)) take_breath(h);
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

static void sweep(http *h) {
  const double now = loop_now();
  h->sweep = now + sweep_seconds;
  look_at_door(h);
  for (connection *c = h->connections; c != NULL; c = c->next) {
    if (deadline(c) <= now) time_out(c);
  }
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
  if (h->breath <= loop_now()) look_again(h);
  if (h->connections != NULL && h->sweep <= loop_now()) sweep(h);
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
  if (h->vain > PATIENCE) take_breath(h);
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
