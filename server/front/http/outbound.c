#include "outbound.h"

#include <arpa/inet.h>
#include <curl/curl.h>
#include <errno.h>
#include <math.h>
#include <netinet/in.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <unistd.h>

#include "memory_file.h"

/* A socket of libcurl's in our loop. */
typedef struct {
  outbound *owner;
  int fd;
  loop_source source;
} watched;

struct outbound_call {
  outbound_call *next, **at;
  outbound *owner;
  CURL *easy;
  struct curl_slist *fields;
  bool public_only;
  int64_t most, size;
  int fd;                      /* what came */
  bool scarce;                 /* no room to keep it, or no descriptor */
  char error[CURL_ERROR_SIZE]; /* what libcurl says; it overwrites it */
  char why[200];               /* what we say, "" if it was not us */
  char coding[32];
  void (*done)(void *context, const outbound_reply *reply);
  void *context;
};

struct outbound {
  loop *loop;
  CURLM *multi;
  double due;
  outbound_call *first;
};

/* ---- Addresses ---- */

static const struct {
  uint32_t network;
  int bits;
} special4[] = {{0x00000000, 8},  {0x0a000000, 8},  {0x64400000, 10}, {0x7f000000, 8},
                {0xa9fe0000, 16}, {0xac100000, 12}, {0xc0000000, 24}, {0xc0a80000, 16},
                {0xc6120000, 15}, {0xe0000000, 3}};

static bool is_public4(uint32_t address) {
  for (size_t k = 0; k < sizeof special4 / sizeof *special4; k++) {
    if ((address ^ special4[k].network) >> (32 - special4[k].bits) == 0) return false;
  }
  return true;
}

/* Global unicast is 2000::/3; of it, what only wraps an address of version 4 (6to4, Teredo) or is
 * for documentation is not wanted. */
static bool is_public6(const struct in6_addr *a) {
  const uint8_t *b = a->s6_addr;
  if (IN6_IS_ADDR_V4MAPPED(a)) {
    return is_public4((uint32_t)b[12] << 24 | (uint32_t)b[13] << 16 | (uint32_t)b[14] << 8 | b[15]);
  }
  const bool wraps = (b[0] == 0x20 && b[1] == 0x02) || (b[0] == 0x20 && b[1] == 0x01 && b[2] <= 1);
  return (b[0] & 0xe0) == 0x20 && !wraps && !(b[0] == 0x20 && b[1] == 1 && b[2] == 0x0d);
}

static bool is_public(const struct sockaddr *address) {
  if (address->sa_family == AF_INET) {
    return is_public4(ntohl(((const struct sockaddr_in *)address)->sin_addr.s_addr));
  }
  return address->sa_family == AF_INET6 &&
         is_public6(&((const struct sockaddr_in6 *)address)->sin6_addr);
}

/* Looks at the very address that is about to be used, so that no name can change in between. */
static curl_socket_t open_socket(void *self, curlsocktype purpose, struct curl_sockaddr *a) {
  outbound_call *c = self;
  (void)purpose;
  if (c->public_only && !is_public(&a->addr)) {
    snprintf(c->why, sizeof c->why, "its address is not a public one");
    return CURL_SOCKET_BAD;
  }
  const int fd = socket(a->family, a->socktype | SOCK_CLOEXEC, a->protocol);
  c->scarce = fd < 0 && errno != EAFNOSUPPORT;
  return fd;
}

/* Host and port of an http or https URL; length 0 if it is none. */
static size_t authority(const char *url, const char **at) {
  const size_t scheme = strncasecmp(url, "http://", 7) == 0    ? 7
                        : strncasecmp(url, "https://", 8) == 0 ? 8
                                                               : 0;
  if (scheme == 0) return 0;
  *at = url + scheme;
  const size_t length = strcspn(*at, "/?#");
  for (size_t k = 0; k < length; k++) {
    const char c = (*at)[k];
    if (c == '@' || c == '\\' || c <= ' ' || c > '~') return 0;
  }
  return length;
}

bool outbound_allows(const char *hosts, const char *url) {
  const char *host = "";
  const size_t length = authority(url, &host);
  for (const char *at = hosts; *at != '\0' && length > 0;) {
    at += strspn(at, " ,");
    const size_t step = strcspn(at, " ,");
    if (step == length && strncasecmp(at, host, length) == 0) return true;
    at += step;
  }
  return false;
}

/* ---- The end of a call ---- */

static void drop_easy(outbound_call *c) {
  if (c->easy != NULL) curl_multi_remove_handle(c->owner->multi, c->easy);
  curl_easy_cleanup(c->easy);
  c->easy = NULL;
}

static void free_call(outbound_call *c) {
  if (c->next != NULL) c->next->at = c->at;
  *c->at = c->next;
  drop_easy(c);
  curl_slist_free_all(c->fields);
  if (c->fd >= 0) close(c->fd);
  free(c);
}

static void reply_of(outbound_call *c, CURLcode code, outbound_reply *reply) {
  const char *type = NULL;
  long status = 0;
  *reply = (outbound_reply){.fd = -1};
  if (code != CURLE_OK) {
    reply->scarce = c->scarce || code == CURLE_OUT_OF_MEMORY;
    snprintf(reply->why, sizeof reply->why, "%.199s",
             *c->why != '\0'     ? c->why
             : *c->error != '\0' ? c->error
                                 : curl_easy_strerror(code));
    return;
  }
  curl_easy_getinfo(c->easy, CURLINFO_RESPONSE_CODE, &status);
  curl_easy_getinfo(c->easy, CURLINFO_CONTENT_TYPE, &type);
  reply->status = (int)status;
  snprintf(reply->type, sizeof reply->type, "%s", type != NULL ? type : "");
  memcpy(reply->coding, c->coding, sizeof reply->coding);
  reply->fd = c->fd;
  reply->size = c->size;
  c->fd = -1;
}

/* What it tells may begin and cancel others. */
static void end_call(outbound_call *c, CURLcode code) {
  outbound_reply reply;
  void (*done)(void *, const outbound_reply *) = c->done;
  void *context = c->context;
  reply_of(c, code, &reply);
  free_call(c);
  done(context, &reply);
}

static void end_calls(outbound *o) {
  int left;
  for (CURLMsg *m; (m = curl_multi_info_read(o->multi, &left)) != NULL;) {
    outbound_call *c = NULL;
    if (m->msg != CURLMSG_DONE) continue;
    curl_easy_getinfo(m->easy_handle, CURLINFO_PRIVATE, (char **)&c);
    end_call(c, m->data.result);
  }
}

static void close_multi(outbound *o) {
  if (o->multi == NULL) return;
  curl_multi_cleanup(o->multi);
  curl_global_cleanup();
  o->multi = NULL;
}

/* The first of a list, which is in none then. */
static outbound_call *take_first(outbound_call **list) {
  outbound_call *c = *list;
  *list = c->next;
  if (c->next != NULL) c->next->at = list;
  c->next = NULL;
  c->at = &c->next;
  return c;
}

/* libcurl could not tell us what to wait for (it had no memory, or we had none): it would never
 * look at its calls again, and let none begin while they are there. They fail; the next that
 * begins, even while these are told, has a new handle. */
static void give_up(outbound *o) {
  outbound_call *lost = o->first;
  for (outbound_call *c = lost; c != NULL; c = c->next) drop_easy(c);
  close_multi(o);
  o->due = INFINITY;
  o->first = NULL;
  if (lost != NULL) lost->at = &lost;
  while (lost != NULL) end_call(take_first(&lost), CURLE_OUT_OF_MEMORY);
}

/* ---- Sockets and time in our loop ---- */

static void act(outbound *o, curl_socket_t fd, int what) {
  int running;
  const CURLMcode code = curl_multi_socket_action(o->multi, fd, what, &running);
  end_calls(o);
  if (code != CURLM_OK) give_up(o);
}

static void on_ready(void *self, uint32_t events) {
  watched *w = self;
  const int what = ((events & EPOLLIN) != 0 ? CURL_CSELECT_IN : 0) |
                   ((events & EPOLLOUT) != 0 ? CURL_CSELECT_OUT : 0) |
                   ((events & (EPOLLERR | EPOLLHUP)) != 0 ? CURL_CSELECT_ERR : 0);
  act(w->owner, w->fd, what);
}

static int on_socket(CURL *easy, curl_socket_t fd, int what, void *self, void *known) {
  outbound *o = self;
  watched *w = known;
  (void)easy;
  if (w != NULL) loop_forget(o->loop, fd, &w->source);
  if (what == CURL_POLL_REMOVE) {
    free(w);
    return 0;
  }
  if (w == NULL) w = calloc(1, sizeof *w);
  if (w == NULL) return -1;
  *w = (watched){o, fd, {on_ready, w}};
  const uint32_t events =
      ((what & CURL_POLL_IN) != 0 ? EPOLLIN : 0u) | ((what & CURL_POLL_OUT) != 0 ? EPOLLOUT : 0u);
  curl_multi_assign(o->multi, fd, w);
  return loop_watch(o->loop, fd, events, &w->source) ? 0 : -1;
}

static int on_timer(CURLM *multi, long milliseconds, void *self) {
  outbound *o = self;
  (void)multi;
  o->due = milliseconds < 0 ? INFINITY : loop_now() + 1e-3 * (double)milliseconds;
  return 0;
}

static double due(void *self) {
  return ((const outbound *)self)->due;
}

static void run(void *self) {
  outbound *o = self;
  o->due = INFINITY;
  act(o, CURL_SOCKET_TIMEOUT, 0);
}

outbound *outbound_new(loop *l) {
  outbound *o = calloc(1, sizeof *o);
  if (o == NULL) return NULL;
  *o = (outbound){.loop = l, .due = INFINITY};
  loop_add(l, (loop_chore){due, run, o});
  return o;
}

/* A daemon that calls nobody needs none of it. */
static bool open_multi(outbound *o) {
  if (o->multi != NULL) return true;
  if (curl_global_init(CURL_GLOBAL_DEFAULT) != CURLE_OK) return false;
  o->multi = curl_multi_init();
  if (o->multi == NULL) {
    curl_global_cleanup();
    return false;
  }
  curl_multi_setopt(o->multi, CURLMOPT_SOCKETFUNCTION, on_socket);
  curl_multi_setopt(o->multi, CURLMOPT_SOCKETDATA, o);
  curl_multi_setopt(o->multi, CURLMOPT_TIMERFUNCTION, on_timer);
  curl_multi_setopt(o->multi, CURLMOPT_TIMERDATA, o);
  return true;
}

void outbound_free(outbound **o) {
  if (*o == NULL) return;
  for (outbound_call *c = (*o)->first, *next; c != NULL; c = next) {
    next = c->next;
    free_call(c);
  }
  close_multi(*o);
  free(*o);
  *o = NULL;
}

/* ---- A call ---- */

static size_t take_bytes(char *bytes, size_t one, size_t size, void *self) {
  outbound_call *c = self;
  (void)one;
  if (c->size + (int64_t)size > c->most) {
    snprintf(c->why, sizeof c->why, "its reply has more than %lld bytes", (long long)c->most);
    return CURL_WRITEFUNC_ERROR;
  }
  if (c->fd < 0) c->fd = memory_file("fetched");
  const ssize_t written = c->fd >= 0 ? write(c->fd, bytes, size) : -1;
  c->size += written > 0 ? written : 0;
  c->scarce = written != (ssize_t)size;
  return c->scarce ? CURL_WRITEFUNC_ERROR : size;
}

static size_t take_field(char *bytes, size_t one, size_t size, void *self) {
  outbound_call *c = self;
  static const char name[] = "content-encoding:";
  const size_t length = sizeof name - 1;
  (void)one;
  if (size > length && strncasecmp(bytes, name, length) == 0) {
    snprintf(c->coding, sizeof c->coding, "%.*s", (int)(size - length), bytes + length);
    const size_t blank = strspn(c->coding, " \t");
    memmove(c->coding, c->coding + blank, strlen(c->coding + blank) + 1);
    c->coding[strcspn(c->coding, " \t\r\n")] = '\0';
  }
  return size;
}

static bool set_up(outbound_call *c, const outbound_request *r) {
  CURL *e = c->easy = curl_easy_init();
  if (e == NULL) return false;
  for (int k = 0; k < OUTBOUND_FIELDS && r->fields[k] != NULL; k++) {
    struct curl_slist *more = curl_slist_append(c->fields, r->fields[k]);
    if (more == NULL) return false;
    c->fields = more;
  }
  if (curl_easy_setopt(e, CURLOPT_URL, r->url) != CURLE_OK) return false;
  if (curl_easy_setopt(e, CURLOPT_PROXY, "") != CURLE_OK) return false; /* copied, too */
  curl_easy_setopt(e, CURLOPT_PRIVATE, c);
  curl_easy_setopt(e, CURLOPT_PROTOCOLS_STR, "http,https");
  curl_easy_setopt(e, CURLOPT_FOLLOWLOCATION, 0L);
  curl_easy_setopt(e, CURLOPT_FRESH_CONNECT, 1L); /* each address is looked at */
  curl_easy_setopt(e, CURLOPT_FORBID_REUSE, 1L);
  curl_easy_setopt(e, CURLOPT_NOSIGNAL, 1L);
  curl_easy_setopt(e, CURLOPT_QUICK_EXIT, 1L); /* the end does not wait for the resolver's thread */
  curl_easy_setopt(e, CURLOPT_TIMEOUT_MS, (long)(1e3 * r->seconds));
  curl_easy_setopt(e, CURLOPT_USERAGENT, "scatterd");
  curl_easy_setopt(e, CURLOPT_HTTPHEADER, c->fields);
  curl_easy_setopt(e, CURLOPT_ERRORBUFFER, c->error);
  curl_easy_setopt(e, CURLOPT_WRITEFUNCTION, take_bytes);
  curl_easy_setopt(e, CURLOPT_WRITEDATA, c);
  curl_easy_setopt(e, CURLOPT_HEADERFUNCTION, take_field);
  curl_easy_setopt(e, CURLOPT_HEADERDATA, c);
  curl_easy_setopt(e, CURLOPT_OPENSOCKETFUNCTION, open_socket);
  curl_easy_setopt(e, CURLOPT_OPENSOCKETDATA, c);
  if (r->has_body) {
    curl_easy_setopt(e, CURLOPT_POST, 1L);
    curl_easy_setopt(e, CURLOPT_POSTFIELDSIZE_LARGE, (curl_off_t)r->size);
    curl_easy_setopt(e, CURLOPT_POSTFIELDS, r->size > 0 ? r->body : "");
  }
  return curl_multi_add_handle(c->owner->multi, e) == CURLM_OK;
}

outbound_call *outbound_start(outbound *o, const outbound_request *r,
                              void (*done)(void *context, const outbound_reply *reply),
                              void *context) {
  outbound_call *c = open_multi(o) ? calloc(1, sizeof *c) : NULL;
  if (c == NULL) return NULL;
  *c = (outbound_call){.next = o->first, .at = &o->first, .owner = o, .fd = -1};
  if (c->next != NULL) c->next->at = &c->next;
  o->first = c;
  c->public_only = r->public_only;
  c->most = r->most;
  c->done = done;
  c->context = context;
  if (set_up(c, r)) return c;
  free_call(c);
  return NULL;
}

void outbound_cancel(outbound_call *c) {
  free_call(c);
}
