/* What a request says of itself. */
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "http_inner.h"
#include "seam.h"

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

typedef struct {
  const char *name;
  char *room;
  size_t size, used;
} joint;

static enum MHD_Result join_argument(void *self, enum MHD_ValueKind kind, const char *name,
                                     const char *value) {
  joint *j = self;
  (void)kind;
  if (strcmp(name, j->name) != 0 || value == NULL || j->used >= j->size) return MHD_YES;
  j->used +=
      (size_t)snprintf(j->room + j->used, j->size - j->used, "%s%s", j->used ? "," : "", value);
  return MHD_YES;
}

const char *http_argument_list(const exchange *x, const char *name, char *room, size_t size) {
  const connection *c = x->connection;
  joint j = {name, room, size, 0};
  if (http_argument(x, name) == NULL) return NULL;
  room[0] = '\0';
  MHD_get_connection_values(c->mhd, MHD_GET_ARGUMENT_KIND, join_argument, &j);
  return j.used < size ? room : "";
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

void http_read_head(const connection *c, const char *method, const char *version, head *out) {
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
