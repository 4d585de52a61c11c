#include "data_routes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "data.h"
#include "gate.h"
#include "http.h"
#include "job_status.h"
#include "media.h"
#include "negotiate.h"
#include "outcome.h"
#include "quota.h"
#include "range.h"

/* ---- POST /data ---- */

typedef struct {
  const service *service;
  exchange *x;
  ipc_ask ask;
  pool_task *task;     /* the check */
  data_filing *filing; /* after it */
} upload;

static void check_content(upload *u) {
  char room[512];
  exchange *x = u->x;
  const char *text = http_field(x, "Content-Type", room, sizeof room);
  if (!x->has_body) {
    exchange_refuse(x, 411, "body: got neither Content-Length nor Transfer-Encoding");
  } else if (!media_of_body(text, &u->ask.content)) {
    exchange_refuse(x, 415, "Content-Type: got \"%.100s\", needs %s, %s, %s or %s", text,
                    media_type(MEDIA_JSON), media_type(MEDIA_CBOR), media_type(MEDIA_NPY),
                    media_type(MEDIA_CSV));
  }
}

static void check_coding(upload *u) {
  char room[512];
  const char *text = http_field(u->x, "Content-Encoding", room, sizeof room);
  if (coding_of_body(text, &u->ask.content_coding)) return;
  exchange_add(u->x, "Accept-Encoding", "gzip, zstd");
  exchange_refuse(u->x, 415, "Content-Encoding: got \"%.100s\", needs one of gzip, zstd, identity",
                  text);
}

void data_begin(const service *s, exchange *x) {
  upload *u = x->task = calloc(1, sizeof *u);
  if (u == NULL) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  *u = (upload){.service = s, .x = x};
  gate_ask(s->gate, x, &u->ask);
  check_content(u);
  if (x->reply.status == 0) check_coding(u);
  if (x->reply.status == 0) (void)negotiate_json(x);
}

static void reply_object(upload *u, int status, const data_row *row) {
  char created[32], expires[32], *bytes = NULL;
  exchange *x = u->x;
  job_status_time(row->created, created);
  job_status_time(row->expires, expires);
  const int length = asprintf(
      &bytes,
      "{\"id\":\"%s\",\"href\":\"%s/data/%s\",\"type\":\"%s\",\"size\":%lld,\"created\":\"%s\","
      "\"expires\":\"%s\"}",
      row->id, x->base, row->id, row->type, (long long)row->size, created, expires);
  if (length < 0) {
    exchange_refuse(x, 503, "out of memory");
    return;
  }
  exchange_add(x, "Location", "%s/data/%s", x->base, row->id);
  exchange_bytes(x, status, media_type(MEDIA_JSON), bytes, (size_t)length);
}

static void refuse_object(exchange *x, data_result result, int64_t size) {
  static const store_result why[] = {
      [DATA_FULL] = STORE_FULL, [DATA_DOWN] = STORE_DOWN, [DATA_FAILED] = STORE_FAILED};
  if (result != DATA_QUOTA) {
    job_refuse_store(x, why[result]);
    return;
  }
  exchange_refuse(x, 507, "%lld bytes more than there is room for (limit: data-bytes%s)",
                  (long long)size, *x->owner != '\0' ? ", here or of the token" : "");
}

static void kept(void *self, data_result result, const data_row *row) {
  upload *u = self;
  exchange *x = u->x;
  if (result == DATA_NEW || result == DATA_KNOWN) {
    reply_object(u, result == DATA_NEW ? 201 : 200, row);
  } else if (result == DATA_OTHER) {
    exchange_refuse(x, 409, "these bytes are here already as %s: %s/data/%s", row->type, x->base,
                    row->id);
  } else {
    refuse_object(x, result, row->size);
  }
  http_deliver(x);
}

/* Keeps what a worker has read through. */
static void keep(upload *u, int fd, int64_t size) {
  exchange *x = u->x;
  const data_order order = {.owner = {x->owner, x->most.data_bytes},
                            .type = media_type(u->ask.content),
                            .fd = fd,
                            .size = (size_t)size,
                            .done = kept,
                            .self = u};
  data_add(u->service->data, &order, &u->filing);
}

static void checked(void *context, const pool_outcome *o) {
  upload *u = context;
  u->task = NULL;
  const bool is_good = o->end == POOL_REPLY && o->status == 200;
  const bool is_coded = u->ask.content_coding != CODING_IDENTITY;
  if (!is_good) {
    outcome_reply(u->x, &u->ask.limits, o);
    http_deliver(u->x);
  } else if (is_coded) {
    keep(u, o->fd, (int64_t)o->size);
  } else {
    if (o->fd >= 0) close(o->fd);
    keep(u, spool_take(&u->x->body), u->x->body.size);
  }
}

void data_serve(const service *s, exchange *x) {
  static const pool_calls calls = {checked, NULL};
  upload *u = x->task;
  u->ask.work = u->ask.content_coding == CODING_IDENTITY ? IPC_CHECK : IPC_RUN;
  u->ask.size = x->body.size;
  snprintf(u->ask.process, sizeof u->ask.process, "data");
  if (!quota_allows(s, x, 1)) return;
  u->task = pool_submit(s->pool, &u->ask, x->body.fd, &calls, u);
  if (u->task == NULL) outcome_refuse_full(x, s->pool, s->set->queue);
}

void data_end(const service *s, exchange *x) {
  upload *u = x->task;
  if (u == NULL) return;
  if (u->task != NULL) pool_cancel(s->pool, u->task);
  data_forget(&u->filing);
  free(u);
  x->task = NULL;
}

/* ---- GET and DELETE /data/{id} ---- */

static bool find(const service *s, exchange *x, data_row *row) {
  const store_result result = data_find(s->data, x->owner, x->item, row);
  if (result == STORE_NONE) {
    exchange_refuse(x, 404, "there is no data %.70s; it may have expired", x->item);
  } else if (result != STORE_OK) {
    job_refuse_store(x, result);
  }
  return result == STORE_OK;
}

static bool is_known(const exchange *x, const char *tag) {
  char room[512];
  const char *known = http_field(x, "If-None-Match", room, sizeof room);
  return known != NULL && (strcmp(known, "*") == 0 || strstr(known, tag) != NULL);
}

void data_get(const service *s, exchange *x) {
  data_row row;
  char tag[DATA_ID + 2], room[512];
  if (!find(s, x, &row)) return;
  const char *accept = http_field(x, "Accept", room, sizeof room);
  if (media_quality(accept, row.type) <= 0) {
    exchange_refuse(x, 406, "Accept: got \"%.100s\", needs %s among it", accept, row.type);
    return;
  }
  snprintf(tag, sizeof tag, "\"%s\"", row.id);
  exchange_add(x, "ETag", "%s", tag);
  exchange_add(x, "Cache-Control", "private, immutable, max-age=86400");
  exchange_add(x, "X-Content-Type-Options", "nosniff"); /* it is what somebody uploaded */
  if (is_known(x, tag)) {
    exchange_unchanged(x, (size_t)row.size);
    return;
  }
  const int fd = data_open(s->data, &row);
  if (fd < 0) {
    job_refuse_store(x, store_is_up(s->store) ? STORE_FAILED : STORE_DOWN);
    return;
  }
  exchange_file(x, 200, row.type, CODING_IDENTITY, fd, (size_t)row.size);
  range_apply(x, tag);
}

void data_delete(const service *s, exchange *x) {
  data_row row;
  if (!find(s, x, &row)) return;
  const store_result result = data_drop(s->data, &row);
  if (result == STORE_OK || result == STORE_NONE) {
    exchange_text(x, 204, "", "");
  } else if (result == STORE_FULL) {
    exchange_refuse(x, 409, "data %s is needed by a job that waits or runs", row.id);
  } else {
    job_refuse_store(x, result);
  }
}
