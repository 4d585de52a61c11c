/* Replies, as libmicrohttpd wants them. */
#include <stdio.h>
#include <sys/socket.h>
#include <unistd.h>

#include "http_inner.h"
#include "tls.h"

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

enum MHD_Result http_send(connection *c) {
  struct MHD_Response *response = response_of(c);
  if (response == NULL) return MHD_NO;
  c->state = REPLYING;
  const enum MHD_Result result =
      add_fields(response, c) ? MHD_queue_response(c->mhd, (unsigned)c->x->reply.status, response)
                              : MHD_NO; /* closes */
  MHD_destroy_response(response);
  return result;
}

/* A problem always fits the buffer. */
void http_last_word(connection *c) {
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
