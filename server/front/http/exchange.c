#include "exchange.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/random.h>
#include <unistd.h>

#include "model_error.h"

exchange *exchange_new(const char *target) {
  exchange *x = calloc(1, sizeof *x);
  if (x == NULL) return NULL;
  x->body = SPOOL_EMPTY;
  x->reply.fd = -1;
  x->body_most = INT64_MAX;
  x->most = token_unlimited;
  x->target = strdup(target);
  x->path = calloc(1, strlen(target) + 2); /* no path is longer, but "/" for none */
  if (x->target == NULL || x->path == NULL) exchange_free(&x);
  return x;
}

static void drop_reply(exchange_reply *r) {
  if (r->fd >= 0) close(r->fd);
  free(r->owned);
  r->fd = -1;
  r->owned = NULL;
}

void exchange_free(exchange **x) {
  if (*x == NULL) return;
  spool_close(&(*x)->body);
  drop_reply(&(*x)->reply);
  free((*x)->target);
  free((*x)->path);
  free(*x);
  *x = NULL;
}

/* ---- The request ---- */

static bool is_id(const char *text) {
  size_t length = 0;
  for (; text[length] != '\0'; length++) {
    const char c = text[length];
    if (length >= 64 || !(isalnum((unsigned char)c) || strchr("._-", c) != NULL)) return false;
  }
  return length > 0;
}

void exchange_identify(exchange *x, const char *wanted) {
  static uint64_t start, count;
  if (start == 0 && getrandom(&start, sizeof start, 0) < 0) start = (uint64_t)getpid();
  if (wanted != NULL && is_id(wanted)) {
    snprintf(x->id, sizeof x->id, "%s", wanted);
  } else {
    snprintf(x->id, sizeof x->id, "%012llx-%llx", (unsigned long long)(start & 0xffffffffffff),
             (unsigned long long)++count);
  }
}

static int hex(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Start of the path in a target; NULL if it has none. */
static const char *path_of(const char *target) {
  const size_t scheme = strncasecmp(target, "http://", 7) == 0    ? 7
                        : strncasecmp(target, "https://", 8) == 0 ? 8
                                                                  : 0;
  if (scheme == 0) return *target == '/' || strcmp(target, "*") == 0 ? target : NULL;
  const char *path = target + scheme + strcspn(target + scheme, "/?");
  return *path == '/' ? path : "/";
}

bool exchange_find_path(exchange *x) {
  if (*x->path != '\0') return true; /* it was found before; none is empty */
  const char *from = path_of(x->target);
  if (from == NULL) return false;
  char *to = x->path;
  for (; *from != '\0' && *from != '?'; from++) {
    int value = (unsigned char)*from;
    if (*from == '%') {
      const int high = hex(from[1]), low = high < 0 ? -1 : hex(from[2]);
      value = low < 0 ? 0 : 16 * high + low;
      from += 2;
    }
    if (value == 0) {
      *x->path = '\0';
      return false;
    }
    if (*from == '/' || value != '/') {
      *to++ = (char)value;
    } else { /* it belongs to its segment: RFC 3986, 2.2 */
      memcpy(to, "%2F", 3);
      to += 3;
    }
  }
  *to = '\0';
  return true;
}

/* Is all of text[0 .. length-1] among letters, digits and `others`, and is there anything? */
static bool consists_of(const char *text, size_t length, const char *others) {
  for (size_t k = 0; k < length; k++) {
    if (text[k] == '\0') return false;
    if (!isalnum((unsigned char)text[k]) && strchr(others, text[k]) == NULL) return false;
  }
  return length > 0;
}

bool exchange_is_host(const char *text) {
  size_t length = strcspn(text, ":");
  bool good = consists_of(text, length, "-._~");
  if (*text == '[') {
    length = strcspn(text, "]");
    good = text[length] == ']' && consists_of(text + 1, length - 1, ":.");
    length++;
  }
  if (!good || length > 255) return false;
  if (text[length] == '\0') return true;
  const char *port = text + length + 1;
  return text[length] == ':' && strlen(port) <= 5 && strspn(port, "0123456789") == strlen(port);
}

/* ---- The reply ---- */

static void set_reply(exchange *x, int status, const char *type) {
  drop_reply(&x->reply);
  x->reply.status = status;
  snprintf(x->reply.type_room, sizeof x->reply.type_room, "%s", type);
  x->reply.type = x->reply.type_room;
  x->reply.coding = CODING_IDENTITY;
  x->reply.bytes = "";
  x->reply.offset = x->reply.size = 0;
  x->reply.source.read = NULL;
}

void exchange_text(exchange *x, int status, const char *type, const char *text) {
  exchange_constant(x, status, type, CODING_IDENTITY, text, strlen(text));
}

void exchange_constant(exchange *x, int status, const char *type, coding how, const void *bytes,
                       size_t size) {
  set_reply(x, status, type);
  x->reply.coding = how;
  x->reply.bytes = bytes;
  x->reply.size = size;
}

void exchange_bytes(exchange *x, int status, const char *type, void *bytes, size_t size) {
  set_reply(x, status, type);
  x->reply.bytes = x->reply.owned = bytes;
  x->reply.size = size;
}

void exchange_unchanged(exchange *x, size_t size) {
  set_reply(x, 304, "");
  x->reply.size = size;
}

void exchange_pack(exchange *x, coding how, void *packed, size_t size) {
  drop_reply(&x->reply);
  x->reply.coding = how;
  x->reply.bytes = x->reply.owned = packed;
  x->reply.size = size;
}

void exchange_file(exchange *x, int status, const char *type, coding how, int fd, size_t size) {
  set_reply(x, status, type);
  x->reply.coding = how;
  x->reply.fd = fd;
  x->reply.size = size;
}

void exchange_stream(exchange *x, int status, const char *type, exchange_source source) {
  set_reply(x, status, type);
  x->reply.source = source;
}

void exchange_problem(exchange *x, const problem *p) {
  const char *type = media_type(x->plain_problem || x->model_error ? MEDIA_JSON : MEDIA_PROBLEM);
  size_t size = 0;
  char *bytes = x->model_error ? model_error_bytes(model_error_type(p->status), p->detail, &size)
                               : problem_bytes(p, &size);
  if (bytes == NULL) { /* the least that is still a problem */
    exchange_text(x, p->status, type, "{\"type\":\"about:blank\",\"title\":\"Out of memory\"}");
  } else {
    exchange_bytes(x, p->status, type, bytes, size);
  }
}

void exchange_refuse(exchange *x, int status, const char *format, ...) {
  char detail[PROBLEM_TEXT];
  problem p;
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(detail, sizeof detail, format, arguments);
  va_end(arguments);
  problem_begin(&p, status, "%s", detail);
  exchange_problem(x, &p);
}

void exchange_add(exchange *x, const char *name, const char *format, ...) {
  exchange_reply *r = &x->reply;
  if (r->fields == EXCHANGE_FIELDS) return;
  const size_t room = sizeof r->field[0].value;
  va_list arguments;
  va_start(arguments, format);
  const int length = vsnprintf(r->field[r->fields].value, room, format, arguments);
  va_end(arguments);
  if (length < 0 || (size_t)length >= room) return;
  r->field[r->fields++].name = name;
}
